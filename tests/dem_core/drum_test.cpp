// Spheres in a turning drum, primitive and of triangles.
#include <gtest/gtest.h>

#include "mesh_walls.hpp"

namespace repose::dem {
namespace {

constexpr double kRate = 4.0;  // rad/s, about z; gravity along -y, periodic along z

scene::Case drum(const scene::Wall& shell) {
  scene::Case c = empty_case({.youngs_modulus = 1e6, .mu_s = 0.5, .mu_r = 0.05});
  c.gravity_m_s2 = {0, -9.81, 0};
  c.lower_m = {-0.06, -0.06, 0.0};
  c.upper_m = {0.06, 0.06, 0.03};
  c.periodic.z = true;
  c.walls = {shell};
  c.motions = {
      {.walls = {shell.name}, .path = scene::Rotation{.axis = {0, 0, 1}, .rate_rad_s = kRate}}};
  RandomStream random(9);
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 5; ++i)
        c.particles.push_back(grain(random.uniform(0.002, 0.0028),
                                    {-0.021 + 0.006 * k, -0.03 + 0.006 * j, 0.003 + 0.006 * i}));
  return c;
}

/// What is summed over intervals of a few steps.
struct Balance {
  double wall = 0.0;           // impulse of the torque of the wall on the particles about z, N m s
  double gravity = 0.0;        // that of gravity
  double gained = 0.0;         // angular momentum
  double work = 0.0;           // of the wall
  std::vector<double> torque;  // mean of the wall in each tenth of the time, N m
};

double angular_momentum(const std::vector<Sphere>& spheres) {
  double sum = 0.0;
  for (const Sphere& s : spheres)
    sum += s.mass_kg * (s.position.x() * s.velocity.y() - s.position.y() * s.velocity.x() +
                        0.4 * s.radius_m * s.radius_m * s.angular_velocity.z());
  return sum;
}

double torque_of_gravity(const std::vector<Sphere>& spheres) {
  double sum = 0.0;
  for (const Sphere& s : spheres) sum -= s.mass_kg * 9.81 * s.position.x();
  return sum;
}

Balance turn(const scene::Wall& shell, double settle_s, int intervals) {
  Simulation sim(drum(shell));
  while (sim.time_s() < settle_s) sim.step();
  sim.take_wall_loads();
  Balance balance;
  auto spheres = sim.spheres();
  balance.gained = -angular_momentum(spheres);
  const int steps = 10;
  const double span = steps * sim.time_step_s();
  double block = 0.0;
  for (int k = 0; k < intervals; ++k) {
    balance.gravity += 0.5 * span * torque_of_gravity(spheres);
    sim.step(steps);
    spheres = sim.spheres();
    balance.gravity += 0.5 * span * torque_of_gravity(spheres);
    const WallLoad load = sim.take_wall_loads()[0];
    balance.wall -= load.torque_n_m.z() * span;
    balance.work += load.work_j;
    block -= load.torque_n_m.z() / (0.1 * intervals);
    if ((k + 1) % (intervals / 10) == 0) {
      balance.torque.push_back(block);
      block = 0.0;
    }
  }
  balance.gained += angular_momentum(spheres);
  return balance;
}

const scene::Wall kShell = cone_wall("shell", {0, 0, -0.01}, {0, 0, 0.04}, 0.05, 0.05);

TEST(Drum, TorqueOnItBalancesGravityAndIsItsPowerOverItsRate) {
  const Balance balance = turn(kShell, 1.0, 1500);
  EXPECT_GT(balance.wall, 0.0);
  EXPECT_NEAR(balance.work, balance.wall * kRate, 1e-12 * balance.work);
  // Both sides by sums over ten steps, trapezoids of a smooth function: far below a thousandth.
  EXPECT_NEAR(balance.wall + balance.gravity, balance.gained, 1e-3 * balance.wall);
}

TEST(Drum, OfTrianglesTakesTheSameTorqueAsThePrimitive) {
  const Balance exact = turn(kShell, 1.0, 3000);
  const Balance mesh =
      turn(mesh_wall("shell", frustum_triangles(-0.01, 0.04, 0.05, 0.05, 180, 6)), 1.0, 3000);
  EXPECT_NEAR(mesh.work, mesh.wall * kRate, 1e-12 * mesh.work);
  EXPECT_NEAR(mesh.wall + mesh.gravity, mesh.gained, 1e-3 * mesh.wall);
  // Two chaotic runs: their means over ten blocks of about 0.2 s, which is more than a turn-over of
  // the layer, differ by less than four standard errors of the difference.
  const auto mean_and_error = [](const std::vector<double>& values) {
    double mean = 0.0, square = 0.0;
    for (const double v : values) mean += v / static_cast<double>(values.size());
    for (const double v : values) square += (v - mean) * (v - mean);
    const auto n = static_cast<double>(values.size());
    return std::pair{mean, std::sqrt(square / (n - 1) / n)};
  };
  const auto [a, error_a] = mean_and_error(exact.torque);
  const auto [b, error_b] = mean_and_error(mesh.torque);
  EXPECT_NEAR(a, b, 4.0 * std::hypot(error_a, error_b));
  EXPECT_LT(4.0 * std::hypot(error_a, error_b), 0.2 * a);  // sharp enough to mean something
}

}  // namespace
}  // namespace repose::dem

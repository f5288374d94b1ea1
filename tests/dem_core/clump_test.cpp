#include <gtest/gtest.h>

#include "insertion/placement.hpp"
#include "particles/rotation.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/dem/cross.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

/// Two equal spheres whose centres are `distance` radii apart.
scene::ClumpShape dumbbell(double distance) {
  return {"dumbbell", {{{0, 0, 0}, 1.0}, {{distance, 0, 0}, 1.0}}};
}
scene::ClumpShape lopsided() {
  return {"lopsided", {{{0, 0, 0}, 1.0}, {{1.1, 0.2, 0}, 0.8}, {{0.3, 0.9, 0.4}, 0.6}}};
}

scene::Particle clump(const std::string& shape, double radius, const Vec3& position,
                      const Vec3& velocity = Vec3::Zero(),
                      const Vec3& angular_velocity = Vec3::Zero()) {
  scene::Particle particle = grain(radius, position, velocity, angular_velocity);
  particle.clump = shape;
  return particle;
}

TEST(FreeRotation, KeepsAngularMomentumAndFollowsTheClosedFormOfASymmetricTop) {
  // Axial moment C about body axis 0, A across: in the world the axis precesses about L with |L|/A.
  const double a = 2.0, c = 1.0;
  const Vec3 inertia(c, a, a);
  const Vec3 l(0.3, 0.0, 1.0);
  const double duration = 5.0;
  double error[2];
  for (int level = 0; level < 2; ++level) {
    const int steps = 500 << level;
    Quaternion q;  // body axes along the world's
    for (int k = 0; k < steps; ++k) q = free_rotation(q, l, inertia, duration / steps);
    const Vec3 axis = rotation_matrix(q).col(0);
    const Vec3 n = l.normalized();
    const double angle = l.norm() / a * duration;
    const Vec3 start = Vec3::UnitX();
    const Vec3 expected = start.dot(n) * n + std::cos(angle) * (start - start.dot(n) * n) +
                          std::sin(angle) * cross(n, start);
    error[level] = (axis - expected).norm();
    EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1.0, 1e-14);
  }
  EXPECT_LT(error[0], 1e-4);
  EXPECT_NEAR(error[0] / error[1], 4.0, 0.1);  // second order
}

TEST(FreeRotation, OfAnAsymmetricBodyDoesNotDriftInEnergy) {
  const Vec3 inertia(1.0, 1.5, 2.2);
  const Vec3 l(0.1, 1.0, 0.2);  // close to the unstable middle axis: it tumbles
  Quaternion q;
  const auto energy = [&] {
    const Vec3 p = rotation_matrix(q).transpose() * l;
    return 0.5 * p.dot(p.cwiseQuotient(inertia));
  };
  const double before = energy();
  double largest_early = 0.0, largest_late = 0.0, least_middle = 1.0;
  for (int k = 0; k < 200000; ++k) {
    q = free_rotation(q, l, inertia, 0.01);
    double& largest = k < 20000 ? largest_early : largest_late;
    largest = std::max(largest, std::abs(energy() - before));
    least_middle = std::min(least_middle, (rotation_matrix(q).transpose() * l).y());
  }
  EXPECT_LT(least_middle, -0.9);  // it did turn over
  EXPECT_LT(largest_late, 1.01 * largest_early);
  EXPECT_LT(largest_early, 1e-5 * before);
}

TEST(FreeRotation, IsReversible) {
  const Vec3 inertia(1.0, 1.5, 2.2);
  const Vec3 l(0.4, 1.0, -0.7);
  Quaternion q = quaternion_of({0.3, -0.5, 0.7, 0.2});
  const Quaternion start = q;
  for (int k = 0; k < 100; ++k) q = free_rotation(q, l, inertia, 0.05);
  for (int k = 0; k < 100; ++k) q = free_rotation(q, -l, inertia, 0.05);
  EXPECT_LT((rotation_matrix(q) - rotation_matrix(start)).norm(), 1e-12);
}

TEST(FreeRotation, OfSeveralBodiesGivesTheBitsOfEachAlone) {
  RotatingBody bodies[kRotatingTogether];
  RandomStream random(5);
  for (RotatingBody& body : bodies) {
    body.q = quaternion_of({random.normal(), random.normal(), random.normal(), random.normal()});
    body.l = Vec3(random.normal(), random.normal(), random.normal());
    body.inertia = Vec3(random.uniform(1.0, 2.0), random.uniform(1.0, 2.0), 2.5);
  }
  RotationEnd ends[kRotatingTogether];
  free_rotation(bodies, 0.05, ends);
  for (std::size_t k = 0; k < kRotatingTogether; ++k) {
    const RotatingBody& body = bodies[k];
    const RotationEnd& end = ends[k];
    const Quaternion alone = free_rotation(body.q, body.l, body.inertia, 0.05);
    EXPECT_EQ(end.q.w, alone.w);
    EXPECT_EQ(end.q.x, alone.x);
    EXPECT_EQ(end.q.y, alone.y);
    EXPECT_EQ(end.q.z, alone.z);
    const Eigen::Matrix3d half = rotation_matrix(quaternion_of(
        {body.q.w + end.q.w, body.q.x + end.q.x, body.q.y + end.q.y, body.q.z + end.q.z}));
    EXPECT_LT((rotation_matrix(end.half) - half).norm(), 1e-14);
    const Vec3 momentum = half.transpose() * body.l;
    EXPECT_LT((end.spin - half * momentum.cwiseQuotient(body.inertia)).norm(), 1e-14 * 10.0);
  }
}

TEST(RandomOrientation, TurnsADirectionToAllSidesAlike) {
  RandomStream random(11);
  Vec3 mean = Vec3::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  const int n = 20000;
  for (int k = 0; k < n; ++k) {
    const Vec3 d =
        rotation_matrix(quaternion_of(random_orientation(random))) * Vec3(1, 2, -2).normalized();
    mean += d / n;
    second += d * d.transpose() / n;
  }
  // A component has variance 1/3, a product of two at most 1/5; five standard errors of nine.
  EXPECT_LT(mean.norm(), 5.0 * std::sqrt(1.0 / n));
  EXPECT_LT((second - Eigen::Matrix3d::Identity() / 3.0).norm(), 5.0 * std::sqrt(9.0 * 0.2 / n));
}

TEST(Clump, FliesAndTumblesWithItsEnergyAndMomenta) {
  scene::Case c = empty_case({});
  c.clumps = {lopsided()};
  c.particles = {clump("lopsided", 0.01, {0, 0, 0}, {0.3, -0.2, 0.1}, {20, 30, -10})};
  Simulation sim(c);
  const Body start = sim.bodies()[0];
  EXPECT_EQ(start.spheres, 3);
  EXPECT_NEAR(start.mass_kg, sphere_mass(0.01, 2500.0), 1e-15);
  EXPECT_LT((start.velocity - Vec3(0.3, -0.2, 0.1)).norm(), 1e-15);
  EXPECT_LT((start.angular_velocity - Vec3(20, 30, -10)).norm(), 1e-12);
  sim.step(20000);
  const Body end = sim.bodies()[0];
  EXPECT_LT((end.position - sim.time_s() * Vec3(0.3, -0.2, 0.1)).norm(), 1e-12);
  EXPECT_LT((end.angular_momentum() - start.angular_momentum()).norm(),
            1e-13 * start.angular_momentum().norm());
  EXPECT_NEAR(end.kinetic_energy_j(), start.kinetic_energy_j(), 1e-6 * start.kinetic_energy_j());
  EXPECT_GT((end.angular_velocity - start.angular_velocity).norm(), 5.0);  // it did tumble
}

TEST(Clump, SpheresMoveAsPartsOfARigidBody) {
  scene::Case c = empty_case({});
  c.clumps = {lopsided()};
  c.particles = {clump("lopsided", 0.01, {0, 0, 0}, {0.3, -0.2, 0.1}, {20, 30, -10})};
  Simulation sim(c);
  const auto before = sim.spheres();
  sim.step(5000);
  const auto after = sim.spheres();
  const Body body = sim.bodies()[0];
  double mass = 0.0;
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(after[s].body, 0);
    EXPECT_NEAR((after[s].position - after[(s + 1) % 3].position).norm(),
                (before[s].position - before[(s + 1) % 3].position).norm(), 1e-14);
    EXPECT_LT((after[s].velocity - body.velocity -
               cross(body.angular_velocity, after[s].position - body.position))
                  .norm(),
              1e-12);
    mass += after[s].mass_kg;
  }
  EXPECT_NEAR(mass, body.mass_kg, 1e-16);
}

TEST(Clump, OfOneSphereIsThatSphereBitForBit) {
  scene::Case c = empty_case({.mu_s = 0.4, .mu_r = 0.05});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor_plane()};
  c.clumps = {{"ball", {{{1, 2, 3}, 7.0}}}};
  const auto final_state = [&](const std::string& shape) {
    c.particles = {clump(shape, 0.01, {0, 0, 0.012}, {0.3, 0, 0}, {0, 5, 1})};
    Simulation sim(c);
    sim.step(20000);
    return sim.spheres()[0];
  };
  const Sphere sphere = final_state("");
  const Sphere ball = final_state("ball");
  EXPECT_EQ(sphere.position, ball.position);
  EXPECT_EQ(sphere.angular_velocity, ball.angular_velocity);
}

TEST(Clump, HeadOnImpactHasTheRestitutionOfItsPair) {
  // Central impact through both centres of a dumbbell: m* is that of the whole bodies.
  scene::Case c = empty_case({.restitution = 0.6});
  c.clumps = {dumbbell(1.2)};
  scene::Particle hit = clump("dumbbell", 0.01, {0.03, 0, 0}, {-0.5, 0, 0});
  c.particles = {clump("dumbbell", 0.01, {-0.03, 0, 0}, {0.5, 0, 0}), hit};
  Simulation sim(c);
  sim.step();
  while (sim.bodies()[0].velocity.x() > -0.2 || sim.contacts() > 0) sim.step(50);
  EXPECT_NEAR(sim.bodies()[0].velocity.x(), -0.3, 3e-3);
  EXPECT_NEAR(sim.bodies()[1].velocity.x(), 0.3, 3e-3);
}

TEST(Clump, OffCentreImpactKeepsMomentumAngularMomentumAndEnergy) {
  scene::Case c = empty_case({.restitution = 1.0});
  c.clumps = {lopsided()};
  c.time_step_rayleigh_fraction = 0.02;
  c.particles = {clump("lopsided", 0.01, {-0.02, 0.004, 0.001}, {0.5, 0, 0}, {0, 3, 9}),
                 grain(0.012, {0.02, 0, 0}, {-0.5, 0, 0}, {1, 0, 0})};
  Simulation sim(c);
  struct Totals {
    Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
    double energy = 0.0;
  };
  const auto totals = [&] {
    Totals t;
    for (const Body& b : sim.bodies()) {
      t.momentum += b.mass_kg * b.velocity;
      t.angular += b.angular_momentum() + b.mass_kg * cross(b.position, b.velocity);
      t.energy += b.kinetic_energy_j();
    }
    return t;
  };
  const Totals before = totals();
  bool touched = false;
  for (int k = 0; k < 60000; ++k) {
    sim.step();
    touched = touched || sim.contacts() > 0;
  }
  ASSERT_TRUE(touched);
  ASSERT_EQ(sim.contacts(), 0u);
  const Totals after = totals();
  const double p = sim.bodies()[0].mass_kg * 0.5;
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * p);
  // Kicks at t with arms of t are exact in angular momentum but for the half step of the drift.
  EXPECT_LT((after.angular - before.angular).norm(), 1e-6 * p * 0.01);
  EXPECT_NEAR(after.energy, before.energy, 1e-4 * before.energy);
}

TEST(Clump, RestsWithItsWeightSharedByItsSpheres) {
  scene::Case c = empty_case({.restitution = 0.3, .mu_s = 0.5, .mu_r = 0.05});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor_plane()};
  c.clumps = {dumbbell(1.5)};
  c.particles = {clump("dumbbell", 0.01, {0, 0, 0.009})};
  Simulation sim(c);
  while (sim.time_s() < 0.5) sim.step(100);
  EXPECT_EQ(sim.contacts(), 2u);
  const auto spheres = sim.spheres();
  const double r = spheres[0].radius_m;
  const double e_eff = 1e8 / (2.0 * (1.0 - 0.0625));
  const double d = hertz_overlap(e_eff, r, 0.5 * sphere_mass(0.01, 2500.0) * 9.81);
  for (const Sphere& s : spheres) {
    EXPECT_NEAR(s.position.z(), r - d, 1e-3 * d);
    EXPECT_LT(s.velocity.norm(), 1e-6);
  }
}

TEST(Clump, CrossesAPeriodicSideInOnePiece) {
  scene::Case c = empty_case({});
  c.lower_m = {-1, 0, -1};
  c.upper_m = {1, 0.1, 1};
  c.periodic.y = true;
  c.clumps = {lopsided()};
  c.particles = {clump("lopsided", 0.01, {0, 0.05, 0}, {0, 1, 0}, {30, 0, 20})};
  Simulation sim(c);
  const Vec3 l = sim.bodies()[0].angular_momentum();
  while (sim.time_s() < 0.27) sim.step(10);  // three crossings
  const Body body = sim.bodies()[0];
  EXPECT_NEAR(body.position.y(), 0.05 + sim.time_s() - 0.3, 1e-9);
  EXPECT_LT((body.angular_momentum() - l).norm(), 1e-12 * l.norm());
  EXPECT_EQ(sim.contacts(), 0u);  // spheres on both sides of the period do not touch each other
  for (const Sphere& s : sim.spheres()) {
    EXPECT_GE(s.position.y(), 0.0);
    EXPECT_LT(s.position.y(), 0.1);
  }
}

TEST(Clump, CarriedByATurntableStaysWhereItIs) {
  // Velocities, arms and the wall's motion all belong to the half step, so that what turns with the
  // table does not slip; taking some of them at the end of the step lets it creep by Omega^2 dt/2.
  scene::Case c = empty_case({.youngs_modulus = 1e6, .restitution = 0.3, .mu_s = 0.9, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor_plane()};
  const double rate = 5.0;
  c.motions = {
      {.walls = {"floor"}, .path = scene::Rotation{.axis = {0, 0, 1}, .rate_rad_s = rate}}};
  scene::Particle flat = clump("sinter_3", 0.01, {0.05, 0, 0.007});
  flat.orientation_wxyz = {1, 0, 0, 0};  // the axis of the largest moment is the third
  flat.velocity = {0, rate * 0.05, 0};
  flat.angular_velocity = {0, 0, rate};
  c.particles = {flat};
  Simulation sim(c);
  while (sim.time_s() < 0.3) sim.step(10);  // settled
  const auto radius = [&] { return sim.bodies()[0].position.head<2>().norm(); };
  const double before = radius();
  const double start = sim.time_s();
  while (sim.time_s() < start + 1.0) sim.step(10);
  const double creep = rate * rate * 0.5 * sim.time_step_s();  // per second, of the radius
  EXPECT_LT(std::abs(radius() / before - 1.0), 0.02 * creep);
}

TEST(Clump, InASettledHeapNothingDependsOnTheRun) {
  scene::Case c = empty_case({.restitution = 0.4, .mu_s = 0.5, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.lower_m.setConstant(-0.5);
  c.upper_m.setConstant(0.5);
  c.walls = scene::box_walls("bin", "wall", {-0.05, -0.05, 0}, {0.05, 0.05, 0.4}, {"+z"});
  scene::Layer layer{0.25,
                     {{.material = "grain",
                       .clump = "sinter_3",
                       .mass_fraction = 0.6,
                       .sizes = std::vector<scene::SizeClass>{{0.012, 0.016, 1.0}}},
                      {.material = "grain",
                       .mass_fraction = 0.4,
                       .sizes = std::vector<scene::SizeClass>{{0.01, 0.01, 1.0}}}}};
  c.fill = scene::Fill{{-0.05, -0.05, 0}, {0.05, 0.05, 0.4}, 0.2, {layer}};
  const auto settle = [&] {
    Simulation sim(c);
    EXPECT_NEAR(sim.mass_kg(), 0.25, sphere_mass(0.008, 2500.0));
    while (sim.time_s() < 0.4) sim.step(500);
    return sim.spheres();
  };
  const auto first = settle();
  const auto second = settle();
  ASSERT_EQ(first.size(), second.size());
  double highest = 0.0;
  for (std::size_t s = 0; s < first.size(); ++s) {
    EXPECT_EQ(first[s].position, second[s].position);
    highest = std::max(highest, first[s].position.z());
    EXPECT_GT(first[s].position.z(), 0.0);
  }
  EXPECT_LT(highest, 0.06);  // 0.25 kg at half its density fills 2 cm
}

TEST(Clump, LongerThanHalfAPeriodIsRefused) {
  scene::Case c = empty_case({});
  c.lower_m = {-1, 0, -1};
  c.upper_m = {1, 0.06, 1};
  c.periodic.y = true;
  c.clumps = {dumbbell(1.9)};
  c.particles = {clump("dumbbell", 0.012, {0, 0.03, 0})};
  EXPECT_THROW(Simulation{c}, InputError);
  c.particles[0].radius_m = 0.005;
  EXPECT_NO_THROW(Simulation{c});
}

TEST(Clump, ThatLeavesIsNamedAtItsCentre) {
  scene::Case c = empty_case({});
  c.gravity_m_s2.z() = -9.81;
  c.particles = {clump("sinter_3", 0.01, {1, 2, -9.9})};
  Simulation sim(c);
  try {
    while (sim.time_s() < 1.0) sim.step();
    FAIL();
  } catch (const SimulationError& error) {
    EXPECT_NE(std::string(error.what()).find("clump 0 left the domain at (1, 2, -10"),
              std::string::npos)
        << error.what();
  }
}

TEST(Clump, OfAnUnknownShapeNamesTheKnownOnes) {
  scene::Case c = empty_case({});
  c.particles = {clump("cube", 0.01, {0, 0, 0})};
  try {
    Simulation sim(c);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("sinter_3"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace repose::dem

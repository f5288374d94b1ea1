// Meshes against primitives, and what acts on moving walls.
#include <cmath>
#include <numbers>

#include "../dem_core/mesh_walls.hpp"
#include "check.hpp"
#include "geometry/facet.hpp"
#include "repose/dem/simulation.hpp"

namespace repose::physics {
namespace {

using namespace repose::dem;

constexpr double kRadius = 0.01;

/// A sphere that falls obliquely onto a floor, bounces, slips and rolls across
/// its middle.
Sphere rolled_over(const scene::Wall& floor) {
  scene::Case c = empty_case({.restitution = 0.4, .mu_s = 0.5, .mu_r = 0.02});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor};
  c.particles = {grain(kRadius, {-0.05, 0.013, 0.012}, {0.5, 0.02, 0})};
  Simulation sim(c);
  while (sim.time_s() < 0.4) sim.step();
  return sim.spheres()[0];
}

void add_floor(std::vector<Check>& checks) {
  const Sphere expected =
      rolled_over(rectangle("floor", {-0.2, -0.2, 0}, {0.4, 0, 0}, {0, 0.4, 0}));
  checks.push_back({"a sphere slips and rolls across a rectangle: way along x",
                    expected.position.x(), 0.05, 0.0, "m", Demand::at_least});
  struct Cut {
    const char* words;
    int n;
    double disorder;
  };
  for (const Cut cut : {Cut{"2", 1, 0.0}, Cut{"128", 8, 0.0}, Cut{"3,200 irregular", 40, 0.45},
                        Cut{"51,200 irregular", 160, 0.3}}) {
    const Sphere sphere = rolled_over(
        mesh_wall("floor", floor_triangles(-0.2, 0.2, -0.2, 0.2, cut.n, cut.n, cut.disorder)));
    checks.push_back({std::string("the same over ") + cut.words +
                          " coplanar triangles: distance of the two after 0.4 s",
                      (sphere.position - expected.position).norm(), 0.0, 1e-12, "m",
                      Demand::at_most});
  }
}

/// A sphere thrown into a corner region of a box.
std::vector<Vec3> rebounds(const std::vector<scene::Wall>& walls) {
  scene::Case c = empty_case({.restitution = 0.7, .mu_s = 0.3});
  c.gravity_m_s2 = {0, 0, -9.81};
  c.walls = walls;
  const Vec3 middle(0.05, 0.05, 0.05);
  // Towards a face, along an edge, into a corner; and from outside onto an edge
  // and a corner.
  for (const Vec3& x : {Vec3(0.05, 0.05, 0.03), Vec3(0.015, 0.05, 0.02), Vec3(0.02, 0.02, 0.02)})
    c.particles.push_back(grain(0.004, x, 3.0 * (x - middle) + Vec3(0.1, 0.03, -0.5)));
  for (const Vec3& x : {Vec3(-0.02, 0.051, -0.02), Vec3(0.12, 0.12, 0.12)})
    c.particles.push_back(grain(0.004, x, (middle - x) * 10.0));
  Simulation sim(c);
  std::vector<Vec3> path;
  for (int k = 0; k < 20; ++k) {
    const double until = 0.005 * (k + 1);
    while (sim.time_s() < until) sim.step();
    for (const Sphere& sphere : sim.spheres()) path.push_back(sphere.position);
  }
  return path;
}

void add_box(std::vector<Check>& checks) {
  const Vec3 upper = Vec3::Constant(0.1);
  const auto expected = rebounds(scene::box_walls("box", "wall", Vec3::Zero(), upper, {}));
  for (const int n : {1, 6}) {
    const auto path = rebounds({mesh_wall("mesh", scene::box_triangles(Vec3::Zero(), upper, n))});
    double largest = path.size() == expected.size() ? 0.0 : 1.0;
    for (std::size_t k = 0; k < std::min(path.size(), expected.size()); ++k)
      largest = std::max(largest, (path[k] - expected[k]).norm());
    checks.push_back({std::to_string(12 * n * n) +
                          " triangles against six rectangles: largest distance of five "
                          "spheres that "
                          "rebound at faces, edges and corners, in and out, over 0.1 s",
                      largest, 0.0, 1e-9, "m", Demand::at_most});
  }
}

/// A way for a sphere to roll on a surface of revolution about z.
struct Course {
  double r0, r1;  // of the frustum, which is 0.3 m high
  Vec3 gravity;
  bool inside;
  double height;  // of the start
  double turn;    // of the start about z, from -y
  Vec3 speed;     // along the turn, 0, upwards

  scene::Wall surface() const { return cone_wall("w", {0, 0, 0}, {0, 0, 0.3}, r0, r1); }
  scene::Wall mesh(int n) const {
    return mesh_wall("w", frustum_triangles(0, 0.3, r0, r1, n, std::max(1, n / 20)));
  }
};

/// Its positions every 5 ms for 0.2 s.
std::vector<Vec3> path_along(const scene::Wall& wall, const Course& course) {
  scene::Case c = empty_case({.youngs_modulus = 1e7, .restitution = 0.5, .mu_s = 0.5});
  c.gravity_m_s2 = course.gravity;
  c.walls = {wall};
  const double slope = std::atan((course.r1 - course.r0) / 0.3);
  const double off = (course.inside ? -1.0 : 1.0) * kRadius / std::cos(slope);
  const double rho = course.r0 + (course.r1 - course.r0) * course.height / 0.3 + off;
  const Vec3 outwards(std::sin(course.turn), -std::cos(course.turn), 0);
  const Vec3 onwards(std::cos(course.turn), std::sin(course.turn), 0);
  const Vec3 v = course.speed.x() * onwards + Vec3(0, 0, course.speed.z());
  Vec3 normal = (std::cos(slope) * outwards - Vec3(0, 0, std::sin(slope)));
  if (!course.inside) normal = -normal;
  c.particles = {grain(kRadius, rho * outwards + Vec3(0, 0, course.height), v,
                       cross(v, normal) / kRadius)};  // rolling
  Simulation sim(c);
  std::vector<Vec3> path;
  for (int k = 0; k < 40; ++k) {
    while (sim.time_s() < 0.005 * (k + 1)) sim.step();
    path.push_back(sim.spheres()[0].position);
  }
  return path;
}

struct PathError {
  double along = 0.0;   // root of the mean square over starts of the largest
                        // distance of two paths
  double across = 0.0;  // largest difference of the distances from the surface
};

PathError path_error(Course course, int n) {
  PathError error;
  const int starts = 3;
  const Facet surface = revolved_facet({0, 0, 0}, {0, 0, 1}, course.r0, course.r1, 0.3);
  for (int s = 0; s < starts; ++s) {
    const auto exact = path_along(course.surface(), course);
    const auto path = path_along(course.mesh(n), course);
    double largest = 0.0;
    for (std::size_t k = 0; k < path.size(); ++k) {
      largest = std::max(largest, (path[k] - exact[k]).norm());
      error.across = std::max(error.across, std::abs(closest_point(surface, path[k]).distance -
                                                     closest_point(surface, exact[k]).distance));
    }
    error.along += largest * largest / starts;
    course.turn += 0.0123;  // elsewhere on the strips
  }
  error.along = std::sqrt(error.along);
  return error;
}

/// Halving the strips twice divides both errors by 16, if they go with the
/// square; what the sphere loses in the small impacts at concave edges scatters
/// about that.
void add_course(const std::string& words, const Course& course, std::vector<Check>& checks) {
  const PathError coarse = path_error(course, 180);
  const PathError fine = path_error(course, 720);
  const double sagitta = 0.1 * (1 - std::cos(std::numbers::pi / 180));
  checks.push_back({words + ", 180 strips: largest deviation from the surface "
                            "over the chord's sagitta",
                    coarse.across / sagitta, 3.0, 0.0, "", Demand::at_most});
  checks.push_back({words + ", 720 strips: deviation of the path after a dozen radii",
                    fine.along / kRadius, 3e-3, 0.0, "radii", Demand::at_most});
  checks.push_back({words + ": fall of the path's error from 180 to 720 strips "
                            "(16 is second order)",
                    coarse.along / fine.along, 10.0, 0.0, "", Demand::at_least});
  checks.push_back({words + ": fall of the deviation from the surface", coarse.across / fine.across,
                    10.0, 0.0, "", Demand::at_least});
}

void add_courses(std::vector<Check>& checks) {
  add_course("rolling inside a cylinder",
             {.r0 = 0.1,
              .r1 = 0.1,
              .gravity = {0, -9.81, 0},
              .inside = true,
              .height = 0.1,
              .turn = 0.7,
              .speed = {0, 0, 0.1}},
             checks);
  add_course("rolling on a cylinder",
             {.r0 = 0.1,
              .r1 = 0.1,
              .gravity = {0, 9.81, 0},
              .inside = false,
              .height = 0.1,
              .turn = 0.05,
              .speed = {0.3, 0, 0.1}},
             checks);
  add_course("rolling inside a cone",
             {.r0 = 0.01,
              .r1 = 0.16,
              .gravity = {0, 0, -9.81},
              .inside = true,
              .height = 0.15,
              .turn = 0.0,
              .speed = {0.6, 0, 0.0}},
             checks);
}

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

struct Mean {
  double value, error;
};
Mean mean_of(const std::vector<double>& values) {
  double mean = 0.0, square = 0.0;
  const auto n = static_cast<double>(values.size());
  for (const double v : values) mean += v / n;
  for (const double v : values) square += (v - mean) * (v - mean);
  return {mean, std::sqrt(square / (n - 1.0) / n)};
}

}  // namespace

std::vector<Check> meshes(Extent) {
  std::vector<Check> checks;
  add_floor(checks);
  add_box(checks);
  add_courses(checks);
  return checks;
}

std::vector<Check> drums(Extent extent) {
  const int intervals = extent == Extent::quick ? 3000 : 12000;
  const Balance exact = turn(kShell, 1.0, intervals);
  const Balance mesh =
      turn(mesh_wall("shell", frustum_triangles(-0.01, 0.04, 0.05, 0.05, 180, 6)), 1.0, intervals);
  std::vector<Check> checks;
  const auto balanced = [&](const std::string& words, const Balance& b) {
    checks.push_back({words + ": work over torque and rate, less one",
                      std::abs(b.work / (b.wall * kRate) - 1.0), 0.0, 1e-12, "", Demand::at_most});
    checks.push_back({words + ": torques of wall and gravity less the angular "
                              "momentum gained, over the "
                              "wall's",
                      std::abs(b.wall + b.gravity - b.gained) / b.wall, 0.0, 1e-3, "",
                      Demand::at_most});
  };
  balanced("turning cylinder", exact);
  balanced("the same of 2,160 triangles", mesh);
  const Mean a = mean_of(exact.torque), b = mean_of(mesh.torque);
  const double error = std::hypot(a.error, b.error);
  checks.push_back({"torque on the cylinder", a.value, 0.0, 0.0, "N m", Demand::report});
  checks.push_back({"torque on the triangles, within four standard errors", b.value, a.value,
                    4.0 * error, "N m"});
  checks.push_back({"those four standard errors over the torque: sharp enough to mean something",
                    4.0 * error / a.value, 0.2, 0.0, "", Demand::at_most});
  return checks;
}

}  // namespace repose::physics

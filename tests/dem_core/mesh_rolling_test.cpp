#include <gtest/gtest.h>

#include "geometry/facet.hpp"
#include "mesh_walls.hpp"

namespace repose::dem {
namespace {

constexpr double kRadius = 0.01;

/// A sphere that falls obliquely onto a floor, bounces, slips and rolls across its middle.
Sphere rolled_over(const scene::Wall& floor) {
  scene::Case c = empty_case({.restitution = 0.4, .mu_s = 0.5, .mu_r = 0.02});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor};
  c.particles = {grain(kRadius, {-0.05, 0.013, 0.012}, {0.5, 0.02, 0})};
  Simulation sim(c);
  while (sim.time_s() < 0.4) sim.step();
  EXPECT_GT(sim.spheres()[0].position.x(), 0.05);
  return sim.spheres()[0];
}

TEST(MeshFloor, ASphereRollsOverItAsOverARectangle) {
  const Sphere expected =
      rolled_over(rectangle("floor", {-0.2, -0.2, 0}, {0.4, 0, 0}, {0, 0.4, 0}));
  struct Cut {
    int n;
    double disorder;
  };
  for (const Cut cut : {Cut{1, 0.0}, Cut{8, 0.0}, Cut{40, 0.45}, Cut{160, 0.3}}) {
    const Sphere sphere = rolled_over(
        mesh_wall("floor", floor_triangles(-0.2, 0.2, -0.2, 0.2, cut.n, cut.n, cut.disorder)));
    // The same arithmetic up to rounding of heights over other corners.
    EXPECT_LT((sphere.position - expected.position).norm(), 1e-12) << cut.n;
    EXPECT_LT((sphere.velocity - expected.velocity).norm(), 1e-10) << cut.n;
    EXPECT_LT((sphere.angular_velocity - expected.angular_velocity).norm(), 1e-8) << cut.n;
  }
}

/// A sphere thrown into a corner region of a box.
std::vector<Vec3> rebounds(const std::vector<scene::Wall>& walls) {
  scene::Case c = empty_case({.restitution = 0.7, .mu_s = 0.3});
  c.gravity_m_s2 = {0, 0, -9.81};
  c.walls = walls;
  const Vec3 middle(0.05, 0.05, 0.05);
  // Towards a face, along an edge, into a corner; and from outside onto an edge and a corner.
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

TEST(MeshBox, ReboundsAtFacesEdgesAndCornersAreThoseOfTheBoxOfRectangles) {
  const Vec3 upper = Vec3::Constant(0.1);
  const auto expected = rebounds(scene::box_walls("box", "wall", Vec3::Zero(), upper, {}));
  for (const int n : {1, 6}) {
    const auto path = rebounds({mesh_wall("mesh", scene::box_triangles(Vec3::Zero(), upper, n))});
    ASSERT_EQ(path.size(), expected.size());
    for (std::size_t k = 0; k < path.size(); ++k)
      EXPECT_LT((path[k] - expected[k]).norm(), 1e-9) << "row " << k / 5 << " sphere " << k % 5;
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
  double along = 0.0;   // root of the mean square over starts of the largest distance of two paths
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

/// Halving the strips twice divides both errors by 16, if they go with the square; what the sphere
/// loses in the small impacts at concave edges scatters about that.
void expect_second_order(const Course& course) {
  const PathError coarse = path_error(course, 180);
  const PathError fine = path_error(course, 720);
  const double sagitta = 0.1 * (1 - std::cos(std::numbers::pi / 180));
  EXPECT_LT(coarse.across, 3.0 * sagitta);  // inside: that of the sphere's own path as well
  EXPECT_GT(coarse.across / fine.across, 10.0);
  EXPECT_GT(coarse.along / fine.along, 10.0);
  EXPECT_LT(fine.along, 1e-3 * kRadius * 3.0);  // over a way of twelve radii and more
}

TEST(MeshCylinder, ASphereRollsInsideAsInTheCylinder) {
  expect_second_order({.r0 = 0.1,
                       .r1 = 0.1,
                       .gravity = {0, -9.81, 0},
                       .inside = true,
                       .height = 0.1,
                       .turn = 0.7,
                       .speed = {0, 0, 0.1}});
}

TEST(MeshCylinder, ASphereRollsOutsideAsOnTheCylinder) {
  expect_second_order({.r0 = 0.1,
                       .r1 = 0.1,
                       .gravity = {0, 9.81, 0},
                       .inside = false,
                       .height = 0.1,
                       .turn = 0.05,
                       .speed = {0.3, 0, 0.1}});
}

TEST(MeshCone, ASphereRollsInsideAsInTheCone) {
  expect_second_order({.r0 = 0.01,
                       .r1 = 0.16,
                       .gravity = {0, 0, -9.81},
                       .inside = true,
                       .height = 0.15,
                       .turn = 0.0,
                       .speed = {0.6, 0, 0.0}});
}

}  // namespace
}  // namespace repose::dem

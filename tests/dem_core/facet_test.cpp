#include "geometry/facet.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <numbers>

#include "geometry/facet_tree.hpp"
#include "geometry/smooth_patches.hpp"
#include "repose/base/random.hpp"

namespace repose::dem {
namespace {

using Surface = std::function<Vec3(double, double)>;  // of a, b in [0, 1]

/// closest_point() against a search over (n+1)^2 points of the surface, which lie so densely that
/// no point is further than `spacing` from one.
void expect_closest(const Facet& facet, const Surface& surface, double spacing) {
  RandomStream random(3);
  const int n = 200;
  for (int t = 0; t < 60; ++t) {
    const Vec3 x(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    double best = 1e9;
    for (int a = 0; a <= n; ++a)
      for (int b = 0; b <= n; ++b)
        best = std::min(best, (surface(double(a) / n, double(b) / n) - x).norm());
    const ClosestPoint point = closest_point(facet, x);
    EXPECT_LE(point.distance, best + 1e-12);
    EXPECT_GE(point.distance, best - spacing);
    EXPECT_NEAR(point.direction.norm(), 1.0, 1e-12);
    EXPECT_NEAR(closest_point(facet, x + point.offset()).distance, 0.0, 1e-12);  // it lies on it
  }
}

TEST(Facet, ClosestPointOfARectangleMatchesASearch) {
  const Vec3 o(0.1, 0.2, 0.3), u(0.3, 0.4, 0.0), v(-0.4, 0.3, 0.5);
  expect_closest(
      rectangle_facet(o, u, v), [&](double a, double b) -> Vec3 { return o + a * u + b * v; },
      0.6 / 200);
}

TEST(Facet, ClosestPointOfATriangleMatchesASearch) {
  for (const double lean : {-0.6, 0.2, 1.5}) {  // obtuse at the first corner, acute, at the second
    const Vec3 o(0.1, -0.2, 0.3), u(0.4, 0.0, 0.1);
    const Vec3 v = lean * u + Vec3(0.0, 0.5, 0.0);
    expect_closest(
        triangle_facet(o, o + u, o + v),
        [&](double a, double b) -> Vec3 { return o + a * (1 - b) * u + b * v; }, 1.0 / 200);
  }
}

/// The point of a revolved surface at the height a of its line and the angle 2 pi b.
Surface revolved(const Vec3& start, const Vec3& end, const Vec3& axis, double r0, double r1) {
  Vec3 across = cross(axis, Vec3(0.3, -0.5, 0.8)).normalized();
  return [=](double a, double b) -> Vec3 {
    const double angle = 2.0 * std::numbers::pi * b;
    const Vec3 outwards =
        std::cos(angle) * across + std::sin(angle) * cross(axis.normalized(), across);
    return start + a * (end - start) + (r0 + a * (r1 - r0)) * outwards;
  };
}

TEST(Facet, ClosestPointOfSurfacesOfRevolutionMatchesASearch) {
  const Vec3 start(0.1, 0.0, -0.3), end(0.2, 0.3, 0.3);
  const Vec3 axis = end - start;
  struct Radii {
    double start, end;
  };
  for (const Radii r : {Radii{0.3, 0.3}, Radii{0.5, 0.2}, Radii{0.0, 0.4}})
    expect_closest(revolved_facet(start, axis, r.start, r.end, axis.norm()),
                   revolved(start, end, axis, r.start, r.end), 3.3 / 200);
  for (const Radii r : {Radii{0.0, 0.5}, Radii{0.2, 0.5}})  // a disc and a ring
    expect_closest(revolved_facet(start, axis, r.start, r.end, 0.0),
                   revolved(start, start, axis, r.start, r.end), 3.3 / 200);
}

TEST(Facet, ASphereOnTheAxisOfACylinderIsItsRadiusAway) {
  const Facet cylinder = revolved_facet(Vec3::Zero(), Vec3::UnitZ(), 0.2, 0.2, 1.0);
  const ClosestPoint point = closest_point(cylinder, {0, 0, 0.5});
  EXPECT_DOUBLE_EQ(point.distance, 0.2);
  EXPECT_NEAR(point.direction.norm(), 1.0, 1e-15);
  EXPECT_NEAR(point.direction.z(), 0.0, 1e-15);
}

TEST(Facet, BehindAPlaneDistanceIsNegativeAndTheNormalStays) {
  const Facet plane = plane_facet({0, 0, 1}, {0, 0, 5});
  EXPECT_DOUBLE_EQ(closest_point(plane, {3, 4, 3}).distance, 2.0);
  EXPECT_DOUBLE_EQ(closest_point(plane, {3, 4, 0}).distance, -1.0);
  EXPECT_EQ(closest_point(plane, {3, 4, 0}).direction, Vec3(0, 0, -1));
}

std::vector<Facet> random_facets(std::size_t n) {
  RandomStream random(11);
  const auto point = [&](double size) {
    return Vec3(random.uniform(-size, size), random.uniform(-size, size),
                random.uniform(-size, size));
  };
  std::vector<Facet> facets;
  for (std::size_t f = 0; f < n; ++f) {
    const Vec3 at = point(1.0);
    switch (f % 3) {
      case 0:
        facets.push_back(triangle_facet(at, at + point(0.1), at + point(0.1)));
        break;
      case 1:
        facets.push_back(revolved_facet(at, point(1.0), 0.05, 0.1, 0.1));
        break;
      default: {
        const Vec3 u = point(0.1);
        facets.push_back(rectangle_facet(at, u, 0.1 * cross(u, point(1.0)).normalized()));
      }
    }
  }
  return facets;
}

TEST(FacetTree, FindsWhatASearchOfAllFacetsFinds) {
  const std::vector<Facet> facets = random_facets(3000);
  const auto last = static_cast<std::int32_t>(facets.size());
  const FacetTree tree(facets, 0, last);
  RandomStream random(12);
  std::size_t total = 0;
  for (int t = 0; t < 200; ++t) {
    const Vec3 x(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double reach = random.uniform(0.0, 0.2);
    std::vector<std::int32_t> expected, found;
    const auto is_near = [&](std::int32_t f) {
      return closest_point(facets[static_cast<std::size_t>(f)], x).distance < reach;
    };
    for (std::int32_t f = 0; f < last; ++f)
      if (is_near(f)) expected.push_back(f);
    tree.visit_near(x, reach, [&](std::int32_t f) {
      if (is_near(f)) found.push_back(f);
    });
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    total += found.size();
  }
  EXPECT_GT(total, 1000u);
}

TEST(FacetTree, VisitsFewFacetsOfAManyTimesLargerMesh) {
  const std::vector<Facet> facets = random_facets(30000);
  const FacetTree tree(facets, 0, static_cast<std::int32_t>(facets.size()));
  int visits = 0;
  tree.visit_near({3, 3, 3}, 0.5, [&](std::int32_t) { ++visits; });
  EXPECT_EQ(visits, 0);
  tree.visit_near({0, 0, 0}, 0.01, [&](std::int32_t) { ++visits; });
  EXPECT_LT(visits, 200);
}

TEST(SmoothPatches, JoinFlatAndSmoothNeighborsAndNoOthers) {
  // A strip of six squares of two triangles, bent between them by 0, 3, 4, 8 and 0 degrees.
  std::vector<scene::Triangle> triangles;
  const double bends[] = {0, 3, 4, 8, 0};
  Vec3 at = Vec3::Zero();
  double slope = 0.0;
  for (int s = 0; s < 6; ++s) {
    const Vec3 next = at + Vec3(std::cos(slope), 0, std::sin(slope));
    const Vec3 up(0, 1, 0);
    triangles.push_back({at, next, next + up});
    triangles.push_back({at, next + up, at + up});
    if (s == 2) std::swap(triangles.back()[0], triangles.back()[1]);  // facing the other way
    at = next;
    if (s < 5) slope += bends[s] * std::numbers::pi / 180.0;
  }
  const scene::TriangleMesh mesh = scene::weld(triangles);
  using Patches = std::vector<std::int32_t>;
  EXPECT_EQ(smooth_patches(mesh, 5.0), (Patches{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1}));
  EXPECT_EQ(smooth_patches(mesh, 3.5), (Patches{0, 0, 0, 0, 0, 0, 1, 1, 2, 2, 2, 2}));
  EXPECT_EQ(smooth_patches(mesh, 0.0), (Patches{0, 0, 0, 0, 1, 1, 2, 2, 3, 3, 3, 3}));
}

}  // namespace
}  // namespace repose::dem

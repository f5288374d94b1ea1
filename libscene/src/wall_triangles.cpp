#include <array>
#include <cmath>
#include <numbers>

#include "repose/scene/cross.hpp"
#include "repose/scene/vtp.hpp"

namespace repose::scene {
namespace {

constexpr int kFacets = 64;

/// Two directions that make a right-handed frame with `axis`.
std::array<Vec3, 2> across(const Vec3& axis) {
  const Vec3 n = axis.normalized();
  Eigen::Index smallest = 0;
  n.cwiseAbs().minCoeff(&smallest);
  const Vec3 u = cross(n, Vec3::Unit(smallest)).normalized();
  return {u, cross(n, u)};
}

/// A convex polygon as a fan.
TriangleMesh fan(const std::vector<Vec3>& polygon) {
  TriangleMesh mesh;
  if (polygon.size() < 3) return mesh;
  mesh.corners = polygon;
  for (std::int32_t k = 1; k + 1 < static_cast<std::int32_t>(polygon.size()); ++k)
    mesh.triangles.push_back({0, k, k + 1});
  return mesh;
}

/// The part of a convex polygon where sign * x[axis] <= sign * bound.
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, int axis, double sign, double bound) {
  std::vector<Vec3> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3& a = polygon[k];
    const Vec3& b = polygon[(k + 1) % polygon.size()];
    const double depth_a = sign * (bound - a[axis]);
    const double depth_b = sign * (bound - b[axis]);
    if (depth_a >= 0.0) kept.push_back(a);
    if ((depth_a > 0.0 && depth_b < 0.0) || (depth_a < 0.0 && depth_b > 0.0))
      kept.push_back(a + depth_a / (depth_a - depth_b) * (b - a));
  }
  return kept;
}

/// Rings of corners about an axis, joined by two triangles a facet; a ring of radius 0 is a tip.
TriangleMesh revolved(const Vec3& start, double start_radius, const Vec3& end, double end_radius,
                      const Vec3& axis) {
  const auto [u, v] = across(axis);
  TriangleMesh mesh;
  for (int k = 0; k < kFacets; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kFacets;
    const Vec3 outwards = std::cos(angle) * u + std::sin(angle) * v;
    mesh.corners.push_back(start + start_radius * outwards);
    mesh.corners.push_back(end + end_radius * outwards);
  }
  for (std::int32_t k = 0; k < kFacets; ++k) {
    const std::int32_t next = (k + 1) % kFacets;
    if (start_radius > 0.0) mesh.triangles.push_back({2 * k, 2 * next, 2 * k + 1});
    if (end_radius > 0.0) mesh.triangles.push_back({2 * next, 2 * next + 1, 2 * k + 1});
  }
  return mesh;
}

struct Triangulate {
  const Case& scene;

  TriangleMesh operator()(const Plane& plane) const {
    const auto [u, v] = across(plane.normal);
    // The point of the plane nearest to the middle of the domain, and a square that covers it.
    const Vec3 middle = 0.5 * (scene.lower_m + scene.upper_m);
    const Vec3 n = plane.normal.normalized();
    const Vec3 foot = middle - n.dot(middle - plane.origin) * n;
    const double reach = (scene.upper_m - scene.lower_m).norm();
    std::vector<Vec3> polygon{foot + reach * (u + v), foot + reach * (v - u),
                              foot - reach * (u + v), foot + reach * (u - v)};
    for (int k = 0; k < 3; ++k) {
      polygon = clipped(polygon, k, 1.0, scene.upper_m[k]);
      polygon = clipped(polygon, k, -1.0, scene.lower_m[k]);
    }
    return fan(polygon);
  }
  TriangleMesh operator()(const Rectangle& r) const {
    return fan(
        {r.origin, r.origin + r.edge_u, r.origin + r.edge_u + r.edge_v, r.origin + r.edge_v});
  }
  TriangleMesh operator()(const Disc& disc) const {
    return revolved(disc.centre, disc.inner_radius_m, disc.centre, disc.radius_m, disc.normal);
  }
  TriangleMesh operator()(const Cone& cone) const {
    return revolved(cone.start, cone.start_radius_m, cone.end, cone.end_radius_m,
                    cone.end - cone.start);
  }
  TriangleMesh operator()(const Mesh& mesh) const { return load_mesh(mesh).mesh; }
};

}  // namespace

TriangleMesh wall_triangles(const Case& scene, const Wall& wall) {
  return std::visit(Triangulate{scene}, wall.shape);
}

}  // namespace repose::scene

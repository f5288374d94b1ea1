#include "geometry/facet.hpp"

#include <limits>

namespace repose::dem {
namespace {

Facet flat_facet(FacetKind kind, const Vec3& origin, const Vec3& edge_u, const Vec3& edge_v) {
  Facet facet;
  facet.kind = kind;
  facet.origin = origin;
  facet.edge_u = edge_u;
  facet.edge_v = edge_v;
  facet.normal = cross(edge_u, edge_v).normalized();
  facet.uu = edge_u.squaredNorm();
  facet.uv = edge_u.dot(edge_v);
  facet.vv = edge_v.squaredNorm();
  return facet;
}

}  // namespace

Facet plane_facet(const Vec3& origin, const Vec3& normal) {
  Facet facet;
  facet.origin = origin;
  facet.normal = normal / normal.norm();
  return facet;
}

Facet rectangle_facet(const Vec3& origin, const Vec3& edge_u, const Vec3& edge_v) {
  return flat_facet(FacetKind::rectangle, origin, edge_u, edge_v);
}

Facet triangle_facet(const Vec3& a, const Vec3& b, const Vec3& c) {
  return flat_facet(FacetKind::triangle, a, b - a, c - a);
}

Facet revolved_facet(const Vec3& start, const Vec3& axis, double start_radius, double end_radius,
                     double length) {
  Facet facet;
  facet.kind = FacetKind::revolved;
  facet.origin = start;
  facet.normal = axis.normalized();
  facet.start_radius = start_radius;
  facet.end_radius = end_radius;
  facet.length = length;
  return facet;
}

Bounds bounds_of(const Facet& f) {
  Bounds box{f.origin, f.origin};
  const auto include = [&](const Vec3& lower, const Vec3& upper) {
    box.lower = box.lower.cwiseMin(lower);
    box.upper = box.upper.cwiseMax(upper);
  };
  switch (f.kind) {
    case FacetKind::plane:
      box.lower.setConstant(-std::numeric_limits<double>::infinity());
      box.upper.setConstant(std::numeric_limits<double>::infinity());
      break;
    case FacetKind::rectangle:
      include(f.origin + f.edge_u + f.edge_v, f.origin + f.edge_u + f.edge_v);
      [[fallthrough]];
    case FacetKind::triangle:
      include(f.origin + f.edge_u, f.origin + f.edge_u);
      include(f.origin + f.edge_v, f.origin + f.edge_v);
      break;
    case FacetKind::revolved:
      // A circle of radius r about the axis a reaches r sqrt(1 - a_k^2) in direction k.
      for (const bool at_start : {true, false}) {
        const Vec3 centre = f.origin + (at_start ? 0.0 : f.length) * f.normal;
        const Vec3 reach = (at_start ? f.start_radius : f.end_radius) *
                           (1.0 - f.normal.array().square()).cwiseMax(0.0).sqrt().matrix();
        include(centre - reach, centre + reach);
      }
      break;
  }
  return box;
}

Vec3 detail::any_direction_across(const Vec3& axis) {
  Vec3 other = Vec3::Zero();
  Eigen::Index smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  other[smallest] = 1.0;
  return cross(axis, other).normalized();
}

}  // namespace repose::dem

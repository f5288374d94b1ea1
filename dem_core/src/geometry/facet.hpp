// A facet of a wall, flat or of revolution, and its point that is closest to a sphere.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "repose/dem/cross.hpp"

namespace repose::dem {

enum class FacetKind : std::uint8_t { plane, rectangle, triangle, revolved };

/// Where on a facet a point lies: within it, or on its rim (its edges and corners).
enum class Feature : std::uint8_t { face, rim };

struct ClosestPoint {
  Vec3 direction;   ///< unit, from the centre of the sphere to the point
  double distance;  ///< along it; negative behind a plane
  Feature feature;

  Vec3 offset() const { return distance * direction; }
};

/// One smooth piece of a wall in the frame in which the wall was drawn, with what is computed once.
/// A revolved facet is the segment from (start_radius, 0) to (end_radius, length) of the half-plane
/// (distance from the axis, height along it), turned about the axis: a disc or ring has length 0, a
/// cylinder equal radii.
struct Facet {
  FacetKind kind = FacetKind::plane;
  std::int32_t wall = 0;
  std::int32_t patch = 0;       ///< equal for facets between which a contact keeps its history
  Vec3 origin = Vec3::Zero();   ///< a point of a plane, a corner, or the start of the axis
  Vec3 normal = Vec3::UnitZ();  ///< unit; of a revolved facet the axis
  Vec3 edge_u = Vec3::Zero();   ///< from the origin to the corners beside it
  Vec3 edge_v = Vec3::Zero();
  double uu = 0.0, uv = 0.0, vv = 0.0;  ///< products of the edges
  double start_radius = 0.0, end_radius = 0.0, length = 0.0;
};

/// Whether it lies in a plane, that of its origin and normal.
inline bool is_flat(const Facet& facet) {
  return facet.kind != FacetKind::revolved || facet.length == 0.0;
}

Facet plane_facet(const Vec3& origin, const Vec3& normal);
Facet rectangle_facet(const Vec3& origin, const Vec3& edge_u, const Vec3& edge_v);
Facet triangle_facet(const Vec3& a, const Vec3& b, const Vec3& c);
Facet revolved_facet(const Vec3& start, const Vec3& axis, double start_radius, double end_radius,
                     double length);

/// An axis-parallel box; infinite for a plane.
struct Bounds {
  Vec3 lower, upper;
  /// Square of the distance of a point from the box, 0 inside.
  double distance2(const Vec3& x) const {
    return (lower - x).cwiseMax(x - upper).cwiseMax(0.0).squaredNorm();
  }
};
Bounds bounds_of(const Facet& facet);

namespace detail {

inline ClosestPoint point_on_rim(const Vec3& offset, const Vec3& normal) {
  const double distance = offset.norm();
  if (distance > 0.0) return {offset * (1.0 / distance), distance, Feature::rim};
  return {-normal, 0.0, Feature::rim};
}

inline ClosestPoint point_on_face(double height, const Vec3& normal) {
  if (height < 0.0) return {normal, -height, Feature::face};
  return {-normal, height, Feature::face};
}

inline ClosestPoint closest_on_rectangle(const Facet& f, const Vec3& from_origin) {
  const double a = from_origin.dot(f.edge_u);
  const double b = from_origin.dot(f.edge_v);
  if (a >= 0.0 && a <= f.uu && b >= 0.0 && b <= f.vv)
    return point_on_face(from_origin.dot(f.normal), f.normal);
  const Vec3 nearest =
      (std::clamp(a, 0.0, f.uu) / f.uu) * f.edge_u + (std::clamp(b, 0.0, f.vv) / f.vv) * f.edge_v;
  return point_on_rim(nearest - from_origin, f.normal);
}

/// By the Voronoi regions of corners, edges and face [Ericson2005, section 5.1.5].
inline ClosestPoint closest_on_triangle(const Facet& f, const Vec3& from_origin) {
  const double d1 = from_origin.dot(f.edge_u);
  const double d2 = from_origin.dot(f.edge_v);
  const double d3 = d1 - f.uu, d4 = d2 - f.uv;  // from the second corner
  const double d5 = d1 - f.uv, d6 = d2 - f.vv;  // from the third
  const double w = f.uu * d2 - f.uv * d1;       // areal coordinates of the foot, not normalised
  const double v = f.vv * d1 - f.uv * d2;
  const double u = f.uu * f.vv - f.uv * f.uv - v - w;
  if (u > 0.0 && v > 0.0 && w > 0.0) return point_on_face(from_origin.dot(f.normal), f.normal);
  Vec3 nearest;
  if (d1 <= 0.0 && d2 <= 0.0)
    nearest.setZero();
  else if (d3 >= 0.0 && d4 <= d3)
    nearest = f.edge_u;
  else if (d6 >= 0.0 && d5 <= d6)
    nearest = f.edge_v;
  else if (w <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
    nearest = (d1 / f.uu) * f.edge_u;
  else if (v <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
    nearest = (d2 / f.vv) * f.edge_v;
  else
    nearest = f.edge_u +
              std::clamp((d4 - d3) / ((d4 - d3) + (d5 - d6)), 0.0, 1.0) * (f.edge_v - f.edge_u);
  return point_on_rim(nearest - from_origin, f.normal);
}

/// A unit vector across the axis, for centres that lie on it.
Vec3 any_direction_across(const Vec3& axis);

inline ClosestPoint closest_on_revolved(const Facet& f, const Vec3& from_origin) {
  const double z = from_origin.dot(f.normal);
  const Vec3 across = from_origin - z * f.normal;
  const double rho = across.norm();
  const Vec3 outwards = rho > 0.0 ? Vec3(across * (1.0 / rho)) : any_direction_across(f.normal);
  const double slope = f.end_radius - f.start_radius;
  const double from_start = (rho - f.start_radius) * slope + z * f.length;
  const double length2 = slope * slope + f.length * f.length;
  if (from_start >= 0.0 && from_start <= length2) {
    const double scale = 1.0 / std::sqrt(length2);
    const double across_part = f.length * scale;
    const double along_part = -slope * scale;
    return point_on_face((rho - f.start_radius) * across_part + z * along_part,
                         across_part * outwards + along_part * f.normal);
  }
  const bool at_start = from_start < 0.0;
  const double radius = at_start ? f.start_radius : f.end_radius;
  const double height = at_start ? 0.0 : f.length;
  return point_on_rim((radius - rho) * outwards + (height - z) * f.normal, outwards);
}

}  // namespace detail

inline ClosestPoint closest_point(const Facet& facet, const Vec3& x) {
  const Vec3 from_origin = x - facet.origin;
  switch (facet.kind) {
    case FacetKind::plane:
      return {-facet.normal, from_origin.dot(facet.normal), Feature::face};
    case FacetKind::rectangle:
      return detail::closest_on_rectangle(facet, from_origin);
    case FacetKind::triangle:
      return detail::closest_on_triangle(facet, from_origin);
    default:
      return detail::closest_on_revolved(facet, from_origin);
  }
}

}  // namespace repose::dem

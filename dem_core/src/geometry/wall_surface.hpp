// Walls as surfaces: the point of a plane or rectangle that is closest to a sphere.
#pragma once

#include <algorithm>
#include <vector>

#include "repose/dem/contact_law.hpp"

namespace repose::dem {

enum class SurfaceKind { plane, rectangle };

/// Which part of a rectangle is closest; planes have only a face.
enum class Feature { face, rim };

struct ClosestPoint {
  Vec3 offset;      ///< from the centre of the sphere to the closest point
  double distance;  ///< its length; negative behind a plane
  Feature feature;
};

/// A wall with what is computed once.
struct WallSurface {
  SurfaceKind kind;
  Vec3 origin;
  Vec3 normal;          ///< unit; of a plane towards the particles
  Vec3 edge_u, edge_v;  ///< of a rectangle
  double inv_u2 = 0.0;  ///< 1/|edge_u|^2
  double inv_v2 = 0.0;
  int material = 0;
  int patch = 0;        ///< equal for walls that lie in one plane and have one material
  bool present = true;  ///< false once a stage has taken it away
};

std::vector<WallSurface> wall_surfaces(const scene::Case& scene);

inline ClosestPoint closest_point(const WallSurface& wall, const Vec3& x) {
  const Vec3 from_origin = x - wall.origin;
  const double height = from_origin.dot(wall.normal);
  if (wall.kind == SurfaceKind::plane) return {-height * wall.normal, height, Feature::face};
  const double a = from_origin.dot(wall.edge_u) * wall.inv_u2;
  const double b = from_origin.dot(wall.edge_v) * wall.inv_v2;
  if (a >= 0.0 && a <= 1.0 && b >= 0.0 && b <= 1.0)
    return {-height * wall.normal, std::abs(height), Feature::face};
  const Vec3 nearest =
      std::clamp(a, 0.0, 1.0) * wall.edge_u + std::clamp(b, 0.0, 1.0) * wall.edge_v;
  const Vec3 offset = nearest - from_origin;
  return {offset, offset.norm(), Feature::rim};
}

/// Unit vector from the sphere to its closest point; for a centre that lies in the wall, its
/// normal.
inline Vec3 direction_to(const WallSurface& wall, const ClosestPoint& point) {
  if (point.distance > 0.0) return point.offset * (1.0 / point.distance);
  return -wall.normal;
}

}  // namespace repose::dem

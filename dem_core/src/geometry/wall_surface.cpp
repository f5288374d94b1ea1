#include "geometry/wall_surface.hpp"

#include <cmath>
#include <cstddef>

#include "geometry/cross.hpp"

namespace repose::dem {
namespace {

bool in_one_plane(const WallSurface& a, const WallSurface& b) {
  if (a.shape != b.shape || a.material != b.material) return false;
  if (std::abs(a.normal.dot(b.normal)) < 1.0 - 1e-12) return false;
  const double size = (b.origin - a.origin).norm() + a.edge_u.norm() + a.edge_v.norm();
  return std::abs((b.origin - a.origin).dot(a.normal)) <= 1e-9 * size;
}

}  // namespace

std::vector<WallSurface> wall_surfaces(const scene::Case& scene) {
  std::vector<WallSurface> surfaces;
  for (const scene::Wall& wall : scene.walls) {
    WallSurface surface;
    surface.shape = wall.shape;
    surface.origin = wall.origin;
    surface.edge_u = wall.edge_u;
    surface.edge_v = wall.edge_v;
    surface.material = scene::material_index(scene, wall.material);
    if (wall.shape == scene::WallShape::plane) {
      surface.normal = wall.normal / wall.normal.norm();
    } else {
      surface.normal = cross(wall.edge_u, wall.edge_v).normalized();
      surface.inv_u2 = 1.0 / wall.edge_u.squaredNorm();
      surface.inv_v2 = 1.0 / wall.edge_v.squaredNorm();
    }
    surface.patch = static_cast<int>(surfaces.size());
    for (const WallSurface& other : surfaces)
      if (in_one_plane(other, surface)) {
        surface.patch = other.patch;
        break;
      }
    surfaces.push_back(surface);
  }
  return surfaces;
}

}  // namespace repose::dem

#include "geometry/wall_surface.hpp"

#include <cmath>
#include <cstddef>
#include <variant>

#include "geometry/cross.hpp"

namespace repose::dem {
namespace {

bool in_one_plane(const WallSurface& a, const WallSurface& b) {
  if (a.kind != b.kind || a.material != b.material) return false;
  if (std::abs(a.normal.dot(b.normal)) < 1.0 - 1e-12) return false;
  const double size = (b.origin - a.origin).norm() + a.edge_u.norm() + a.edge_v.norm();
  return std::abs((b.origin - a.origin).dot(a.normal)) <= 1e-9 * size;
}

}  // namespace

std::vector<WallSurface> wall_surfaces(const scene::Case& scene) {
  std::vector<WallSurface> surfaces;
  for (const scene::Wall& wall : scene.walls) {
    WallSurface surface;
    surface.material = scene::material_index(scene, wall.material);
    if (const auto* plane = std::get_if<scene::Plane>(&wall.shape)) {
      surface.kind = SurfaceKind::plane;
      surface.origin = plane->origin;
      surface.normal = plane->normal / plane->normal.norm();
      surface.edge_u.setZero();
      surface.edge_v.setZero();
    } else {
      const auto& rectangle = std::get<scene::Rectangle>(wall.shape);
      surface.kind = SurfaceKind::rectangle;
      surface.origin = rectangle.origin;
      surface.edge_u = rectangle.edge_u;
      surface.edge_v = rectangle.edge_v;
      surface.normal = cross(surface.edge_u, surface.edge_v).normalized();
      surface.inv_u2 = 1.0 / surface.edge_u.squaredNorm();
      surface.inv_v2 = 1.0 / surface.edge_v.squaredNorm();
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

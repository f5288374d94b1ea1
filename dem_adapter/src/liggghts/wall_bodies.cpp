#include "wall_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/scene/vtp.hpp"

namespace repose::dem_adapter::liggghts {
namespace {

using scene::TriangleMesh;
using scene::Vec3;

// Longer triangles in a thin periodic box end in "assertion failed (region_neighbor_list)".
constexpr double kLongestOverPeriod = 2.5;
constexpr double kLongestOverShortest = 5.0;
constexpr double kRoundSmooth_deg = 6.0;  // 64 facets meet at 5.6 degrees
// LIGGGHTS wants smooth angles below every angle of a triangle.
constexpr double kSmoothOverAngle = 0.9;

double edge_length(const TriangleMesh& mesh, std::size_t t, std::size_t k) {
  return (mesh.corner(t, k) - mesh.corner(t, (k + 1) % 3)).norm();
}

/// Halves the longest edges until none exceeds the limit. What an edge becomes depends on the edge
/// alone, so triangles that shared one still do.
TriangleMesh cut(TriangleMesh mesh, double longest) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto [place, is_new] = middles.emplace(std::minmax(a, b), 0);
    if (is_new) {
      place->second = static_cast<std::int32_t>(mesh.corners.size());
      mesh.corners.push_back(0.5 * (mesh.corners[static_cast<std::size_t>(a)] +
                                    mesh.corners[static_cast<std::size_t>(b)]));
    }
    return place->second;
  };
  for (std::size_t t = 0; t < mesh.triangles.size();) {
    std::size_t k = 0;
    for (std::size_t other = 1; other < 3; ++other)
      if (edge_length(mesh, t, other) > edge_length(mesh, t, k)) k = other;
    if (edge_length(mesh, t, k) <= longest) {
      ++t;
      continue;
    }
    const auto corners = mesh.triangles[t];
    const std::int32_t a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
    const std::int32_t m = middle(a, b);
    mesh.triangles[t] = {a, m, c};
    mesh.triangles.push_back({m, b, c});
  }
  return mesh;
}

double shortest_edge(const TriangleMesh& mesh) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) shortest = std::min(shortest, edge_length(mesh, t, k));
  return shortest;
}

double smallest_angle_deg(const TriangleMesh& mesh) {
  double smallest = 180.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 u = (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).normalized();
      const Vec3 v = (mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k)).normalized();
      smallest =
          std::min(smallest, std::acos(std::clamp(u.dot(v), -1.0, 1.0)) * 180.0 / std::numbers::pi);
    }
  return smallest;
}

double smallest_period(const scene::Case& scene) {
  double period = std::numeric_limits<double>::infinity();
  const bool periodic[] = {scene.periodic.x, scene.periodic.y, scene.periodic.z};
  for (int k = 0; k < 3; ++k)
    if (periodic[k]) period = std::min(period, scene.upper_m[k] - scene.lower_m[k]);
  return period;
}

bool is_round(const scene::Shape& shape) {
  return std::holds_alternative<scene::Disc>(shape) || std::holds_alternative<scene::Cone>(shape);
}

TriangleMesh triangles_of(const scene::Case& scene, const scene::Wall& wall) {
  TriangleMesh mesh = scene::wall_triangles(scene, wall);
  double longest = kLongestOverPeriod * smallest_period(scene);
  if (!std::holds_alternative<scene::Mesh>(wall.shape) && !mesh.triangles.empty())
    longest = std::min(longest, kLongestOverShortest * shortest_edge(mesh));
  return cut(std::move(mesh), longest);
}

std::optional<AxisPlane> axis_plane(const scene::Wall& wall) {
  const auto* plane = std::get_if<scene::Plane>(&wall.shape);
  if (plane == nullptr) return std::nullopt;
  for (int k = 0; k < 3; ++k)
    if (std::abs(plane->normal[k]) == plane->normal.norm())
      return AxisPlane{.axis = k, .at_m = plane->origin[k]};
  return std::nullopt;
}

/// For each wall the stage that takes it away, or -1.
std::vector<int> opening_stages(const scene::Case& scene) {
  std::vector<int> opened(scene.walls.size(), -1);
  for (std::size_t s = 0; s < scene.stages.size(); ++s)
    for (const auto& name : scene.stages[s].opens)
      for (const int w : scene::walls_named(scene, name))
        if (int& stage = opened[static_cast<std::size_t>(w)]; stage < 0)
          stage = static_cast<int>(s);
  return opened;
}

std::vector<int> motions_of_walls(const scene::Case& scene) {
  std::vector<int> motion(scene.walls.size(), -1);
  for (std::size_t m = 0; m < scene.motions.size(); ++m)
    for (const auto& name : scene.motions[m].walls)
      for (const int w : scene::walls_named(scene, name)) {
        int& first = motion[static_cast<std::size_t>(w)];
        if (first >= 0)
          throw InputError(fmt::format(
              "wall \"{}\" has two motions; the engine liggghts moves a wall in one way",
              scene.walls[static_cast<std::size_t>(w)].name));
        first = static_cast<int>(m);
      }
  return motion;
}

void append(TriangleMesh& mesh, const TriangleMesh& more) {
  const auto first = static_cast<std::int32_t>(mesh.corners.size());
  mesh.corners.insert(mesh.corners.end(), more.corners.begin(), more.corners.end());
  for (const auto& t : more.triangles)
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

}  // namespace

std::vector<WallBody> wall_bodies(const scene::Case& scene) {
  const auto opened = opening_stages(scene), motions = motions_of_walls(scene);
  std::vector<WallBody> bodies;
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const scene::Wall& wall = scene.walls[w];
    WallBody own{.id = "",
                 .material = scene::material_index(scene, wall.material),
                 .opened_in = opened[w],
                 .motion = motions[w]};
    if (own.motion < 0) own.plane = axis_plane(wall);
    const auto alike = [&](const WallBody& body) {
      return !own.plane && !body.plane && body.material == own.material &&
             body.opened_in == own.opened_in && body.motion == own.motion;
    };
    auto body = std::find_if(bodies.begin(), bodies.end(), alike);
    if (body == bodies.end()) {
      own.id = fmt::format("{}_{}", own.plane ? "plane" : "mesh", bodies.size());
      body = bodies.insert(bodies.end(), std::move(own));
    }
    if (body->plane) continue;
    append(body->mesh, triangles_of(scene, wall));
    if (is_round(wall.shape)) body->smooth_deg = std::max(body->smooth_deg, kRoundSmooth_deg);
    if (const auto* mesh = std::get_if<scene::Mesh>(&wall.shape))
      body->smooth_deg = std::max(body->smooth_deg, mesh->smooth_deg);
  }
  for (auto& body : bodies)
    if (!body.plane)
      body.smooth_deg = std::min(body.smooth_deg, kSmoothOverAngle * smallest_angle_deg(body.mesh));
  return bodies;
}

void write_stl(const std::filesystem::path& path, const scene::TriangleMesh& mesh) {
  std::string text = "solid walls\n";
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& x = mesh.corner(t, k);
      text += fmt::format("vertex {:.12g} {:.12g} {:.12g}\n", x.x(), x.y(), x.z());
    }
    text += "endloop\nendfacet\n";
  }
  write_file_atomically(path, text + "endsolid walls\n");
}

}  // namespace repose::dem_adapter::liggghts

// The walls of a case as LIGGGHTS has them: planes along the axes, and meshes that are taken away
// and moved as a whole.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "repose/scene/case.hpp"
#include "repose/scene/triangle_mesh.hpp"

namespace repose::dem_adapter::liggghts {

/// A plane perpendicular to an axis.
struct AxisPlane {
  int axis = 0;
  double at_m = 0.0;
};

/// Walls of one material that move alike and are taken away together.
struct WallBody {
  std::string id;  ///< of its fix
  int material = 0;
  int opened_in = -1;  ///< index of the stage that begins by taking it away; -1: stays
  int motion = -1;     ///< index into Case::motions; -1: rests
  std::optional<AxisPlane> plane{};
  scene::TriangleMesh mesh{};  ///< if it is no plane
  double smooth_deg = 0.0;     ///< facets that meet at less are one surface; 0: as LIGGGHTS has it
};

/// Planes along an axis that rest stay planes; all other walls become triangles, round ones in 64
/// facets, each cut until it is neither slender nor long against a period of the domain. Throws
/// InputError for a wall with two motions, and as scene::load_mesh().
std::vector<WallBody> wall_bodies(const scene::Case& scene);

/// ASCII, as LIGGGHTS reads it.
void write_stl(const std::filesystem::path& path, const scene::TriangleMesh& mesh);

}  // namespace repose::dem_adapter::liggghts

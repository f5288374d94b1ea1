// Triangle meshes: welded triangles, what is wrong with them, and the mesh of a wall.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "repose/scene/stl_file.hpp"
#include "repose/scene/wall.hpp"

namespace repose::scene {

/// Triangles that share their corners.
struct TriangleMesh {
  std::vector<Vec3> corners;  ///< m
  std::vector<std::array<std::int32_t, 3>> triangles;

  const Vec3& corner(std::size_t triangle, std::size_t k) const {
    return corners[static_cast<std::size_t>(triangles[triangle][k])];
  }
};

/// Two corners of a triangle as it runs round them; both have first < second.
struct HalfEdge {
  std::int32_t first, second;
  std::int32_t triangle;
  bool forward;  ///< the triangle runs from first to second
};
/// The three of each triangle, sorted by (first, second, triangle), so that the triangles of an
/// edge follow each other.
std::vector<HalfEdge> half_edges(const TriangleMesh& mesh);

/// How many there are and where the first one is.
struct MeshFinding {
  std::int64_t count = 0;
  Vec3 first = Vec3::Zero();
};

/// What a mesh is and what is wrong with it.
struct MeshReport {
  std::int64_t triangles = 0;
  std::int64_t corners = 0;
  std::int64_t moved_corners = 0;  ///< by welding: those that did not fall together exactly
  MeshFinding zero_area;           ///< triangles no higher than the distance of welding
  MeshFinding duplicates;          ///< triangles with the corners of an earlier one
  MeshFinding rim_edges;           ///< of one triangle only: the surface is open
  MeshFinding non_manifold_edges;  ///< of more than two triangles
  MeshFinding t_junctions;         ///< corners that lie within a rim edge of another triangle
  MeshFinding inconsistent_edges;  ///< whose two triangles face opposite sides
  std::int64_t components = 0;     ///< parts that share no edge
  Vec3 lower = Vec3::Zero();       ///< bounding box
  Vec3 upper = Vec3::Zero();
  double area_m2 = 0.0;
  /// Enclosed; negative if the triangles face inwards; none if the surface has a rim or its
  /// triangles do not face one side.
  std::optional<double> volume_m3{};
};

/// Corners closer than this, as a fraction of the diagonal of the bounding box, are one.
inline constexpr double kWeldFraction = 1e-6;

/// Each corner close to an earlier one becomes that one; triangles keep their number and order, so
/// some may lose their area.
TriangleMesh weld(const std::vector<Triangle>& triangles);

/// moved_corners stays 0. Cost n log n.
MeshReport inspect(const TriangleMesh& mesh);

/// "12 triangles, 8 corners, closed, area 6 m2, volume 1 m3, ..." with all that is wrong.
std::string mesh_report_text(const MeshReport& report);

/// A mesh ready for use, and the report on it; the counts of zero_area and duplicates are those
/// of the triangles that were left out.
struct LoadedMesh {
  TriangleMesh mesh;
  MeshReport report;
};

/// Reads the file of a wall, scales and moves it, welds within 1e-6 of the diagonal of its bounding
/// box and checks it. Throws InputError naming the file, how many, where the first is and what to
/// do for a mesh that has no triangle, that changed since content_hash was taken, that has edges of
/// more than two triangles, triangles without area or twice the same without drop_degenerate, or
/// a rim without `open`; and as read_stl().
LoadedMesh load_mesh(const Mesh& wall);

}  // namespace repose::scene

#include "repose/scene/triangle_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "degenerate_triangles.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {
namespace {

/// Corners by cells a few welding distances wide, so that most searches look into one cell; there
/// are 125,000 of them along the diagonal, which fits the 21 bits of a key.
class CornerGrid {
 public:
  CornerGrid(const Vec3& origin, double distance)
      : origin_(origin), distance_(distance), width_(distance > 0.0 ? 8.0 * distance : 1.0) {}

  /// The earliest corner within the distance, else -1.
  std::int32_t find(const Vec3& x, const std::vector<Vec3>& corners) const {
    std::int64_t low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = cell(x[k] - distance_, k);
      high[k] = cell(x[k] + distance_, k);
    }
    std::int32_t best = -1;
    for (std::int64_t a = low[0]; a <= high[0]; ++a)
      for (std::int64_t b = low[1]; b <= high[1]; ++b)
        for (std::int64_t c = low[2]; c <= high[2]; ++c) {
          const auto found = cells_.find(key(a, b, c));
          if (found == cells_.end()) continue;
          for (std::int32_t i : found->second)
            if ((best < 0 || i < best) &&
                (corners[static_cast<std::size_t>(i)] - x).norm() <= distance_)
              best = i;
        }
    return best;
  }
  void add(const Vec3& x, std::int32_t corner) {
    cells_[key(cell(x[0], 0), cell(x[1], 1), cell(x[2], 2))].push_back(corner);
  }

 private:
  std::int64_t cell(double v, int k) const {
    return static_cast<std::int64_t>(std::floor((v - origin_[k]) / width_)) + 1;
  }
  static std::uint64_t key(std::int64_t a, std::int64_t b, std::int64_t c) {
    return static_cast<std::uint64_t>(a) | static_cast<std::uint64_t>(b) << 21 |
           static_cast<std::uint64_t>(c) << 42;
  }

  Vec3 origin_;
  double distance_, width_;
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> cells_;
};

/// Corners of triangles that stand at another place than in the file.
std::int64_t moved_corners(const std::vector<Triangle>& triangles, const TriangleMesh& mesh) {
  std::int64_t moved = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (triangles[t][k] != mesh.corner(t, k)) ++moved;
  return moved;
}

std::vector<Triangle> placed_triangles(const Mesh& wall, const std::string& bytes) {
  std::vector<Triangle> triangles = parse_stl(bytes, wall.file.string());
  for (Triangle& triangle : triangles)
    for (Vec3& corner : triangle) corner = wall.scale * corner + wall.translation;
  return triangles;
}

std::string place(const Vec3& x) {
  return "(" + shortest(x.x()) + ", " + shortest(x.y()) + ", " + shortest(x.z()) + ") m";
}

std::string found(const MeshFinding& finding, const std::string& what) {
  return std::to_string(finding.count) + " " + what + ", the first at " + place(finding.first);
}

[[noreturn]] void refuse(const Mesh& wall, const std::string& why) {
  throw InputError("mesh \"" + wall.file.string() + "\": " + why);
}

void refuse_degenerate(const Mesh& wall, const DegenerateTriangles& report) {
  const std::string remedy = "; repair the file or leave them out with drop_degenerate = true";
  if (report.zero_area.count > 0)
    refuse(wall, found(report.zero_area, "triangles without area") + remedy);
  if (report.duplicates.count > 0)
    refuse(wall, found(report.duplicates, "triangles that repeat an earlier one") + remedy);
}

void refuse_bad_edges(const Mesh& wall, const MeshReport& report) {
  if (report.non_manifold_edges.count > 0)
    refuse(wall, found(report.non_manifold_edges, "edges of more than two triangles") +
                     "; split the parts that meet there into meshes of their own");
  if (report.rim_edges.count == 0 || wall.open) return;
  refuse(wall,
         found(report.rim_edges, "edges of one triangle only, so the surface is open") +
             (report.t_junctions.count > 0
                  ? "; among them " + found(report.t_junctions, "corners that lie within an edge")
                  : "") +
             "; close it or, if it is meant to have a rim, set open = true");
}

}  // namespace

TriangleMesh weld(const std::vector<Triangle>& triangles) {
  TriangleMesh mesh;
  mesh.triangles.reserve(triangles.size());
  if (triangles.empty()) return mesh;
  Vec3 lower = triangles.front()[0];
  Vec3 upper = lower;
  for (const Triangle& triangle : triangles)
    for (const Vec3& corner : triangle) {
      lower = lower.cwiseMin(corner);
      upper = upper.cwiseMax(corner);
    }
  CornerGrid grid(lower, kWeldFraction * (upper - lower).norm());
  for (const Triangle& triangle : triangles) {
    std::array<std::int32_t, 3> ids{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t id = grid.find(triangle[k], mesh.corners);
      if (id < 0) {
        id = static_cast<std::int32_t>(mesh.corners.size());
        mesh.corners.push_back(triangle[k]);
        grid.add(triangle[k], id);
      }
      ids[k] = id;
    }
    mesh.triangles.push_back(ids);
  }
  return mesh;
}

std::vector<HalfEdge> half_edges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles[t][k];
      const std::int32_t b = mesh.triangles[t][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& p, const HalfEdge& q) {
    if (p.first != q.first) return p.first < q.first;
    if (p.second != q.second) return p.second < q.second;
    return p.triangle < q.triangle;
  });
  return edges;
}

LoadedMesh load_mesh(const Mesh& wall) {
  if (!(wall.scale > 0.0) || !std::isfinite(wall.scale) || !wall.translation.allFinite())
    refuse(wall, "scale = " + shortest(wall.scale) + " must be above 0 and translation finite");
  const std::string bytes = read_file(wall.file);
  if (wall.content_hash != 0 && content_hash(bytes) != wall.content_hash)
    refuse(wall,
           "the file is not the one that the case was written for (its content_hash differs); "
           "bring that one back or read the case anew");
  const std::vector<Triangle> triangles = placed_triangles(wall, bytes);
  if (triangles.empty()) refuse(wall, "has no triangle; export it again");
  LoadedMesh loaded;
  loaded.mesh = weld(triangles);
  const std::int64_t moved = moved_corners(triangles, loaded.mesh);
  const DegenerateTriangles degenerate = drop_degenerate(loaded.mesh);
  if (!wall.drop_degenerate) refuse_degenerate(wall, degenerate);
  if (loaded.mesh.triangles.empty()) refuse(wall, "none of its triangles has an area");
  loaded.report = inspect(loaded.mesh);
  loaded.report.moved_corners = moved;
  loaded.report.zero_area = degenerate.zero_area;
  loaded.report.duplicates = degenerate.duplicates;
  refuse_bad_edges(wall, loaded.report);
  return loaded;
}

}  // namespace repose::scene

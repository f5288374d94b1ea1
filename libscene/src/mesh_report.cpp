// What is wrong with a mesh.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "degenerate_triangles.hpp"
#include "repose/scene/cross.hpp"

namespace repose::scene {
namespace {

/// Twice the area along the normal.
Vec3 area_vector(const TriangleMesh& mesh, std::size_t t) {
  return cross(mesh.corner(t, 1) - mesh.corner(t, 0), mesh.corner(t, 2) - mesh.corner(t, 0));
}

Vec3 middle(const TriangleMesh& mesh, std::size_t t) {
  return (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0;
}

void count(MeshFinding& finding, const Vec3& x) {
  if (finding.count++ == 0) finding.first = x;
}

double diagonal(const TriangleMesh& mesh) {
  if (mesh.corners.empty()) return 0.0;
  Vec3 lower = mesh.corners.front();
  Vec3 upper = lower;
  for (const Vec3& x : mesh.corners) {
    lower = lower.cwiseMin(x);
    upper = upper.cwiseMax(x);
  }
  return (upper - lower).norm();
}

bool has_no_area(const TriangleMesh& mesh, std::size_t t, double distance) {
  double longest = 0.0;
  for (std::size_t k = 0; k < 3; ++k)
    longest = std::max(longest, (mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k)).norm());
  return area_vector(mesh, t).norm() <= distance * longest;
}

/// For each triangle whether an earlier one has the same corners.
std::vector<bool> repeats(const TriangleMesh& mesh) {
  std::vector<std::pair<std::array<std::int32_t, 3>, std::size_t>> sorted;
  sorted.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<std::int32_t, 3> ids = mesh.triangles[t];
    std::sort(ids.begin(), ids.end());
    sorted.push_back({ids, t});
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<bool> repeated(mesh.triangles.size(), false);
  for (std::size_t k = 1; k < sorted.size(); ++k)
    repeated[sorted[k].second] = sorted[k].first == sorted[k - 1].first;
  return repeated;
}

/// Points in a balanced k-d tree, for "which lie near this segment?".
class PointTree {
 public:
  PointTree(const std::vector<Vec3>& points, std::vector<std::int32_t> chosen)
      : points_(points), ids_(std::move(chosen)) {
    build(0, ids_.size(), 0);
  }

  /// Calls visit(id) for at least all points whose distance to the segment a-b is below `distance`.
  template <class Visit>
  void near(const Vec3& a, const Vec3& b, double distance, const Visit& visit) const {
    search(0, ids_.size(), 0, a, b, distance, visit);
  }

 private:
  const Vec3& point(std::size_t k) const { return points_[static_cast<std::size_t>(ids_[k])]; }

  void build(std::size_t begin, std::size_t end, int axis) {
    if (end - begin < 2) return;
    const std::size_t half = begin + (end - begin) / 2;
    const auto at = [&](std::size_t k) { return ids_.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(at(begin), at(half), at(end), [&](std::int32_t p, std::int32_t q) {
      return points_[static_cast<std::size_t>(p)][axis] <
             points_[static_cast<std::size_t>(q)][axis];
    });
    build(begin, half, (axis + 1) % 3);
    build(half + 1, end, (axis + 1) % 3);
  }

  /// The part of the segment on one side of a splitting plane goes down that side.
  template <class Visit>
  void search(std::size_t begin, std::size_t end, int axis, Vec3 a, Vec3 b, double distance,
              const Visit& visit) const {
    if (begin >= end) return;
    const std::size_t half = begin + (end - begin) / 2;
    visit(ids_[half]);
    const double split = point(half)[axis];
    if (a[axis] > b[axis]) std::swap(a, b);
    const int next = (axis + 1) % 3;
    const auto cut = [&](double at) -> Vec3 {
      const double t = std::clamp((at - a[axis]) / (b[axis] - a[axis]), 0.0, 1.0);
      return a + t * (b - a);
    };
    if (a[axis] <= split + distance)
      search(begin, half, next, a, b[axis] > split + distance ? cut(split + distance) : b, distance,
             visit);
    if (b[axis] >= split - distance)
      search(half + 1, end, next, a[axis] < split - distance ? cut(split - distance) : a, b,
             distance, visit);
  }

  const std::vector<Vec3>& points_;
  std::vector<std::int32_t> ids_;
};

/// Corners of rim edges that lie within another rim edge.
MeshFinding find_t_junctions(const TriangleMesh& mesh, const std::vector<HalfEdge>& rim,
                             double distance) {
  std::vector<std::int32_t> corners;
  for (const HalfEdge& edge : rim) {
    corners.push_back(edge.first);
    corners.push_back(edge.second);
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  const PointTree tree(mesh.corners, corners);
  std::vector<bool> found(mesh.corners.size(), false);
  for (const HalfEdge& edge : rim) {
    const Vec3& a = mesh.corners[static_cast<std::size_t>(edge.first)];
    const Vec3& b = mesh.corners[static_cast<std::size_t>(edge.second)];
    tree.near(a, b, distance, [&](std::int32_t c) {
      if (c == edge.first || c == edge.second) return;
      const Vec3& x = mesh.corners[static_cast<std::size_t>(c)];
      const double along = (x - a).dot(b - a) / (b - a).squaredNorm();
      if (along <= 0.0 || along >= 1.0) return;
      if ((a + along * (b - a) - x).norm() <= distance) found[static_cast<std::size_t>(c)] = true;
    });
  }
  MeshFinding junctions;
  for (const std::int32_t c : corners)
    if (found[static_cast<std::size_t>(c)])
      count(junctions, mesh.corners[static_cast<std::size_t>(c)]);
  return junctions;
}

/// Disjoint sets of triangles.
class Components {
 public:
  explicit Components(std::size_t n) : parent_(n), count_(static_cast<std::int64_t>(n)) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  void join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return;
    parent_[std::max(a, b)] = std::min(a, b);
    --count_;
  }
  std::int64_t count() const { return count_; }

 private:
  std::size_t root(std::size_t a) {
    while (parent_[a] != a) a = parent_[a] = parent_[parent_[a]];
    return a;
  }
  std::vector<std::size_t> parent_;
  std::int64_t count_;
};

void look_at_edges(const TriangleMesh& mesh, double distance, MeshReport& report) {
  const std::vector<HalfEdge> edges = half_edges(mesh);
  Components components(mesh.triangles.size());
  std::vector<HalfEdge> rim;
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].first == edges[begin].first &&
           edges[end].second == edges[begin].second)
      ++end;
    const Vec3 at = 0.5 * (mesh.corners[static_cast<std::size_t>(edges[begin].first)] +
                           mesh.corners[static_cast<std::size_t>(edges[begin].second)]);
    for (std::size_t k = begin + 1; k < end; ++k)
      components.join(static_cast<std::size_t>(edges[begin].triangle),
                      static_cast<std::size_t>(edges[k].triangle));
    if (end - begin == 1) {
      rim.push_back(edges[begin]);
      count(report.rim_edges, at);
    } else if (end - begin > 2) {
      count(report.non_manifold_edges, at);
    } else if (edges[begin].forward == edges[begin + 1].forward) {
      count(report.inconsistent_edges, at);
    }
  }
  report.components = components.count();
  report.t_junctions = find_t_junctions(mesh, rim, distance);
}

}  // namespace

DegenerateTriangles find_degenerate(const TriangleMesh& mesh) {
  TriangleMesh copy = mesh;
  return drop_degenerate(copy);
}

DegenerateTriangles drop_degenerate(TriangleMesh& mesh) {
  DegenerateTriangles result;
  const double distance = kWeldFraction * diagonal(mesh);
  const std::vector<bool> repeated = repeats(mesh);
  std::vector<std::array<std::int32_t, 3>> kept;
  kept.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (has_no_area(mesh, t, distance))
      count(result.zero_area, middle(mesh, t));
    else if (repeated[t])
      count(result.duplicates, middle(mesh, t));
    else
      kept.push_back(mesh.triangles[t]);
  }
  mesh.triangles = std::move(kept);
  return result;
}

MeshReport inspect(const TriangleMesh& mesh) {
  MeshReport report;
  report.triangles = static_cast<std::int64_t>(mesh.triangles.size());
  report.corners = static_cast<std::int64_t>(mesh.corners.size());
  if (mesh.triangles.empty()) return report;
  const DegenerateTriangles degenerate = find_degenerate(mesh);
  report.zero_area = degenerate.zero_area;
  report.duplicates = degenerate.duplicates;
  report.lower = report.upper = mesh.corner(0, 0);
  for (const Vec3& x : mesh.corners) {
    report.lower = report.lower.cwiseMin(x);
    report.upper = report.upper.cwiseMax(x);
  }
  double volume = 0.0;
  const Vec3 origin = 0.5 * (report.lower + report.upper);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    report.area_m2 += 0.5 * area_vector(mesh, t).norm();
    volume += (mesh.corner(t, 0) - origin).dot(area_vector(mesh, t)) / 6.0;
  }
  look_at_edges(mesh, kWeldFraction * (report.upper - report.lower).norm(), report);
  if (report.rim_edges.count + report.non_manifold_edges.count + report.inconsistent_edges.count ==
      0)
    report.volume_m3 = volume;
  return report;
}

std::string mesh_report_text(const MeshReport& report) {
  std::string text =
      fmt::format("{} triangles, {} corners ({} moved by welding), {} {}, area {:.6g} m2, ",
                  report.triangles, report.corners, report.moved_corners, report.components,
                  report.components == 1 ? "part" : "parts", report.area_m2);
  text += report.volume_m3 ? fmt::format("volume {:.6g} m3", *report.volume_m3) : "not closed";
  const auto add = [&](const MeshFinding& finding, const char* what) {
    if (finding.count > 0) text += fmt::format(", {} {}", finding.count, what);
  };
  add(report.zero_area, "triangles without area");
  add(report.duplicates, "repeated triangles");
  add(report.rim_edges, "rim edges");
  add(report.t_junctions, "T-junctions");
  add(report.non_manifold_edges, "edges of more than two triangles");
  add(report.inconsistent_edges, "edges between opposite orientations");
  return text;
}

}  // namespace repose::scene

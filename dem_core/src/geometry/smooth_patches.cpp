#include "geometry/smooth_patches.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

#include "repose/dem/cross.hpp"

namespace repose::dem {
namespace {

constexpr double kFlat = 1e-12;  // of the cosine: what rounding leaves of coplanar triangles

Vec3 normal_of(const scene::TriangleMesh& mesh, std::size_t t) {
  return cross(mesh.corner(t, 1) - mesh.corner(t, 0), mesh.corner(t, 2) - mesh.corner(t, 0))
      .normalized();
}

std::int32_t root(std::vector<std::int32_t>& parent, std::int32_t a) {
  const auto at = [&](std::int32_t i) -> std::int32_t& {
    return parent[static_cast<std::size_t>(i)];
  };
  while (at(a) != a) a = at(a) = at(at(a));
  return a;
}

}  // namespace

std::vector<std::int32_t> smooth_patches(const scene::TriangleMesh& mesh, double smooth_deg) {
  const double least_cosine = std::cos(smooth_deg * std::numbers::pi / 180.0) - kFlat;
  const std::vector<scene::HalfEdge> edges = scene::half_edges(mesh);
  const auto same_edge = [&](std::size_t a, std::size_t b) {
    return b < edges.size() && edges[a].first == edges[b].first &&
           edges[a].second == edges[b].second;
  };
  std::vector<std::int32_t> parent(mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (same_edge(begin, end)) ++end;
    if (end - begin != 2) continue;
    const scene::HalfEdge& a = edges[begin];
    const scene::HalfEdge& b = edges[begin + 1];
    const double cosine = normal_of(mesh, static_cast<std::size_t>(a.triangle))
                              .dot(normal_of(mesh, static_cast<std::size_t>(b.triangle)));
    if ((a.forward == b.forward ? -cosine : cosine) < least_cosine) continue;
    const std::int32_t p = root(parent, a.triangle);
    const std::int32_t q = root(parent, b.triangle);
    parent[static_cast<std::size_t>(std::max(p, q))] = std::min(p, q);
  }
  std::vector<std::int32_t> number(parent.size(), -1);
  std::vector<std::int32_t> patches;
  patches.reserve(parent.size());
  std::int32_t count = 0;
  for (std::size_t t = 0; t < parent.size(); ++t) {
    const auto r = static_cast<std::size_t>(root(parent, static_cast<std::int32_t>(t)));
    if (number[r] < 0) number[r] = count++;
    patches.push_back(number[r]);
  }
  return patches;
}

}  // namespace repose::dem

#include "geometry/smooth_patches.hpp"

#include <cmath>
#include <numbers>
#include <numeric>

#include "repose/dem/cross.hpp"

namespace repose::dem {
namespace {

constexpr double kFlat = 1e-12;      // of the cosine: what rounding leaves of coplanar triangles
constexpr double kSamePlace = 1e-9;  // of the size of two facets

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

double size_of(const Facet& facet) {
  return std::sqrt(facet.uu) + std::sqrt(facet.vv) + facet.end_radius + facet.length;
}

bool in_one_plane(const Facet& a, const Facet& b) {
  if (std::abs(a.normal.dot(b.normal)) < 1.0 - kFlat) return false;
  const Vec3 offset = b.origin - a.origin;
  return std::abs(offset.dot(a.normal)) <= kSamePlace * (offset.norm() + size_of(a) + size_of(b));
}

/// One end of a section of revolution: its circle, and the direction in which the surface comes out
/// of it there: `across` from the axis and `along` a given direction of it.
struct SectionEnd {
  Vec3 centre;
  double radius, across, along;
};

SectionEnd end_of(const Facet& f, bool is_start, const Vec3& axis) {
  const double away = is_start ? -1.0 : 1.0;
  const double slope = f.end_radius - f.start_radius;
  const double scale = away / std::hypot(slope, f.length);
  return {is_start ? f.origin : Vec3(f.origin + f.length * f.normal),
          is_start ? f.start_radius : f.end_radius, slope * scale,
          f.length * scale * f.normal.dot(axis)};
}

bool are_joined_sections(const Facet& a, const Facet& b) {
  if (std::abs(a.normal.dot(b.normal)) < 1.0 - kFlat) return false;
  const double tolerance = kSamePlace * (size_of(a) + size_of(b));
  for (const bool start_of_a : {true, false})
    for (const bool start_of_b : {true, false}) {
      const SectionEnd p = end_of(a, start_of_a, a.normal);
      const SectionEnd q = end_of(b, start_of_b, a.normal);
      if ((p.centre - q.centre).norm() <= tolerance && std::abs(p.radius - q.radius) <= tolerance &&
          p.across * q.across + p.along * q.along <= -1.0 + kFlat)
        return true;
    }
  return false;
}

}  // namespace

bool are_one_surface(const Facet& a, const Facet& b) {
  if (is_flat(a) != is_flat(b)) return false;
  return is_flat(a) ? in_one_plane(a, b) : are_joined_sections(a, b);
}

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

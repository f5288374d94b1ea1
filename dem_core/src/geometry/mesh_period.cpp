#include "geometry/mesh_period.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/box.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem {
namespace {

constexpr double kSameEnd = 1e-6;  // of the period: more than drawings in single precision leave
constexpr double kSameCut = 1e-5;  // of the mesh's size

/// A piece of the line in which a plane across an axis cuts a mesh, seen along the axis.
struct Piece {
  Vec3 start, end;
};

std::vector<Piece> cut(const scene::TriangleMesh& mesh, int axis, double at) {
  std::vector<Piece> pieces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Vec3 ends[3];
    int count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.corner(t, k);
      const Vec3& q = mesh.corner(t, (k + 1) % 3);
      if ((p[axis] < at) == (q[axis] < at)) continue;
      ends[count] = p + (at - p[axis]) / (q[axis] - p[axis]) * (q - p);
      ends[count++][axis] = 0.0;
    }
    if (count == 2) pieces.push_back({ends[0], ends[1]});
  }
  return pieces;
}

double distance_from(const Piece& piece, const Vec3& x) {
  const Vec3 along = piece.end - piece.start;
  const double length2 = along.squaredNorm();
  const double t =
      length2 > 0.0 ? std::clamp((x - piece.start).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (piece.start + t * along - x).norm();
}

/// Whether the ends and the middle of each piece lie on the others.
bool lie_on(const std::vector<Piece>& pieces, const std::vector<Piece>& others, double tolerance) {
  const auto lies = [&](const Vec3& x) {
    return std::any_of(others.begin(), others.end(),
                       [&](const Piece& other) { return distance_from(other, x) <= tolerance; });
  };
  return std::all_of(pieces.begin(), pieces.end(), [&](const Piece& piece) {
    return lies(piece.start) && lies(piece.end) && lies(0.5 * (piece.start + piece.end));
  });
}

void check_axis(const Box& box, int axis, const std::string& wall, const scene::LoadedMesh& mesh) {
  const double lower = mesh.report.lower[axis];
  const double upper = mesh.report.upper[axis];
  const double slack = kSameEnd * box.length[axis];
  if (lower >= box.lower[axis] - slack && upper <= box.upper[axis] + slack) return;
  const std::string what = "wall \"" + wall + "\": ";
  const std::string period = "the period from " + shortest(box.lower[axis]) + " to " +
                             shortest(box.upper[axis]) + " m of direction " + "xyz"[axis];
  if (lower > box.lower[axis] + slack || upper < box.upper[axis] - slack)
    throw InputError(what + "reaches from " + shortest(lower) + " to " + shortest(upper) +
                     " m; it must span " + period + " or lie within it");
  const std::vector<Piece> first = cut(mesh.mesh, axis, box.lower[axis] + slack);
  const std::vector<Piece> last = cut(mesh.mesh, axis, box.upper[axis] - slack);
  const double tolerance = kSameCut * (mesh.report.upper - mesh.report.lower).norm();
  if (first.empty() || !lie_on(first, last, tolerance) || !lie_on(last, first, tolerance))
    throw InputError(what + "its cuts at the two ends of the period differ; a mesh that spans " +
                     period + " must go on as its images do, or lie within it");
}

}  // namespace

void require_periodic(const scene::Case& scene, const std::string& wall,
                      const scene::LoadedMesh& mesh) {
  const Box box(scene);
  for (int k = 0; k < 3; ++k)
    if (box.periodic[k]) check_axis(box, k, wall, mesh);
}

}  // namespace repose::dem

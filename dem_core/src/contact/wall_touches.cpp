#include "contact/wall_touches.hpp"

#include <algorithm>
#include <limits>

namespace repose::dem {
namespace {

/// Points closer than this part of the radius are one: beyond the rounding of drawings in single
/// precision, below what matters to a sphere.
constexpr double kSamePoint = 1e-4;

/// Whether the straight way from x to q goes through a flat facet; both in its frame.
bool crosses(const Facet& facet, const Vec3& x, const Vec3& q, double tolerance) {
  const double before = (x - facet.origin).dot(facet.normal);
  const double beyond = (q - facet.origin).dot(facet.normal);
  if (before * beyond >= 0.0 || std::abs(beyond) < tolerance) return false;
  const Vec3 crossing = x + before / (before - beyond) * (q - x);
  return std::abs(closest_point(facet, crossing).distance) < tolerance;
}

/// How far the closest point a lies from the line in which the planes through a and b, normal to
/// their directions, intersect.
double way_to_crease(const ClosestPoint& a, const ClosestPoint& b) {
  const double cosine = a.direction.dot(b.direction);
  const double sine = cross(a.direction, b.direction).norm();
  return sine > 0.0 ? std::abs(a.distance * cosine - b.distance) / sine : 0.0;
}

/// Between two facets of a hollow smooth surface the normal turns evenly while the sphere touches
/// both: a point on its crease has no weight, so none jumps in or out.
Vec3 smooth_normal(const std::vector<ClosestPoint>& points) {
  if (points.size() == 1) return points.front().direction;
  Vec3 sum = Vec3::Zero();
  for (const ClosestPoint& a : points) {
    double weight = std::numeric_limits<double>::infinity();
    for (const ClosestPoint& b : points)
      if (&a != &b) weight = std::min(weight, way_to_crease(a, b));
    sum += weight * a.direction;
  }
  const double length = sum.norm();
  return length > 0.0 ? Vec3(sum * (1.0 / length)) : points.front().direction;
}

}  // namespace

bool WallTouches::comes_before(const Touch& a, const Touch& b) {
  if (a.point.feature != b.point.feature) return a.point.feature == Feature::face;
  if (a.point.distance != b.point.distance) return a.point.distance < b.point.distance;
  return a.facet < b.facet;
}

const std::vector<WallPush>& WallTouches::find(const Walls& walls, const Vec3& x, double radius,
                                               std::span<const NearFacet> facets, double moved) {
  touches_.clear();
  pushes_.clear();
  for (const NearFacet& near : facets) {
    if (near.gap > moved || !walls.wall_of(walls.facet(near.facet)).present) continue;
    const ClosestPoint point = walls.closest_point(near.facet, x);
    if (point.distance < radius) touches_.push_back({point, near.facet, 0});
  }
  if (touches_.empty()) return pushes_;
  select(walls, x, radius);
  group_smooth(walls);
  merge_groups(walls, radius);
  return pushes_;
}

void WallTouches::select(const Walls& walls, const Vec3& x, double radius) {
  accepted_.clear();
  if (touches_.size() > 1) std::sort(touches_.begin(), touches_.end(), comes_before);
  for (std::size_t t = 0; t < touches_.size(); ++t)
    if (!is_dropped(walls, x, radius, t) && !is_hidden(walls, x, radius, t))
      accepted_.push_back(touches_[t]);
}

bool WallTouches::is_hidden(const Walls& walls, const Vec3& x, double radius, std::size_t t) const {
  const Vec3 point = x + touches_[t].point.offset();
  for (const Touch& other : touches_) {
    const Facet& facet = walls.facet(other.facet);
    if (other.point.distance >= touches_[t].point.distance || !is_flat(facet)) continue;
    const Pose& pose = walls.wall_of(facet).now.pose;
    if (crosses(facet, pose.to_drawn(x), pose.to_drawn(point), kSamePoint * radius)) return true;
  }
  return false;
}

bool WallTouches::is_dropped(const Walls& walls, const Vec3& x, double radius,
                             std::size_t t) const {
  const double tolerance = kSamePoint * radius;
  const Touch& touch = touches_[t];
  const Vec3 offset = touch.point.offset();
  for (const Touch& other : accepted_)
    if ((offset - other.point.offset()).squaredNorm() < tolerance * tolerance) return true;
  if (touch.point.feature == Feature::face) return false;
  const Vec3 on_rim = x + offset;
  for (std::size_t k = t; k-- > 0;)  // those of similar depth are the likely ones
    if (std::abs(walls.closest_point(touches_[k].facet, on_rim).distance) < tolerance) return true;
  return false;
}

/// Numbers the accepted touches so that those of one smooth contact have the same group.
void WallTouches::group_smooth(const Walls& walls) {
  for (std::size_t a = 0; a < accepted_.size(); ++a) {
    accepted_[a].group = static_cast<std::int32_t>(a);
    const Facet& facet = walls.facet(accepted_[a].facet);
    for (std::size_t b = 0; b < a; ++b) {
      if (walls.facet(accepted_[b].facet).patch != facet.patch) continue;
      const double cosine = accepted_[a].point.direction.dot(accepted_[b].point.direction);
      if (cosine < walls.wall_of(facet).smooth_cosine) continue;
      const std::int32_t from = accepted_[a].group;
      const std::int32_t to = accepted_[b].group;
      for (std::size_t c = 0; c <= a; ++c)
        if (accepted_[c].group == from) accepted_[c].group = to;
    }
  }
}

void WallTouches::merge_groups(const Walls& walls, double radius) {
  for (std::size_t a = 0; a < accepted_.size(); ++a) {
    const std::int32_t group = accepted_[a].group;
    members_.clear();
    bool is_first = true;
    for (std::size_t b = 0; b < accepted_.size(); ++b) {
      if (accepted_[b].group != group) continue;
      is_first = is_first && b >= a;
      members_.push_back(accepted_[b].point);
    }
    if (!is_first) continue;
    const Facet& facet = walls.facet(accepted_[a].facet);
    double closest = members_.front().distance;
    for (const ClosestPoint& member : members_) closest = std::min(closest, member.distance);
    pushes_.push_back({smooth_normal(members_), radius - closest, facet.wall, facet.patch});
  }
}

}  // namespace repose::dem

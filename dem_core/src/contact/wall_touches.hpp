// Where one sphere touches the walls: which closest points of facets are contacts.
#pragma once

#include <span>
#include <vector>

#include "geometry/walls.hpp"

namespace repose::dem {

/// One contact of a sphere with a wall.
struct WallPush {
  Vec3 normal;  ///< unit, from the sphere to the wall
  double overlap;
  std::int32_t wall;
  std::int32_t patch;
};

/// Contacts are the points of the walls whose distance from the centre is a local minimum; so a
/// surface pushes once however it is cut into facets.
/// Faces come first, by depth, then rims (edges and corners), by depth. A rim point is dropped if
/// it lies on a facet that came before it, because then that facet comes closer: seams in a plane,
/// edges that facets share, corners of a box [Santasusana2016, hierarchy of contacts]; what remains
/// of an edge is met between the normals of its facets. A face is dropped if an accepted contact
/// has the same point. A point that another flat facet hides is dropped: the far side of a thin
/// plate. What remains on one smooth patch under nearly the same normal is one
/// contact, with the largest overlap and a normal that turns evenly from one facet's to the next.
class WallTouches {
 public:
  /// `facets` are those that the sphere may touch, with their gaps before it and the walls together
  /// moved by up to `moved`. The result is valid until the next call.
  const std::vector<WallPush>& find(const Walls& walls, const Vec3& x, double radius,
                                    std::span<const NearFacet> facets, double moved);

 private:
  struct Touch {
    ClosestPoint point;
    std::int32_t facet;
    std::int32_t group;  // of the smooth contact that it is part of
  };
  static bool comes_before(const Touch& a, const Touch& b);
  void select(const Walls& walls, const Vec3& x, double radius);
  bool is_dropped(const Walls& walls, const Vec3& x, double radius, std::size_t t) const;
  bool is_hidden(const Walls& walls, const Vec3& x, double radius, std::size_t t) const;
  void group_smooth(const Walls& walls);
  void merge_groups(const Walls& walls, double radius);

  std::vector<Touch> touches_;  // all, in the order of acceptance
  std::vector<Touch> accepted_;
  std::vector<ClosestPoint> members_;
  std::vector<WallPush> pushes_;
};

}  // namespace repose::dem

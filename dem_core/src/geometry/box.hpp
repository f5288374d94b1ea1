// The domain: where spheres may be, and the nearest image across its periodic sides.
#pragma once

#include <limits>

#include "repose/dem/contact_law.hpp"
#include "repose/scene/case.hpp"

namespace repose::dem {

struct Box {
  Vec3 lower;
  Vec3 upper;
  bool periodic[3];
  Vec3 length;  ///< period; 0 where not periodic
  Vec3 half;    ///< half of the period; infinite where not periodic

  explicit Box(const scene::Case& scene)
      : lower(scene.lower_m),
        upper(scene.upper_m),
        periodic{scene.periodic.x, scene.periodic.y, scene.periodic.z} {
    for (int k = 0; k < 3; ++k) {
      length[k] = periodic[k] ? upper[k] - lower[k] : 0.0;
      half[k] = periodic[k] ? 0.5 * length[k] : std::numeric_limits<double>::infinity();
    }
  }

  /// Bit k is set if direction k is periodic.
  int periodic_mask() const {
    return (periodic[0] ? 1 : 0) | (periodic[1] ? 2 : 0) | (periodic[2] ? 4 : 0);
  }

  /// The shortest of all images of a difference of two positions in the box.
  Vec3 nearest_image(const Vec3& d) const { return nearest_image_in<7>(d); }
  /// The same with the periodic directions known when compiled; kMask is periodic_mask().
  template <int kMask>
  Vec3 nearest_image_in(Vec3 d) const {
    for (int k = 0; k < 3; ++k) {
      if ((kMask & (1 << k)) == 0) continue;
      if (d[k] > half[k]) d[k] -= length[k];
      if (d[k] < -half[k]) d[k] += length[k];
    }
    return d;
  }

  /// The image of x in the box; x lies at most a period outside.
  Vec3 wrapped(Vec3 x) const {
    for (int k = 0; k < 3; ++k) {
      if (!periodic[k]) continue;
      if (x[k] >= upper[k]) x[k] -= length[k];
      if (x[k] < lower[k]) x[k] += length[k];
      if (x[k] >= upper[k]) x[k] = lower[k];  // rounding of x + length
    }
    return x;
  }

  /// False also for a position that is not a number.
  bool contains(const Vec3& x) const {
    return x.x() >= lower.x() && x.x() < upper.x() && x.y() >= lower.y() && x.y() < upper.y() &&
           x.z() >= lower.z() && x.z() < upper.z();
  }
};

/// Calls function.operator()<mask>() with the mask of the box, so that inner loops need not ask.
template <class Function>
decltype(auto) with_periodic_mask(const Box& box, Function&& function) {
  switch (box.periodic_mask()) {
    case 0:
      return function.template operator()<0>();
    case 1:
      return function.template operator()<1>();
    case 2:
      return function.template operator()<2>();
    case 4:
      return function.template operator()<4>();
    default:
      return function.template operator()<7>();
  }
}

}  // namespace repose::dem

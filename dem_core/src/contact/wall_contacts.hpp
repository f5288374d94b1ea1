// Contacts with walls as they are kept from step to step.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/contact_pool.hpp"

namespace repose::dem {

/// Known by sphere and patch, so that it lives on when the sphere passes from facet to facet; of
/// several on one patch (in a groove, between the sides of a tube) by the nearest normal.
struct alignas(64) WallContact {
  Vec3 normal;  ///< from the sphere to the wall, as the overlap of the last step
  double overlap;
  std::int32_t sphere;  ///< index
  std::int32_t patch;
  std::int32_t wall;
  Contact contact;
};
static_assert(sizeof(WallContact) == 128);  // the kernels see it as rows of four numbers

/// All of them, by ascending sphere; the room of the step before is used again.
struct WallContacts {
  std::vector<WallContact> all;
  std::vector<WallContact> before;
  ExactSum released_j;  ///< what ended contacts still stored; it is lost

  /// After spheres were sorted or removed: new_index of a sphere, -1 if it is gone.
  void follow_order(const std::vector<std::int32_t>& new_index);
  /// Ends those with one wall.
  void end_with(std::int32_t wall);

 private:
  template <class Predicate>
  void erase_ended(Predicate&& has_ended);
};

}  // namespace repose::dem

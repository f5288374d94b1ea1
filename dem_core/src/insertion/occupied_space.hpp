// Spheres placed so far, in cells, for a fast test of overlap.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/box.hpp"

namespace repose::dem {

/// Covers the column from `lower` to `upper` (the whole period where the box is periodic) with
/// cells at least `width` wide; width must be the largest diameter that will ever be added or asked
/// for. Cells are wider if they would be many more than `spheres`. Spheres outside the column count
/// too.
class OccupiedSpace {
 public:
  OccupiedSpace(const Box& box, const Vec3& lower, const Vec3& upper, double width,
                std::size_t spheres);

  void add(const Vec3& x, double radius);
  /// Whether a sphere would overlap none of those added.
  bool is_free(const Vec3& x, double radius) const;

 private:
  struct Ball {
    Vec3 x;
    double radius;
  };

  void locate(const Vec3& x, int c[3]) const;
  bool shift_inside(int c[3]) const;
  std::size_t slot(const int c[3]) const;
  bool overlaps(const std::vector<Ball>& balls, const Vec3& x, double radius) const;

  const Box& box_;
  Vec3 origin_;
  Vec3 width_;
  int count_[3];
  std::vector<std::vector<Ball>> cells_;
};

}  // namespace repose::dem

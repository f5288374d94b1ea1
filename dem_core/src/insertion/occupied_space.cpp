#include "insertion/occupied_space.hpp"

#include <algorithm>
#include <cmath>

namespace repose::dem {

OccupiedSpace::OccupiedSpace(const Box& box, const Vec3& lower, const Vec3& upper, double width,
                             std::size_t spheres)
    : box_(box) {
  Vec3 extent;
  for (int k = 0; k < 3; ++k) {
    origin_[k] = box.periodic[k] ? box.lower[k] : lower[k];
    extent[k] = (box.periodic[k] ? box.upper[k] : upper[k]) - origin_[k];
  }
  const double most_cells = 4096.0 + 16.0 * static_cast<double>(spheres);
  Vec3 count;
  for (;; width *= 1.26) {  // half as many cells
    for (int k = 0; k < 3; ++k) count[k] = std::max(1.0, std::floor(extent[k] / width));
    if (count.prod() <= most_cells) break;
  }
  for (int k = 0; k < 3; ++k) {
    count_[k] = static_cast<int>(count[k]);
    width_[k] = extent[k] / count[k];
  }
  cells_.resize(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                static_cast<std::size_t>(count_[2]));
}

void OccupiedSpace::add(const Vec3& x, double radius) {
  int c[3];
  locate(x, c);
  cells_[slot(c)].push_back({x, radius});
}

bool OccupiedSpace::is_free(const Vec3& x, double radius) const {
  int c[3];
  locate(x, c);
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        int other[3] = {c[0] + dx, c[1] + dy, c[2] + dz};
        if (shift_inside(other) && overlaps(cells_[slot(other)], x, radius)) return false;
      }
  return true;
}

void OccupiedSpace::locate(const Vec3& x, int c[3]) const {
  for (int k = 0; k < 3; ++k) {
    const double cell = std::floor((x[k] - origin_[k]) / width_[k]);
    c[k] = static_cast<int>(std::clamp(cell, 0.0, static_cast<double>(count_[k] - 1)));
  }
}

bool OccupiedSpace::shift_inside(int c[3]) const {
  for (int k = 0; k < 3; ++k) {
    if (box_.periodic[k]) c[k] = (c[k] + count_[k]) % count_[k];
    if (c[k] < 0 || c[k] >= count_[k]) return false;
  }
  return true;
}

std::size_t OccupiedSpace::slot(const int c[3]) const {
  return static_cast<std::size_t>((c[2] * count_[1] + c[1]) * count_[0] + c[0]);
}

bool OccupiedSpace::overlaps(const std::vector<Ball>& balls, const Vec3& x, double radius) const {
  for (const Ball& ball : balls) {
    const double reach = radius + ball.radius;
    if (box_.nearest_image(ball.x - x).squaredNorm() < reach * reach) return true;
  }
  return false;
}

}  // namespace repose::dem

#include "neighbor/cell_grid.hpp"

#include <algorithm>
#include <cmath>

namespace repose::dem {
namespace {

/// The low 21 bits of v, two zero bits between each.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

std::uint64_t compact(std::uint64_t v) {
  v &= 0x1249249249249249;
  v = (v ^ v >> 2) & 0x10c30c30c30c30c3;
  v = (v ^ v >> 4) & 0x100f00f00f00f00f;
  v = (v ^ v >> 8) & 0x1f0000ff0000ff;
  v = (v ^ v >> 16) & 0x1f00000000ffff;
  v = (v ^ v >> 32) & 0x1fffff;
  return v;
}

/// Few enough cells for a dense table: its size is bounded by the number of spheres.
std::size_t most_cells(std::size_t spheres) {
  return 4096 + 16 * spheres;
}

}  // namespace

std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

CellGrid::CellGrid(const Box& box, const std::vector<Motion>& motion, double reach) {
  Vec3 lower = box.upper;
  Vec3 upper = box.lower;
  for (const Motion& sphere : motion) {
    lower = lower.cwiseMin(sphere.x);
    upper = upper.cwiseMax(sphere.x);
  }
  for (int k = 0; k < 3; ++k) {
    periodic_[k] = box.periodic[k];
    if (periodic_[k]) {
      lower[k] = box.lower[k];
      upper[k] = box.upper[k];
    }
    origin_[k] = lower[k];
  }
  for (double width = reach;; width *= 2.0) {  // wider cells where spheres are far apart
    double total = 1.0;
    double count[3];
    for (int k = 0; k < 3; ++k) {
      count[k] = std::max(1.0, std::floor((upper[k] - lower[k]) / width) + (periodic_[k] ? 0 : 1));
      total *= count[k];
    }
    if (total > static_cast<double>(most_cells(motion.size()))) continue;
    for (int k = 0; k < 3; ++k) {
      count_[k] = static_cast<std::int32_t>(count[k]);
      width_[k] = periodic_[k] ? (upper[k] - lower[k]) / count[k] : width;
    }
    break;
  }
  keys_.reserve(motion.size());
  for (const Motion& sphere : motion) {
    std::uint32_t at[3];
    for (int k = 0; k < 3; ++k) {
      const auto cell = static_cast<std::int32_t>((sphere.x[k] - origin_[k]) / width_[k]);
      at[k] = static_cast<std::uint32_t>(std::clamp(cell, 0, count_[k] - 1));
    }
    keys_.push_back(morton_key(at[0], at[1], at[2]));
  }
}

std::size_t CellGrid::slot(const std::int32_t c[3]) const {
  return (static_cast<std::size_t>(c[2]) * static_cast<std::size_t>(count_[1]) +
          static_cast<std::size_t>(c[1])) *
             static_cast<std::size_t>(count_[0]) +
         static_cast<std::size_t>(c[0]);
}

void CellGrid::set_cells(const std::vector<std::uint64_t>& sorted_keys) {
  cells_.clear();
  cell_at_.assign(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                      static_cast<std::size_t>(count_[2]),
                  -1);
  for (std::size_t i = 0; i < sorted_keys.size(); ++i) {
    if (i == 0 || sorted_keys[i] != sorted_keys[i - 1]) {
      Cell cell;
      cell.key = sorted_keys[i];
      cell.first = static_cast<std::int32_t>(i);
      for (int k = 0; k < 3; ++k)
        cell.coordinate[k] = static_cast<std::int32_t>(compact(sorted_keys[i] >> k));
      cell_at_[slot(cell.coordinate)] = static_cast<std::int32_t>(cells_.size());
      cells_.push_back(cell);
    }
    cells_.back().last = static_cast<std::int32_t>(i + 1);
  }
}

void CellGrid::following_neighbors(std::size_t c, std::vector<std::int32_t>& neighbors) const {
  neighbors.clear();
  const Cell& cell = cells_[c];
  std::int32_t candidates[3][3];
  int counts[3];
  for (int k = 0; k < 3; ++k) {
    counts[k] = 0;
    for (int step = -1; step <= 1; ++step) {
      std::int32_t at = cell.coordinate[k] + step;
      if (periodic_[k]) at = (at + count_[k]) % count_[k];
      if (at < 0 || at >= count_[k]) continue;
      bool seen = false;
      for (int m = 0; m < counts[k]; ++m) seen = seen || candidates[k][m] == at;
      if (!seen) candidates[k][counts[k]++] = at;
    }
  }
  for (int z = 0; z < counts[2]; ++z)
    for (int y = 0; y < counts[1]; ++y)
      for (int x = 0; x < counts[0]; ++x) {
        const std::int32_t at[3] = {candidates[0][x], candidates[1][y], candidates[2][z]};
        const std::int32_t other = cell_at_[slot(at)];
        if (other > static_cast<std::int32_t>(c)) neighbors.push_back(other);
      }
  std::sort(neighbors.begin(), neighbors.end());
}

}  // namespace repose::dem

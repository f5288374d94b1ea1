// A grid of cells over the spheres, and the order of the spheres that it gives.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/box.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// Non-empty cells in Morton order; spheres sorted by (cell, id) make each cell a range of indices.
/// Cells are at least `reach` wide, so that all neighbors of a sphere are in its own or an adjacent
/// cell. Where the box is periodic the cells divide the period.
class CellGrid {
 public:
  CellGrid(const Box& box, const std::vector<Motion>& motion, double reach);

  /// For sphere i, as it was given to the constructor, the key of its cell.
  const std::vector<std::uint64_t>& keys() const { return keys_; }

  struct Cell {
    std::int32_t first, last;  ///< spheres [first, last) once sorted by (key, id)
    std::int32_t coordinate[3];
    std::uint64_t key;
  };
  /// `sorted_keys` are keys() in the new order.
  void set_cells(const std::vector<std::uint64_t>& sorted_keys);
  const std::vector<Cell>& cells() const { return cells_; }

  /// Indices of the non-empty cells adjacent to cell c that come after it, ascending; each cell
  /// once even if the box is only two cells wide.
  void following_neighbors(std::size_t c, std::vector<std::int32_t>& neighbors) const;

 private:
  std::size_t slot(const std::int32_t coordinate[3]) const;

  bool periodic_[3];
  Vec3 origin_;
  Vec3 width_;
  std::int32_t count_[3];
  std::vector<std::uint64_t> keys_;
  std::vector<Cell> cells_;
  std::vector<std::int32_t> cell_at_;  // dense table of indices into cells_, -1 where empty
};

/// Interleaves the low 21 bits of three numbers.
std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z);

}  // namespace repose::dem

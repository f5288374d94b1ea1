// A grid of cells over spheres of similar size: one level of the neighbor search.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/box.hpp"

namespace repose::dem {

/// What the search needs of a sphere, side by side for the spheres of a cell.
struct LocatedSphere {
  Vec3 x;
  double radius;
  std::int32_t index;
  std::int32_t body;
  bool is_ghost = false;
};

/// Cells at least `reach` wide, so that all spheres of this level which are closer than that to a
/// point are in its cell or an adjacent one. Where the box is periodic the cells divide the period;
/// elsewhere the grid reaches one cell beyond the spheres.
class LevelGrid {
 public:
  LevelGrid(const Box& box, std::vector<LocatedSphere> spheres, double reach);

  /// The spheres of a cell, in the order in which they were given.
  struct Cell {
    std::int32_t first, last;  ///< of spheres()
    std::int32_t slot;         ///< its number in the grid
  };
  const std::vector<LocatedSphere>& spheres() const { return spheres_; }  ///< by cell
  const std::vector<Cell>& cells() const { return cells_; }               ///< those not empty

  /// Where x is; -1 if no cell that holds a sphere is adjacent.
  std::int32_t slot_of(const Vec3& x) const;
  /// Indices into cells(), ascending, of the cells in and around a slot that hold spheres; each
  /// once even where the box is only two cells wide.
  std::span<const std::int32_t> around(std::int32_t slot) const;

 private:
  void lay_out(const Box& box, double reach);
  void sort_into_cells();
  void link_adjacent_cells();
  int slots_along(int direction, std::int32_t at, std::int32_t (&found)[3]) const;

  bool periodic_[3];
  Vec3 origin_;
  Vec3 inv_width_;
  std::int32_t count_[3];
  std::vector<LocatedSphere> spheres_;
  std::vector<Cell> cells_;
  std::vector<std::int32_t> around_first_;  // rows of around_, one a slot
  std::vector<std::int32_t> around_;
};

}  // namespace repose::dem

// Verlet lists of pairs and of walls, built now and then, with the contacts they carry.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/contact_pool.hpp"
#include "geometry/box.hpp"
#include "geometry/wall_surface.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// A sphere (or wall) that may come to touch, and their contact if they do.
struct Neighbor {
  std::int32_t other;    ///< index of a sphere, greater than that of the row; or of a wall
  std::int32_t contact;  ///< in the pool, kNoContact while they do not touch
};

/// Compressed rows: neighbors of sphere i are entries[first[i]] to entries[first[i + 1] - 1].
struct NeighborList {
  std::vector<std::int32_t> first;
  std::vector<Neighbor> entries;
};

/// Both lists of a simulation. They hold every pair and every wall that can come to touch before a
/// sphere has moved by skin/2.
struct NeighborLists {
  NeighborList pairs;
  NeighborList walls;
};

/// Sorts the spheres by (cell, id), builds both lists anew and takes the contacts with their
/// history from the old ones. Pairs (i, j) are listed by ascending i, then j: the order of every
/// sum.
void rebuild(const Box& box, double skin, const std::vector<WallSurface>& walls, Spheres& spheres,
             NeighborLists& lists, ContactPool& pool);

}  // namespace repose::dem

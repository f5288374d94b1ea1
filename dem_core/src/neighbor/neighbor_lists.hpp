// Verlet lists of pairs and of walls, built now and then, with the contacts they carry.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "contact/contact_pool.hpp"
#include "contact/wall_contacts.hpp"
#include "geometry/box.hpp"
#include "geometry/walls.hpp"
#include "particles/clumps.hpp"

namespace repose::dem {

/// A sphere that may come to touch, and the contact if it does.
struct Neighbor {
  std::int32_t row;      ///< index of the sphere whose neighbor it is
  std::int32_t other;    ///< index of a sphere, greater than that of the row
  std::int32_t contact;  ///< in the pool, kNoContact while they do not touch
};

/// Compressed rows: neighbors of sphere i are entries[first[i]] to entries[first[i + 1] - 1].
struct NeighborList {
  std::vector<std::int32_t> first;
  std::vector<Neighbor> entries;
};

/// Compressed rows of the facets that a sphere may come to touch, with their gaps when listed.
struct WallList {
  std::vector<std::int32_t> first;
  std::vector<NearFacet> facets;

  std::span<const NearFacet> row(std::size_t i) const {
    return {facets.data() + first[i], static_cast<std::size_t>(first[i + 1] - first[i])};
  }
};

/// Both lists of a simulation. They hold every pair that can come to touch before a sphere has
/// moved by skin/2, and every facet before a sphere and its wall together have moved by the skin.
struct NeighborLists {
  NeighborList pairs;
  WallList walls;
};

/// The entry of row i for `other`, which must be there: what touches is within reach.
Neighbor& entry(NeighborList& list, std::int32_t i, std::int32_t other);

/// Brings spheres into the order of order_of(); returns the new index of each.
std::vector<std::int32_t> sort_spheres(Spheres& spheres, Clumps& clumps,
                                       WallContacts& wall_contacts);

/// Builds both lists anew and takes the contacts with their history from the old ones; new_index of
/// the spheres then, -1 for those that are gone, is empty if nothing changed. Pairs (i, j) are
/// listed by ascending i, then j: the order of every sum. Spheres of one body are no pair, nor are
/// two ghosts; ghosts meet no walls.
void rebuild(const Box& box, double skin, const Walls& walls,
             const std::vector<std::int32_t>& new_index, Spheres& spheres, NeighborLists& lists,
             ContactPool& pool);

/// Takes spheres that are to leave out of the lists and ends their contacts; new_index is their
/// future index, or -1. The spheres themselves are selected by the caller afterwards.
void remove_spheres(const std::vector<std::int32_t>& new_index, NeighborLists& lists,
                    ContactPool& pool, const Spheres& spheres, WallContacts& wall_contacts);

}  // namespace repose::dem

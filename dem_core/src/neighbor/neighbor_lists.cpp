#include "neighbor/neighbor_lists.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "neighbor/cell_grid.hpp"
#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// The order of the spheres by (cell, id): order[new index] = old index.
std::vector<std::int32_t> sphere_order(const CellGrid& grid, const Spheres& spheres) {
  std::vector<std::pair<std::uint64_t, std::pair<std::int32_t, std::int32_t>>> sorted;
  sorted.reserve(spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i)
    sorted.push_back({grid.keys()[i], {spheres.id[i], static_cast<std::int32_t>(i)}});
  if (!std::is_sorted(sorted.begin(), sorted.end())) std::sort(sorted.begin(), sorted.end());
  std::vector<std::int32_t> order;
  order.reserve(sorted.size());
  for (const auto& entry : sorted) order.push_back(entry.second.second);
  return order;
}

double largest_radius(const Spheres& spheres) {
  double largest = 0.0;
  for (const Motion& sphere : spheres.motion) largest = std::max(largest, sphere.radius);
  return largest;
}

/// Pairs of different bodies closer than R_i + R_j + skin, by ascending (i, j).
template <int kMask>
NeighborList find_pairs(const Box& box, double skin, const CellGrid& grid, const Spheres& spheres,
                        std::size_t expected) {
  const std::vector<Motion>& motion = spheres.motion;
  NeighborList list;
  list.first.reserve(motion.size() + 1);
  list.entries.reserve(expected);
  std::vector<std::int32_t> neighbors;
  const auto add_range = [&](std::int32_t i, std::int32_t first, std::int32_t last) {
    const Motion& a = motion[index(i)];
    for (std::int32_t j = first; j < last; ++j) {
      const Motion& b = motion[index(j)];
      const Vec3 d = box.nearest_image_in<kMask>(b.x - a.x);
      const double reach = a.radius + b.radius + skin;
      if (d.squaredNorm() < reach * reach && spheres.body[index(i)] != spheres.body[index(j)])
        list.entries.push_back({j, kNoContact});
    }
  };
  for (std::size_t c = 0; c < grid.cells().size(); ++c) {
    const CellGrid::Cell& cell = grid.cells()[c];
    grid.following_neighbors(c, neighbors);
    for (std::int32_t i = cell.first; i < cell.last; ++i) {
      list.first.push_back(static_cast<std::int32_t>(list.entries.size()));
      add_range(i, i + 1, cell.last);
      for (std::int32_t n : neighbors)
        add_range(i, grid.cells()[index(n)].first, grid.cells()[index(n)].last);
    }
  }
  list.first.push_back(static_cast<std::int32_t>(list.entries.size()));
  return list;
}

/// Facets that a sphere can reach by moving less than the skin.
WallList find_walls(const Walls& walls, double skin, const std::vector<Motion>& motion,
                    std::size_t expected) {
  WallList list;
  list.first.reserve(motion.size() + 1);
  list.facets.reserve(expected);
  for (const Motion& sphere : motion) {
    list.first.push_back(static_cast<std::int32_t>(list.facets.size()));
    walls.add_near(sphere.x, sphere.radius, skin, list.facets);
  }
  list.first.push_back(static_cast<std::int32_t>(list.facets.size()));
  return list;
}

/// The entry of row i for `other`; it must be there, for what touches is within reach.
Neighbor& entry(NeighborList& list, std::int32_t i, std::int32_t other) {
  for (std::int32_t p = list.first[index(i)]; p < list.first[index(i) + 1]; ++p)
    if (list.entries[index(p)].other == other) return list.entries[index(p)];
  assertion_failed("touching neighbors stay listed", __FILE__, __LINE__,
                   "sphere " + std::to_string(i) + ", neighbor " + std::to_string(other));
}

/// Gives the pairs of the new list the slots that they had in the old one. A pair whose
/// order changed keeps its slot with the history of the other side.
void carry_pairs(const NeighborList& old, const std::vector<std::int32_t>& new_index,
                 NeighborList& list, ContactPool& pool) {
  for (std::size_t i = 0; i + 1 < old.first.size(); ++i)
    for (std::int32_t p = old.first[i]; p < old.first[i + 1]; ++p) {
      const Neighbor& neighbor = old.entries[index(p)];
      if (neighbor.contact == kNoContact) continue;
      std::int32_t a = new_index[i];
      std::int32_t b = new_index[index(neighbor.other)];
      if (a > b) {
        std::swap(a, b);
        ContactHistory& history = pool.at(neighbor.contact).history;
        history.slip = -history.slip;
        history.rolling = -history.rolling;
      }
      entry(list, a, b).contact = neighbor.contact;
    }
}

/// Numbers the contacts in the order in which the lists meet them.
void renumber(NeighborList& list, const ContactPool& old, ContactPool& pool) {
  for (Neighbor& neighbor : list.entries)
    if (neighbor.contact != kNoContact) neighbor.contact = pool.append(old.at(neighbor.contact));
}

}  // namespace

void rebuild(const Box& box, double skin, const Walls& walls, Spheres& spheres, Clumps& clumps,
             NeighborLists& lists, ContactPool& pool, WallContacts& wall_contacts) {
  CellGrid grid(box, spheres.motion, 2.0 * largest_radius(spheres) + skin);
  const std::vector<std::int32_t> order = sphere_order(grid, spheres);
  spheres.select(order);
  follow_order(spheres, clumps);
  std::vector<std::uint64_t> sorted_keys;
  sorted_keys.reserve(order.size());
  for (std::int32_t old : order) sorted_keys.push_back(grid.keys()[index(old)]);
  grid.set_cells(sorted_keys);

  NeighborLists built;
  built.pairs = with_periodic_mask(box, [&]<int kMask>() {
    return find_pairs<kMask>(box, skin, grid, spheres, lists.pairs.entries.size() + 64);
  });
  built.walls = find_walls(walls, skin, spheres.motion, lists.walls.facets.size() + 64);
  std::vector<std::int32_t> new_index(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    new_index[index(order[i])] = static_cast<std::int32_t>(i);
  carry_pairs(lists.pairs, new_index, built.pairs, pool);
  wall_contacts.follow_order(new_index);
  ContactPool renumbered = pool.emptied();
  renumber(built.pairs, pool, renumbered);
  pool = std::move(renumbered);
  lists = std::move(built);

  spheres.x_listed.resize(spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i) spheres.x_listed[i] = spheres.motion[i].x;
}

void remove_spheres(const std::vector<std::int32_t>& new_index, NeighborLists& lists,
                    ContactPool& pool, WallContacts& wall_contacts) {
  NeighborLists kept;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    const bool stays = new_index[i] >= 0;
    if (stays) {
      kept.pairs.first.push_back(static_cast<std::int32_t>(kept.pairs.entries.size()));
      kept.walls.first.push_back(static_cast<std::int32_t>(kept.walls.facets.size()));
      const auto row = lists.walls.row(i);
      kept.walls.facets.insert(kept.walls.facets.end(), row.begin(), row.end());
    }
    for (std::int32_t p = lists.pairs.first[i]; p < lists.pairs.first[i + 1]; ++p) {
      Neighbor neighbor = lists.pairs.entries[index(p)];
      neighbor.other = new_index[index(neighbor.other)];
      if (stays && neighbor.other >= 0)
        kept.pairs.entries.push_back(neighbor);
      else if (neighbor.contact != kNoContact)
        pool.end_contact(neighbor.contact);
    }
  }
  kept.pairs.first.push_back(static_cast<std::int32_t>(kept.pairs.entries.size()));
  kept.walls.first.push_back(static_cast<std::int32_t>(kept.walls.facets.size()));
  lists = std::move(kept);
  wall_contacts.follow_order(new_index);
}

}  // namespace repose::dem

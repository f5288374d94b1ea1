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

template <class T>
void reorder(const std::vector<std::int32_t>& order, std::vector<T>& values) {
  std::vector<T> sorted;
  sorted.reserve(values.size());
  for (std::int32_t old : order) sorted.push_back(values[index(old)]);
  values.swap(sorted);
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

void apply_order(const std::vector<std::int32_t>& order, Spheres& spheres) {
  reorder(order, spheres.motion);
  reorder(order, spheres.spin);
  reorder(order, spheres.load);
  reorder(order, spheres.material);
  reorder(order, spheres.id);
  reorder(order, spheres.mass);
}

double largest_radius(const Spheres& spheres) {
  double largest = 0.0;
  for (const Motion& sphere : spheres.motion) largest = std::max(largest, sphere.radius);
  return largest;
}

/// Pairs closer than R_i + R_j + skin, by ascending (i, j).
template <int kMask>
NeighborList find_pairs(const Box& box, double skin, const CellGrid& grid,
                        const std::vector<Motion>& motion, std::size_t expected) {
  NeighborList list;
  list.first.reserve(motion.size() + 1);
  list.entries.reserve(expected);
  std::vector<std::int32_t> neighbors;
  const auto add_range = [&](const Motion& a, std::int32_t first, std::int32_t last) {
    for (std::int32_t j = first; j < last; ++j) {
      const Motion& b = motion[index(j)];
      const Vec3 d = box.nearest_image_in<kMask>(b.x - a.x);
      const double reach = a.radius + b.radius + skin;
      if (d.squaredNorm() < reach * reach) list.entries.push_back({j, kNoContact});
    }
  };
  for (std::size_t c = 0; c < grid.cells().size(); ++c) {
    const CellGrid::Cell& cell = grid.cells()[c];
    grid.following_neighbors(c, neighbors);
    for (std::int32_t i = cell.first; i < cell.last; ++i) {
      list.first.push_back(static_cast<std::int32_t>(list.entries.size()));
      const Motion& sphere = motion[index(i)];
      add_range(sphere, i + 1, cell.last);
      for (std::int32_t n : neighbors)
        add_range(sphere, grid.cells()[index(n)].first, grid.cells()[index(n)].last);
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
    walls.add_near(sphere.x, sphere.radius + skin, list.facets);
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

void rebuild(const Box& box, double skin, const Walls& walls, Spheres& spheres,
             NeighborLists& lists, ContactPool& pool, WallContacts& wall_contacts) {
  CellGrid grid(box, spheres.motion, 2.0 * largest_radius(spheres) + skin);
  const std::vector<std::int32_t> order = sphere_order(grid, spheres);
  apply_order(order, spheres);
  std::vector<std::uint64_t> sorted_keys = grid.keys();
  reorder(order, sorted_keys);
  grid.set_cells(sorted_keys);

  NeighborLists built;
  built.pairs = with_periodic_mask(box, [&]<int kMask>() {
    return find_pairs<kMask>(box, skin, grid, spheres.motion, lists.pairs.entries.size() + 64);
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

}  // namespace repose::dem

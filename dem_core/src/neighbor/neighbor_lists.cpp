#include "neighbor/neighbor_lists.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "neighbor/pair_search.hpp"
#include "neighbor/sphere_order.hpp"
#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// Where a sphere may come back in if it leaves through a periodic side before the next search.
std::vector<Vec3> reentries(const Box& box, double skin, const Vec3& x) {
  std::vector<Vec3> images;
  for (int k = 0; k < 3; ++k) {
    if (!box.periodic[k]) continue;
    const double way = x[k] < box.lower[k] + skin   ? box.length[k]
                       : x[k] > box.upper[k] - skin ? -box.length[k]
                                                    : 0.0;
    if (way == 0.0) continue;
    const std::size_t before = images.size();
    images.push_back(x);
    for (std::size_t n = 0; n < before; ++n) images.push_back(Vec3(images[n]));
    for (std::size_t n = before; n < images.size(); ++n) images[n][k] += way;
  }
  return images;
}

/// Facets that a sphere can reach by moving less than the skin, each once with its least gap.
WallList find_walls(const Box& box, const Walls& walls, double skin, const Spheres& spheres,
                    std::size_t expected) {
  WallList list;
  list.first.reserve(spheres.size() + 1);
  list.facets.reserve(expected);
  std::vector<NearFacet> beyond;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Motion& sphere = spheres.motion[i];
    const std::size_t row = list.facets.size();
    list.first.push_back(static_cast<std::int32_t>(row));
    if (spheres.is_ghost(i)) continue;
    walls.add_near(sphere.x, sphere.radius, skin, list.facets);
    if (box.periodic_mask() == 0) continue;
    for (const Vec3& x : reentries(box, skin, sphere.x)) {
      beyond.clear();
      walls.add_near(x, sphere.radius, skin, beyond);
      for (const NearFacet& facet : beyond) {
        const auto known =
            std::find_if(list.facets.begin() + static_cast<std::ptrdiff_t>(row), list.facets.end(),
                         [&facet](const NearFacet& other) { return other.facet == facet.facet; });
        if (known == list.facets.end())
          list.facets.push_back(facet);
        else
          known->gap = std::min(known->gap, facet.gap);
      }
    }
  }
  list.first.push_back(static_cast<std::int32_t>(list.facets.size()));
  return list;
}

/// Gives the pairs of the new list the slots that they had in the old one. A pair whose
/// order changed keeps its slot with the history of the other side; one that is another process'
/// matter now is left out.
void carry_pairs(const NeighborList& old, const std::vector<std::int32_t>& new_index,
                 const Spheres& spheres, NeighborList& list, ContactPool& pool) {
  for (const Neighbor& neighbor : old.entries) {
    if (neighbor.contact == kNoContact) continue;
    std::int32_t a = new_index[index(neighbor.row)];
    std::int32_t b = new_index[index(neighbor.other)];
    if (a < 0 || b < 0 || (spheres.is_ghost(index(a)) && spheres.is_ghost(index(b)))) continue;
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
void renumber(NeighborList& list, ContactPool& pool) {
  ContactPool renumbered = pool.emptied();
  for (Neighbor& neighbor : list.entries)
    if (neighbor.contact != kNoContact)
      neighbor.contact = renumbered.append(pool.at(neighbor.contact));
  pool = std::move(renumbered);
}

}  // namespace

Neighbor& entry(NeighborList& list, std::int32_t i, std::int32_t other) {
  for (std::int32_t p = list.first[index(i)]; p < list.first[index(i) + 1]; ++p)
    if (list.entries[index(p)].other == other) return list.entries[index(p)];
  assertion_failed("touching neighbors stay listed", __FILE__, __LINE__,
                   "sphere " + std::to_string(i) + ", neighbor " + std::to_string(other));
}

std::vector<std::int32_t> sort_spheres(Spheres& spheres, Clumps& clumps,
                                       WallContacts& wall_contacts) {
  const std::vector<std::int32_t> order = order_of(spheres);
  std::vector<std::int32_t> new_index(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    new_index[index(order[i])] = static_cast<std::int32_t>(i);
  spheres.select(order);
  follow_order(spheres, clumps);
  wall_contacts.follow_order(new_index);
  return new_index;
}

void rebuild(const Box& box, double skin, const Walls& walls,
             const std::vector<std::int32_t>& new_index, Spheres& spheres, NeighborLists& lists,
             ContactPool& pool) {
  NeighborLists built;
  built.pairs = find_pairs(box, skin, spheres);
  built.walls = find_walls(box, walls, skin, spheres, lists.walls.facets.size() + 64);
  if (new_index.empty()) {
    std::vector<std::int32_t> same(spheres.size());
    std::iota(same.begin(), same.end(), 0);
    carry_pairs(lists.pairs, same, spheres, built.pairs, pool);
  } else {
    carry_pairs(lists.pairs, new_index, spheres, built.pairs, pool);
    renumber(built.pairs, pool);
  }
  lists = std::move(built);

  spheres.x_listed.resize(spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i) spheres.x_listed[i] = spheres.motion[i].x;
}

void remove_spheres(const std::vector<std::int32_t>& new_index, NeighborLists& lists,
                    ContactPool& pool, const Spheres& spheres, WallContacts& wall_contacts) {
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
      neighbor.row = new_index[i];
      neighbor.other = new_index[index(neighbor.other)];
      if (stays && neighbor.other >= 0) {
        kept.pairs.entries.push_back(neighbor);
      } else if (neighbor.contact != kNoContact) {
        if (!spheres.is_ghost(i)) pool.count_released(neighbor.contact);
        pool.end_contact(neighbor.contact);
      }
    }
  }
  kept.pairs.first.push_back(static_cast<std::int32_t>(kept.pairs.entries.size()));
  kept.walls.first.push_back(static_cast<std::int32_t>(kept.walls.facets.size()));
  lists = std::move(kept);
  wall_contacts.follow_order(new_index);
}

}  // namespace repose::dem

#include "neighbor/pair_search.hpp"

#include <algorithm>
#include <cmath>

#include "neighbor/level_grid.hpp"

namespace repose::dem {
namespace {

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// Found pairs in any order; the rows of the list are made of them in the end.
class FoundPairs {
 public:
  FoundPairs(std::size_t spheres, std::size_t expected) : first_(spheres + 1, 0) {
    pairs_.reserve(expected);
  }

  void add(std::int32_t a, std::int32_t b) {
    const auto [i, j] = std::minmax(a, b);
    pairs_.push_back({i, j});
    ++first_[index(i) + 1];
  }

  NeighborList rows() && {
    NeighborList list;
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    list.entries.resize(pairs_.size());
    std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
    for (const Pair& pair : pairs_)
      list.entries[index(next[index(pair.i)]++)] = {pair.i, pair.j, kNoContact};
    for (std::size_t i = 0; i + 1 < first_.size(); ++i)
      std::sort(list.entries.begin() + first_[i], list.entries.begin() + first_[i + 1],
                [](const Neighbor& a, const Neighbor& b) { return a.other < b.other; });
    list.first = std::move(first_);
    return list;
  }

 private:
  struct Pair {
    std::int32_t i, j;
  };
  std::vector<Pair> pairs_;
  std::vector<std::int32_t> first_;
};

/// The spheres [first, last) of a level that are close to `a`.
template <int kMask>
void add_close(const Box& box, double skin, const LocatedSphere& a,
               const std::vector<LocatedSphere>& level, std::int32_t first, std::int32_t last,
               FoundPairs& found) {
  for (std::int32_t k = first; k < last; ++k) {
    const LocatedSphere& b = level[index(k)];
    const Vec3 d = box.nearest_image_in<kMask>(b.x - a.x);
    const double reach = a.radius + b.radius + skin;
    if (d.squaredNorm() < reach * reach && a.body != b.body && !(a.is_ghost && b.is_ghost))
      found.add(a.index, b.index);
  }
}

template <int kMask>
void add_within_level(const Box& box, double skin, const LevelGrid& grid, FoundPairs& found) {
  for (std::size_t c = 0; c < grid.cells().size(); ++c) {
    const LevelGrid::Cell& cell = grid.cells()[c];
    const auto adjacent = grid.around(cell.slot);
    for (std::int32_t i = cell.first; i < cell.last; ++i) {
      const LocatedSphere& sphere = grid.spheres()[index(i)];
      add_close<kMask>(box, skin, sphere, grid.spheres(), i + 1, cell.last, found);
      for (std::int32_t other : adjacent)
        if (index(other) > c)
          add_close<kMask>(box, skin, sphere, grid.spheres(), grid.cells()[index(other)].first,
                           grid.cells()[index(other)].last, found);
    }
  }
}

template <int kMask>
void add_between_levels(const Box& box, double skin, const LevelGrid& fine, const LevelGrid& coarse,
                        FoundPairs& found) {
  for (const LocatedSphere& sphere : fine.spheres()) {
    const std::int32_t slot = coarse.slot_of(sphere.x);
    if (slot < 0) continue;
    for (std::int32_t c : coarse.around(slot))
      add_close<kMask>(box, skin, sphere, coarse.spheres(), coarse.cells()[index(c)].first,
                       coarse.cells()[index(c)].last, found);
  }
}

/// Levels that hold spheres, from coarse to fine.
std::vector<LevelGrid> levels_of(const Box& box, double skin, const Spheres& spheres) {
  double largest = 0.0;
  for (const Motion& sphere : spheres.motion) largest = std::max(largest, sphere.radius);
  std::vector<std::vector<LocatedSphere>> members;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Motion& sphere = spheres.motion[i];
    const auto level = static_cast<std::size_t>(std::max(0, std::ilogb(largest / sphere.radius)));
    if (level >= members.size()) members.resize(level + 1);
    members[level].push_back({sphere.x, sphere.radius, static_cast<std::int32_t>(i),
                              spheres.body[i], spheres.is_ghost(i)});
  }
  std::vector<LevelGrid> levels;
  for (std::vector<LocatedSphere>& level : members) {
    double radius = 0.0;
    for (const LocatedSphere& sphere : level) radius = std::max(radius, sphere.radius);
    if (!level.empty()) levels.emplace_back(box, std::move(level), 2.0 * radius + skin);
  }
  return levels;
}

}  // namespace

NeighborList find_pairs(const Box& box, double skin, const Spheres& spheres) {
  const std::vector<LevelGrid> levels = levels_of(box, skin, spheres);
  FoundPairs found(spheres.size(), 8 * spheres.size());
  with_periodic_mask(box, [&]<int kMask>() {
    for (std::size_t fine = 0; fine < levels.size(); ++fine) {
      add_within_level<kMask>(box, skin, levels[fine], found);
      for (std::size_t coarse = 0; coarse < fine; ++coarse)
        add_between_levels<kMask>(box, skin, levels[fine], levels[coarse], found);
    }
  });
  return std::move(found).rows();
}

}  // namespace repose::dem

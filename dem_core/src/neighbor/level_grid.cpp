#include "neighbor/level_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace repose::dem {
namespace {

/// Few enough cells for dense tables: their size is bounded by the number of spheres.
double most_cells(std::size_t spheres) {
  return 4096.0 + 16.0 * static_cast<double>(spheres);
}

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

LevelGrid::LevelGrid(const Box& box, std::vector<LocatedSphere> spheres, double reach)
    : spheres_(std::move(spheres)) {
  lay_out(box, reach);
  sort_into_cells();
  link_adjacent_cells();
}

void LevelGrid::lay_out(const Box& box, double reach) {
  Vec3 lower = box.upper;
  Vec3 upper = box.lower;
  for (const LocatedSphere& sphere : spheres_) {
    lower = lower.cwiseMin(sphere.x);
    upper = upper.cwiseMax(sphere.x);
  }
  for (int k = 0; k < 3; ++k) {
    periodic_[k] = box.periodic[k];
    if (!periodic_[k]) continue;
    lower[k] = box.lower[k];
    upper[k] = box.upper[k];
  }
  for (double width = reach;; width *= 2.0) {  // wider cells where spheres are far apart
    double total = 1.0;
    double count[3];
    for (int k = 0; k < 3; ++k) {
      const double fit = std::floor((upper[k] - lower[k]) / width);
      count[k] = periodic_[k] ? std::max(1.0, fit) : fit + 3.0;
      total *= count[k];
    }
    if (total > most_cells(spheres_.size())) continue;
    for (int k = 0; k < 3; ++k) {
      count_[k] = static_cast<std::int32_t>(count[k]);
      origin_[k] = periodic_[k] ? lower[k] : lower[k] - width;
      inv_width_[k] = periodic_[k] ? count[k] / (upper[k] - lower[k]) : 1.0 / width;
    }
    return;
  }
}

std::int32_t LevelGrid::slot_of(const Vec3& x) const {
  std::int32_t slot = 0;
  for (int k = 2; k >= 0; --k) {
    const double at = (x[k] - origin_[k]) * inv_width_[k];
    std::int32_t cell = 0;
    if (periodic_[k]) {
      cell = std::clamp(static_cast<std::int32_t>(at), 0, count_[k] - 1);
    } else {
      if (!(at >= 0.0 && at < count_[k])) return -1;
      cell = static_cast<std::int32_t>(at);
    }
    slot = slot * count_[k] + cell;
  }
  return slot;
}

/// Counting sort, which keeps the order within a cell.
void LevelGrid::sort_into_cells() {
  std::vector<std::int32_t> slots;
  slots.reserve(spheres_.size());
  std::vector<std::int32_t> first(
      static_cast<std::size_t>(count_[0]) * index(count_[1]) * index(count_[2]) + 1, 0);
  for (const LocatedSphere& sphere : spheres_) {
    slots.push_back(slot_of(sphere.x));
    ++first[index(slots.back()) + 1];
  }
  for (std::size_t s = 1; s < first.size(); ++s) {
    if (first[s] > 0)
      cells_.push_back({first[s - 1], first[s - 1] + first[s], static_cast<std::int32_t>(s - 1)});
    first[s] += first[s - 1];
  }
  std::vector<LocatedSphere> sorted(spheres_.size());
  for (std::size_t i = 0; i < spheres_.size(); ++i)
    sorted[index(first[index(slots[i])]++)] = spheres_[i];
  spheres_ = std::move(sorted);
}

/// Coordinates adjacent to `at` along a direction, each once; how many.
int LevelGrid::slots_along(int direction, std::int32_t at, std::int32_t (&found)[3]) const {
  const std::int32_t count = count_[direction];
  int n = 0;
  for (std::int32_t next = at - 1; next <= at + 1; ++next) {
    std::int32_t candidate = next;
    if (periodic_[direction]) candidate = (next + count) % count;
    if (candidate < 0 || candidate >= count) continue;
    bool seen = false;
    for (int m = 0; m < n; ++m) seen = seen || found[m] == candidate;
    if (!seen) found[n++] = candidate;
  }
  return n;
}

void LevelGrid::link_adjacent_cells() {
  const std::size_t slots =
      static_cast<std::size_t>(count_[0]) * index(count_[1]) * index(count_[2]);
  std::vector<std::pair<std::int32_t, std::int32_t>> links;  // slot, cell
  links.reserve(27 * cells_.size());
  around_first_.assign(slots + 1, 0);
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    std::int32_t rest = cells_[c].slot;
    std::int32_t adjacent[3][3];
    int n[3];
    for (int k = 0; k < 3; ++k) {
      n[k] = slots_along(k, rest % count_[k], adjacent[k]);
      rest /= count_[k];
    }
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x) {
          const std::int32_t slot =
              (adjacent[2][z] * count_[1] + adjacent[1][y]) * count_[0] + adjacent[0][x];
          links.emplace_back(slot, static_cast<std::int32_t>(c));
          ++around_first_[index(slot) + 1];
        }
  }
  for (std::size_t s = 0; s < slots; ++s) around_first_[s + 1] += around_first_[s];
  around_.resize(links.size());
  std::vector<std::int32_t> next(around_first_.begin(), around_first_.end() - 1);
  for (const auto& [slot, cell] : links) around_[index(next[index(slot)]++)] = cell;
}

std::span<const std::int32_t> LevelGrid::around(std::int32_t slot) const {
  const std::int32_t first = around_first_[index(slot)];
  return {around_.data() + first, index(around_first_[index(slot) + 1] - first)};
}

}  // namespace repose::dem

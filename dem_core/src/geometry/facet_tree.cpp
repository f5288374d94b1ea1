#include "geometry/facet_tree.hpp"

#include <algorithm>
#include <numeric>

namespace repose::dem {
namespace {

constexpr std::int32_t kFacetsOfALeaf = 4;

Bounds joined(const Bounds& a, const Bounds& b) {
  return {a.lower.cwiseMin(b.lower), a.upper.cwiseMax(b.upper)};
}

}  // namespace

FacetTree::FacetTree(const std::vector<Facet>& facets, std::int32_t first, std::int32_t last)
    : order_(static_cast<std::size_t>(last - first)) {
  std::iota(order_.begin(), order_.end(), first);
  std::vector<Bounds> boxes;
  boxes.reserve(order_.size());
  for (const std::int32_t i : order_)
    boxes.push_back(bounds_of(facets[static_cast<std::size_t>(i)]));
  nodes_.push_back({{}, 0, last - first, -1});
  for (std::size_t n = 0; n < nodes_.size(); ++n) split(n, boxes, first);
}

void FacetTree::split(std::size_t n, const std::vector<Bounds>& boxes, std::int32_t offset) {
  const std::int32_t first = nodes_[n].first;
  const std::int32_t last = nodes_[n].last;
  const auto box = [&](std::int32_t facet) -> const Bounds& {
    return boxes[static_cast<std::size_t>(facet - offset)];
  };
  const auto begin = order_.begin() + first;
  const auto end = order_.begin() + last;
  Bounds all = box(*begin);
  Bounds centres{all.lower + all.upper, all.lower + all.upper};  // doubled
  for (auto i = begin; i != end; ++i) {
    all = joined(all, box(*i));
    const Vec3 centre = box(*i).lower + box(*i).upper;
    centres = joined(centres, {centre, centre});
  }
  nodes_[n].box = all;
  if (last - first <= kFacetsOfALeaf) return;
  Eigen::Index axis = 0;
  (centres.upper - centres.lower).maxCoeff(&axis);
  const std::int32_t half = first + (last - first) / 2;
  std::nth_element(begin, order_.begin() + half, end, [&](std::int32_t a, std::int32_t b) {
    const double at_a = box(a).lower[axis] + box(a).upper[axis];
    const double at_b = box(b).lower[axis] + box(b).upper[axis];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  nodes_[n].left = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back({{}, first, half, -1});
  nodes_.push_back({{}, half, last, -1});
}

}  // namespace repose::dem

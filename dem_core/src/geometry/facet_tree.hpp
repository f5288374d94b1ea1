// A tree of boxes over the facets of a wall, for "which facets are near this point?".
#pragma once

#include <vector>

#include "geometry/facet.hpp"

namespace repose::dem {

/// Binary, halved along the longest side of the centres' box, four facets a leaf; built once, in
/// the frame of the wall, so that motion does not touch it. Cost of a query log n plus what it
/// finds.
class FacetTree {
 public:
  /// Over facets[first] to facets[last - 1], last > first.
  FacetTree(const std::vector<Facet>& facets, std::int32_t first, std::int32_t last);

  /// Of all facets together.
  const Bounds& bounds() const { return nodes_.front().box; }

  /// Calls visit(i) for each facet i whose box is closer to x than `reach`.
  template <class Visit>
  void visit_near(const Vec3& x, double reach, const Visit& visit) const {
    const double reach2 = reach * reach;
    std::int32_t open[64];  // a balanced tree of 2^31 facets is 31 deep
    int count = 0;
    open[count++] = 0;
    while (count > 0) {
      const Node& node = nodes_[static_cast<std::size_t>(open[--count])];
      if (node.box.distance2(x) >= reach2) continue;
      if (node.left < 0) {
        for (std::int32_t k = node.first; k < node.last; ++k)
          visit(order_[static_cast<std::size_t>(k)]);
        continue;
      }
      open[count++] = node.left + 1;
      open[count++] = node.left;
    }
  }

 private:
  struct Node {
    Bounds box;
    std::int32_t first, last;  // in order_
    std::int32_t left = -1;    // the right child follows it; -1 for a leaf
  };
  void split(std::size_t node, const std::vector<Bounds>& boxes, std::int32_t offset);

  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;
};

}  // namespace repose::dem

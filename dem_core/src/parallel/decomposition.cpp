#include "parallel/decomposition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace repose::dem {
namespace {

constexpr std::size_t kBins = 256;  // of a histogram; two in turn fix a cut to 1/65536 of the side

std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Where along a side, from `begin` to `end`, the costs of the bodies of a node lie.
struct Window {
  int axis;
  double begin, end;
  std::int64_t below;  ///< cost of all before `begin`
  std::int64_t wanted;
};

std::size_t bin_of(const Window& window, double at) {
  const double bin = (at - window.begin) / (window.end - window.begin) * double(kBins);
  return static_cast<std::size_t>(std::clamp(bin, 0.0, double(kBins - 1)));
}

/// Narrows windows, one a node to be cut, down to the bin in which the wanted cost is reached.
void narrow(const std::vector<WeightedPoint>& mine, const std::vector<int>& slot_of,
            std::vector<Window>& windows, const Communicator& communicator) {
  std::vector<std::int64_t> costs(windows.size() * kBins, 0);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    if (slot_of[i] < 0) continue;
    const Window& window = windows[index(slot_of[i])];
    const double at = mine[i].x[window.axis];
    if (at < window.begin || at >= window.end) continue;
    costs[index(slot_of[i]) * kBins + bin_of(window, at)] += mine[i].cost;
  }
  communicator.add_up(costs);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    Window& window = windows[w];
    const double width = (window.end - window.begin) / double(kBins);
    std::size_t bin = 0;
    while (bin + 1 < kBins && window.below + costs[w * kBins + bin] < window.wanted)
      window.below += costs[w * kBins + bin++];
    window.end = window.begin + width * double(bin + 1);
    window.begin += width * double(bin);
  }
}

}  // namespace

Decomposition::Decomposition(const Box& box, const std::vector<WeightedPoint>& mine, int parts,
                             const Communicator& communicator) {
  Node root;
  root.ranks = parts;
  double extent[6];  // minus the lowest, the highest
  std::fill(extent, extent + 6, -std::numeric_limits<double>::infinity());
  for (const WeightedPoint& point : mine)
    for (int k = 0; k < 3; ++k) {
      extent[k] = std::max(extent[k], -point.x[k]);
      extent[3 + k] = std::max(extent[3 + k], point.x[k]);
    }
  communicator.maximize(extent);
  for (int k = 0; k < 3; ++k) {
    const bool is_empty = extent[k] > extent[3 + k] || !(extent[k] > -1e300);
    root.lower[k] = is_empty ? box.lower[k] : -extent[k];
    root.upper[k] = is_empty ? box.upper[k] : extent[3 + k];
    if (!(root.upper[k] > root.lower[k])) root.upper[k] = root.lower[k] + 1e-9 * box.upper.norm();
  }
  nodes_ = {root};
  std::vector<int> node_of(mine.size(), 0);
  std::vector<int> level;
  if (parts > 1) level.push_back(0);
  while (!level.empty()) level = cut_level(box, mine, level, node_of, communicator);
}

/// Cuts these nodes; returns those of the next level that are to be cut again.
std::vector<int> Decomposition::cut_level(const Box& box, const std::vector<WeightedPoint>& mine,
                                          const std::vector<int>& nodes, std::vector<int>& node_of,
                                          const Communicator& communicator) {
  std::vector<int> slot_of_node(nodes_.size(), -1);
  for (std::size_t s = 0; s < nodes.size(); ++s)
    slot_of_node[index(nodes[s])] = static_cast<int>(s);
  std::vector<int> slot_of(mine.size());
  std::vector<std::int64_t> total(nodes.size(), 0);
  for (std::size_t i = 0; i < mine.size(); ++i) {
    slot_of[i] = slot_of_node[index(node_of[i])];
    if (slot_of[i] >= 0) total[index(slot_of[i])] += mine[i].cost;
  }
  communicator.add_up(total);

  std::vector<Window> windows;
  for (std::size_t s = 0; s < nodes.size(); ++s) {
    const Node& node = nodes_[index(nodes[s])];
    const Vec3 side = node.upper - node.lower;
    int axis = 0;
    double fewest = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      // Halves of a whole period meet on both sides.
      const bool is_whole = box.periodic[k] && side[k] > 0.75 * box.length[k];
      const double area = side[(k + 1) % 3] * side[(k + 2) % 3] * (is_whole ? 2.0 : 1.0);
      if (area >= fewest) continue;
      fewest = area;
      axis = k;
    }
    const double part = double(node.ranks / 2) / double(node.ranks);
    const double beyond = 1e-9 * side[axis];  // so that the last body is inside
    windows.push_back({axis, node.lower[axis], node.upper[axis] + beyond, 0,
                       static_cast<std::int64_t>(part * double(total[s]) + 0.5)});
  }
  narrow(mine, slot_of, windows, communicator);
  narrow(mine, slot_of, windows, communicator);

  std::vector<int> next;
  for (std::size_t s = 0; s < nodes.size(); ++s) {
    Node below = nodes_[index(nodes[s])];
    Node above = below;
    const double cut = windows[s].end;
    below.upper[windows[s].axis] = above.lower[windows[s].axis] = cut;
    below.ranks /= 2;
    above.ranks -= below.ranks;
    above.first_rank += below.ranks;
    Node& node = nodes_[index(nodes[s])];
    node.axis = windows[s].axis;
    node.cut = cut;
    node.below = static_cast<int>(nodes_.size());
    node.above = node.below + 1;
    if (below.ranks > 1) next.push_back(node.below);
    if (above.ranks > 1) next.push_back(node.above);
    nodes_.push_back(below);  // `node` is no longer valid
    nodes_.push_back(above);
  }
  for (std::size_t i = 0; i < mine.size(); ++i) {
    const Node& node = nodes_[index(node_of[i])];
    if (node.axis >= 0) node_of[i] = mine[i].x[node.axis] < node.cut ? node.below : node.above;
  }
  return next;
}

int Decomposition::owner_of(const Vec3& x) const {
  const Node* node = nodes_.data();
  while (node->axis >= 0)
    node = nodes_.data() + (x[node->axis] < node->cut ? node->below : node->above);
  return node->first_rank;
}

void Decomposition::add_ranks_within(const Vec3& x, double distance,
                                     std::vector<int>& ranks) const {
  struct Reached {
    int node;
    Vec3 away;  // from the box of the node, along each direction
  };
  std::vector<Reached> open{{0, Vec3::Zero()}};
  while (!open.empty()) {
    const Reached reached = open.back();
    open.pop_back();
    const Node& node = nodes_[index(reached.node)];
    if (node.axis < 0) {
      ranks.push_back(node.first_rank);
      continue;
    }
    const double beyond = x[node.axis] - node.cut;
    for (const int side : {node.below, node.above}) {
      Reached next{side, reached.away};
      const bool is_other_side = (side == node.below) != (beyond < 0.0);
      if (is_other_side) next.away[node.axis] = std::max(next.away[node.axis], std::abs(beyond));
      if (next.away.squaredNorm() < distance * distance) open.push_back(next);
    }
  }
}

Decomposition::Part Decomposition::part_of(const Box& box, int rank) const {
  Part part{box.lower, box.upper};
  const Node* node = nodes_.data();
  while (node->axis >= 0) {
    const Node& below = nodes_[index(node->below)];
    if (rank < below.first_rank + below.ranks) {
      part.upper[node->axis] = node->cut;
      node = &below;
    } else {
      part.lower[node->axis] = node->cut;
      node = nodes_.data() + node->above;
    }
  }
  return part;
}

double imbalance(std::int64_t mine, const Communicator& communicator) {
  double most[1] = {static_cast<double>(mine)};
  communicator.maximize(most);
  std::int64_t sum[1] = {mine};
  communicator.add_up(sum);
  return sum[0] > 0 ? most[0] * communicator.size() / double(sum[0]) : 1.0;
}

}  // namespace repose::dem

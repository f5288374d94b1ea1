// Trees side by side in arrays, for prediction.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "repose/surrogate/input.hpp"

namespace repose::surrogate::trees {

/// Rows that walk through a tree side by side, so that none waits for the others' loads.
inline constexpr Eigen::Index kLanes = 8;

/// A row goes on to `left` if its value is below the threshold, else to left + 1; of a category, if
/// Forest::level_sets[threshold + level] is set. A leaf leads to itself: its input is 0, its
/// threshold infinite, so that rows can walk in step.
struct Node {
  static constexpr double kLeaf = std::numeric_limits<double>::infinity();
  double threshold = kLeaf;
  std::int32_t input = 0;
  std::int32_t left = 0;
  bool is_categorical = false;
  bool is_leaf() const { return threshold == kLeaf; }
};

struct TreeRange {
  std::int32_t root = 0;
  std::int32_t depth = 0;
};

/// Nodes of all trees one after another, children after their parents.
class Forest {
 public:
  Forest() = default;
  explicit Forest(const std::vector<Forest>& parts);
  std::size_t size() const { return thresholds.size(); }  ///< nodes
  Node node(std::size_t i) const {
    const bool categorical = links[i].values < 0;
    const std::int32_t values = categorical ? ~links[i].values : links[i].values;
    return {thresholds[i], values / static_cast<std::int32_t>(kLanes), links[i].left, categorical};
  }
  void set(std::size_t i, const Node& node) {
    const std::int32_t values = node.input * static_cast<std::int32_t>(kLanes);
    thresholds[i] = node.threshold;
    links[i] = {node.is_categorical ? ~values : values, node.left};
    has_categories = has_categories || node.is_categorical;
  }
  void resize(std::size_t nodes) {
    thresholds.resize(nodes, Node::kLeaf);
    links.resize(nodes);
  }

  /// As a walk needs them: two 8-byte numbers a node.
  struct Link {
    std::int32_t values = 0;  ///< kLanes * input, its first value in a block; ~ of it: a category
    std::int32_t left = 0;
  };
  std::vector<double> thresholds = {};
  std::vector<Link> links = {};
  std::vector<double> means = {};  ///< of the rows of each node
  std::vector<TreeRange> trees = {};
  std::vector<std::uint8_t> level_sets = {};
  bool has_categories = false;

  std::size_t end_of(std::size_t tree) const {
    return tree + 1 < trees.size() ? static_cast<std::size_t>(trees[tree + 1].root) : size();
  }
  /// The other's trees after these.
  void append(const Forest& other);
};

/// sum += weight * (mean of the leaf of each row), over the trees in order. x: m x d, checked.
void add_predictions(const Forest& forest, const Matrix& x, double weight, Vector& sum);

/// The mean of each row's leaf in each tree, trees x m; x checked.
Matrix predictions_of_trees(const Forest& forest, const Matrix& x);

/// Calls visit(tree, first row, leaves): the leaves, as node numbers, of as many consecutive rows.
/// All rows of a block for every tree in order before the next block; x checked.
template <class Visit>
void for_each_leaf(const Forest& forest, const Matrix& x, Visit visit);

/// Rows that pass all trees before the next ones do.
inline constexpr Eigen::Index kBlock = 128;

/// Rows of x as walks read them: kLanes rows after another, each value of all of them together;
/// what is missing of the last ones is 0.
void fill_block(const Matrix& x, Eigen::Index first, Eigen::Index rows, std::vector<double>& block);
/// Where a block has a value.
inline std::size_t in_block(Eigen::Index row, Eigen::Index input, Eigen::Index inputs) {
  return static_cast<std::size_t>(((row / kLanes) * inputs + input) * kLanes + row % kLanes);
}
/// The leaf of each of `rows` rows of a block in one tree; room for as many as kLanes divides.
void find_leaves(const Forest& forest, std::size_t tree, const std::vector<double>& block,
                 Eigen::Index rows, Eigen::Index inputs, std::vector<std::int32_t>& leaves);

template <class Visit>
void for_each_leaf(const Forest& forest, const Matrix& x, Visit visit) {
  std::vector<double> block;
  std::vector<std::int32_t> leaves;
  for (Eigen::Index first = 0; first < x.rows(); first += kBlock) {
    const Eigen::Index rows = std::min(kBlock, x.rows() - first);
    fill_block(x, first, rows, block);
    for (std::size_t t = 0; t < forest.trees.size(); ++t) {
      find_leaves(forest, t, block, rows, x.cols(), leaves);
      visit(t, first, std::span(leaves.data(), static_cast<std::size_t>(rows)));
    }
  }
}

}  // namespace repose::surrogate::trees

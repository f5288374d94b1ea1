// Trees side by side in arrays, for prediction.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "repose/surrogate/input.hpp"

namespace repose::surrogate::trees {

/// A row goes on to `left` if its value is below the threshold, else to left + 1; of a category, if
/// Forest::level_sets[threshold + level] is set. A leaf leads to itself: its input is 0, its
/// threshold infinite, so that many rows can walk in step.
struct Node {
  static constexpr double kLeaf = std::numeric_limits<double>::infinity();
  double threshold = kLeaf;
  std::int32_t input = 0;  ///< ~input of a category
  std::int32_t left = 0;
  bool is_leaf() const { return threshold == kLeaf; }
  bool is_categorical() const { return input < 0; }
  std::int32_t column() const { return input < 0 ? ~input : input; }
};

struct TreeRange {
  std::int32_t root = 0;
  std::int32_t depth = 0;
};

/// Nodes of all trees one after another, children after their parents.
struct Forest {
  std::vector<Node> nodes = {};
  std::vector<double> means = {};  ///< of the rows of each node
  std::vector<TreeRange> trees = {};
  std::vector<std::uint8_t> level_sets = {};
  bool has_categories = false;

  std::size_t end_of(std::size_t tree) const {
    return tree + 1 < trees.size() ? static_cast<std::size_t>(trees[tree + 1].root) : nodes.size();
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

/// Rows walked together.
inline constexpr Eigen::Index kBlock = 128;

/// Rows of a block of x one after another, as a walk reads them.
void transpose_block(const Matrix& x, Eigen::Index first, Eigen::Index rows,
                     std::vector<double>& block);
/// The leaf of each of `rows` rows of a block in one tree.
void find_leaves(const Forest& forest, std::size_t tree, const double* block, Eigen::Index rows,
                 Eigen::Index inputs, std::int32_t* leaves);

template <class Visit>
void for_each_leaf(const Forest& forest, const Matrix& x, Visit visit) {
  std::vector<double> block;
  std::vector<std::int32_t> leaves(static_cast<std::size_t>(kBlock));
  for (Eigen::Index first = 0; first < x.rows(); first += kBlock) {
    const Eigen::Index rows = std::min(kBlock, x.rows() - first);
    transpose_block(x, first, rows, block);
    for (std::size_t t = 0; t < forest.trees.size(); ++t) {
      find_leaves(forest, t, block.data(), rows, x.cols(), leaves.data());
      visit(t, first, std::span(leaves.data(), static_cast<std::size_t>(rows)));
    }
  }
}

}  // namespace repose::surrogate::trees

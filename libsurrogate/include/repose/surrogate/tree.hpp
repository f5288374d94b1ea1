// Regression trees: boxes of the inputs with a constant response each, found by halving the rows
// where that explains most.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// How far a tree is grown: layer by layer, each node split where the sum of squares about the
/// means of its parts falls most [Breiman1984].
struct TreeOptions {
  /// Rows in each leaf, at least; those drawn repeatedly into a bag count as often. >= 1.
  Eigen::Index minimum_leaf = 5;
  /// A layer that would exceed them keeps those of its splits that explain most, and is the last
  /// one, as in MATLAB's MaxNumSplits. >= 1. Default: no limit.
  std::optional<Eigen::Index> maximum_splits = std::nullopt;
  std::optional<Eigen::Index> maximum_depth = std::nullopt;  ///< splits above a leaf; >= 1
  /// Drawn anew for each split, 1 to d; where none of them can divide the rows, further ones.
  /// Default: all.
  std::optional<Eigen::Index> predictors = std::nullopt;
};

/// A node as a reader of the tree wants it.
struct TreeNode {
  Eigen::Index input = -1;  ///< -1: a leaf
  /// A number goes left if it is below: halfway, on the input's scale, between two values of rows.
  double threshold = 0.0;
  /// Of a category: whether each level goes left. Levels of which the node had no rows go where
  /// more weight does.
  std::vector<bool> left_levels = {};
  Eigen::Index left = -1;  ///< node number, its sibling's is next
  double mean = 0.0;       ///< of the node's rows: what a leaf predicts
};

namespace trees {
class Forest;
}

/// One tree; never unfitted. Satisfies RegressorLike.
class RegressionTree {
 public:
  /// `seed` matters where predictors are drawn. Among splits that explain the same to rounding the
  /// first input and the lowest threshold win. A category is divided along the order of its levels'
  /// means, which is the best division in two where the minimum leaf allows it [Fisher1958]. Throws
  /// InputError as check() and on options out of range. O(d n log n) once, O(d n) a layer.
  static RegressionTree fit(const TrainingSet& data, const TreeOptions& options = {},
                            std::uint64_t seed = 1);

  Vector predict(const Matrix& x) const;
  const std::vector<Input>& inputs() const;
  std::string describe() const;

  const TreeOptions& options() const;
  std::vector<TreeNode> nodes() const;  ///< root first
  Eigen::Index leaves() const;
  Eigen::Index depth() const;

 private:
  struct State;
  explicit RegressionTree(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  friend struct TreeAccess;  // reads and rebuilds the state for model files
  std::shared_ptr<const State> state_;
};

Trainer tree_trainer(std::string name, const TreeOptions& options = {});

}  // namespace repose::surrogate

// Bagged regression trees: the mean of trees grown on resampled rows, with what rows left out of
// each bag say about its error.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "repose/surrogate/permutation_importance.hpp"
#include "repose/surrogate/tree.hpp"

namespace repose::surrogate {

struct BaggedTreesOptions {
  Eigen::Index trees = 100;  ///< >= 1
  /// Large trees of all predictors as in [Breiman1996] predict smooth functions of few rows best;
  /// docs/methods/trees.md has figures. Random forests [Breiman2001] draw predictors.
  TreeOptions tree = {.minimum_leaf = 1};
  std::uint64_t seed = 1;
  unsigned threads = 1;  ///< over trees; the result does not depend on it (0: one each core)
};

/// Each row by the trees whose bag it is not in.
struct OutOfBag {
  Vector predicted;       ///< NaN for rows that are in every bag
  Eigen::Index rows = 0;  ///< that are not; figures of these:
  double rmse = 0.0;
  double q2 = 0.0;  ///< 1 - sum residual^2 / sum (y - mean y)^2
};

/// Never unfitted. Satisfies RegressorLike and HasVariances.
class BaggedTrees {
 public:
  /// Each bag has as many points as the data, drawn with replacement: rows with all that repeat
  /// them, see points_of(). Weights count in the trees and in errors, not in bags. Throws
  /// InputError as RegressionTree::fit and for no trees.
  static BaggedTrees fit(const TrainingSet& data, const BaggedTreesOptions& options = {});

  Vector predict(const Matrix& x) const;
  /// Of the function: how the bag would vary over data sets, by the infinitesimal jackknife with
  /// its bias corrected, at least 0 [Wager2014, Eqs. 5, 7], and how it varies for having finitely
  /// many trees. Noisy with few trees: take several times as many as points. None with one tree.
  /// Of an observation: the mean square of out-of-bag errors, over rows that share leaves with x
  /// while out of bag, each as often as it does [Lu2021]; what the model misses is in it. None
  /// where no row is ever out of bag. O(trees points) a row.
  Predictions predict_with_variances(const Matrix& x) const;

  const std::vector<Input>& inputs() const;
  std::string describe() const;
  const BaggedTreesOptions& options() const;
  const OutOfBag& out_of_bag() const;
  Eigen::Index points() const;  ///< that were drawn from

  /// By how much the error of each tree at the rows out of its bag grows when an input's values are
  /// exchanged among them [Breiman2001]; mean and standard error over trees. `data` as in fit().
  std::vector<Importance> importance(const TrainingSet& data, std::uint64_t seed = 1) const;

 private:
  struct State;
  explicit BaggedTrees(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  friend struct TreeAccess;
  std::shared_ptr<const State> state_;
};

Trainer bagged_trees_trainer(std::string name, const BaggedTreesOptions& options = {});

}  // namespace repose::surrogate

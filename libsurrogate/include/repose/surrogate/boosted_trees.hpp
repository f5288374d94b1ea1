// Least-squares boosting: trees that each explain a part of what those before left over.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "repose/surrogate/tree.hpp"

namespace repose::surrogate {

/// How many of the trees are kept.
enum class Stopping {
  none,      ///< all
  held_out,  ///< as many as predict the rows of one fold best ...
  k_fold     ///< ... or all rows, each by the folds it is not in; then all rows are fitted
};
const char* to_string(Stopping stopping);

struct BoostedTreesOptions {
  Eigen::Index trees = 100;    ///< >= 1; at most that many where stopped early
  double learning_rate = 0.1;  ///< eta of Eq. 4.5 in [Hadi2026], in (0, 1]
  TreeOptions tree = {.maximum_splits = 10};
  Stopping stopping = Stopping::none;
  Eigen::Index folds = 5;  ///< >= 2, at most as many as points; see points_of()
  std::uint64_t seed = 1;  ///< of drawn predictors and of folds
  unsigned threads = 1;    ///< over folds; the result does not depend on it (0: one each core)
};

/// Never unfitted. Satisfies RegressorLike.
class BoostedTrees {
 public:
  /// [Hadi2026, Eqs. 4.2-4.5], LS_Boost of [Friedman2001] with shrinkage: f_0 is the mean, each
  /// tree is fitted to the residuals of the sum so far and added times the learning rate. Ends
  /// early where no tree can explain more. Throws InputError as RegressionTree::fit, on options out
  /// of range and on fewer points than held out or folds need.
  static BoostedTrees fit(const TrainingSet& data, const BoostedTreesOptions& options = {});

  Vector predict(const Matrix& x) const;
  const std::vector<Input>& inputs() const;
  std::string describe() const;
  const BoostedTreesOptions& options() const;
  Eigen::Index trees() const;  ///< that were kept
  double constant() const;     ///< f_0
  /// Root mean square error of the rows held out, with 0, 1, ... trees; empty with Stopping::none.
  const std::vector<double>& held_out_rmse() const;

 private:
  struct State;
  explicit BoostedTrees(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  friend struct TreeAccess;
  std::shared_ptr<const State> state_;
};

Trainer boosted_trees_trainer(std::string name, const BoostedTreesOptions& options = {});

}  // namespace repose::surrogate

// Cross-validation: how well a way of fitting predicts rows it has not seen.
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "repose/base/progress.hpp"
#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// Rows to fit to and rows to predict; nothing of the latter is seen by the fit.
struct Fold {
  std::string name;    ///< "fold 3", "repetition 2, fold 3", "ic=4"
  int repetition = 0;  ///< every repetition predicts each row once
  std::vector<Eigen::Index> train = {};
  std::vector<Eigen::Index> test = {};
};

/// Numbers points from 0: TrainingSet::replicates renumbered, or else equal for rows with equal x.
std::vector<Eigen::Index> points_of(const TrainingSet& data);
Eigen::Index number_of_points(const TrainingSet& data);

struct KFoldOptions {
  int folds = 10;
  int repetitions = 1;  ///< with other folds each
  std::uint64_t seed = 1;
};

/// Points by chance into folds of about equal numbers of rows; repeats of a point stay together.
/// Throws InputError on fewer than 2 folds or 1 repetition, and on more folds than points.
std::vector<Fold> k_folds(const TrainingSet& data, const KFoldOptions& options = {});

/// A fold for each group of TrainingSet::groups, in order of their numbers, of which names[number]
/// is the name (else "group NUMBER"). Throws InputError without groups and on a single one.
std::vector<Fold> leave_group_out(const TrainingSet& data,
                                  const std::vector<std::string>& names = {});

/// Of predictions about observations; NaN where not defined.
struct Metrics {
  Eigen::Index rows = 0;
  double rmse = std::numeric_limits<double>::quiet_NaN();  ///< [Hadi2026, 4.19]
  /// 1 - sum (y - p)^2 / sum (y - mean y)^2, negative where the mean predicts better
  /// [Hadi2026, 4.20]; not defined where y is constant.
  double r2 = std::numeric_limits<double>::quiet_NaN();
  /// Of y and p: 1 for predictions that are wrong by a factor and a shift. Not R^2.
  double squared_correlation = std::numeric_limits<double>::quiet_NaN();
  double mae = std::numeric_limits<double>::quiet_NaN();  ///< [Hadi2026, 4.21]
  /// Mean of -log of the normal density of each y, in nats; NaN without variances, or with one that
  /// is not known; infinite where one is.
  double negative_log_density = std::numeric_limits<double>::quiet_NaN();
};

/// variance: of observations, or empty. weights: positive, count as repeats of an observation, all
/// equal where empty. Throws InputError on lengths that differ.
Metrics metrics_of(const Vector& observed, const Vector& predicted, const Vector& variance = {},
                   const Vector& weights = {});

/// What became of a fold.
struct FoldResult {
  std::string name;
  int repetition = 0;
  Metrics metrics = {};     ///< of its test rows
  std::string description;  ///< Regressor::describe() of its model; not every setting
  std::string failure;      ///< why there is no prediction; empty if there is
  /// What a reader should know: a response constant in the training rows, a category's level that
  /// these lack.
  std::string note;
  double training_seconds = 0.0;
  double prediction_seconds = 0.0;
};

struct CrossValidation {
  std::vector<FoldResult> folds;
  /// n x repetitions; NaN where a fold failed, or has no variance.
  Matrix predicted;
  Matrix variance;  ///< of an observation
  /// Over all rows and repetitions that were predicted; negative_log_density is NaN where one of
  /// their variances is.
  Metrics metrics;
  int failed_folds = 0;
};

struct CrossValidationOptions {
  std::uint64_t seed = 1;  ///< fold f fits with a seed derived from it and f
  unsigned threads = 1;    ///< over folds; the result does not depend on it (0: one each processor)
  ProgressCallback progress = {};  ///< in folds; called from any thread, one at a time
};

/// Fits to each fold's training rows and predicts its test rows; weights count in both. A fit that
/// throws an Error, or a prediction that does so or is not finite, is a fold with a failure. Throws
/// InputError as check(TrainingSet), and on a fold that names rows that are not there or has none.
CrossValidation cross_validate(const TrainingSet& data, const Trainer& trainer,
                               const std::vector<Fold>& folds,
                               const CrossValidationOptions& options = {});

/// The same for several trainers on the same folds, all in one pool of threads.
std::vector<CrossValidation> cross_validate(const TrainingSet& data,
                                            const std::vector<Trainer>& trainers,
                                            const std::vector<Fold>& folds,
                                            const CrossValidationOptions& options = {});

/// What cross_validate would find for GaussianProcess::with_parameters, hyper-parameters held as
/// they are in `model`, in closed form [Ginsbourger2024]. The folds of each repetition must
/// divide the rows of `data`, which the model was fitted to, in this order.
CrossValidation cross_validate_fixed(const TrainingSet& data, const Regressor& gaussian_process,
                                     const std::vector<Fold>& folds);

/// The range of each number whose place in `undeclared` is true taken from the rows; a column that
/// is constant in them keeps the range it has.
TrainingSet with_own_ranges(TrainingSet data, const std::vector<bool>& undeclared);

/// `trainer` with the range of each number whose place in `undeclared` is true taken from the
/// training rows by with_own_ranges(), so that rows left out do not shape it.
Trainer with_ranges_of_training_rows(Trainer trainer, std::vector<bool> undeclared);

/// Rows a second that `model` predicts, all rows of x at once, repeated for a twentieth of a
/// second.
double prediction_rate(const Regressor& model, const Matrix& x);

}  // namespace repose::surrogate

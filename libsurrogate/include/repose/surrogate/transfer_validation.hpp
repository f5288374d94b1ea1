// What transfer is worth on a table of several groups: each group in turn is taken as new, some of
// its rows are given to a model of the others, and the rest tells how well it predicts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "repose/base/progress.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "repose/surrogate/transfer.hpp"

namespace repose::surrogate {

struct TransferValidationOptions {
  std::string model = "gpr";  ///< a preset
  SettingsSearchOptions search = {};
  std::vector<TransferMethod> methods = {TransferMethod::retrained, TransferMethod::weighted};
  std::vector<int> samples = {0, 1, 5, 10, 20};  ///< rows of the new group that are given
  enum class Order { random, variance } order = Order::random;  ///< which: see first_target_runs()
  int seeds = 5;                                                ///< other rows, other starts
  int folds = 10;                                               ///< of the validation
  /// Inputs whose range is no declaration but that of the data: each model has that of its source's
  /// rows, see with_own_ranges().
  std::vector<bool> undeclared = {};
  std::uint64_t seed = 1;
  unsigned threads = 1;            ///< over groups and seeds; the result does not depend on it
  ProgressCallback progress = {};  ///< in groups times seeds; called one at a time
};

/// A figure over seeds; NaN where not known, the deviation from two seeds on.
struct Spread {
  double mean = std::numeric_limits<double>::quiet_NaN();
  double deviation = std::numeric_limits<double>::quiet_NaN();
};

struct SpreadMetrics {
  Spread rmse, r2, squared_correlation, mae, negative_log_density;
};

/// A line of [Hadi2026, Tables 4.3 and 4.4].
struct TransferScore {
  Eigen::Index group = 0;
  int samples = 0;
  TransferMethod method = TransferMethod::retrained;
  /// Of retrained: rows left out in folds, of those it was fitted to. No values for others.
  SpreadMetrics validation = {};
  SpreadMetrics unseen = {};  ///< of the group's rows that were not given
  Spread correlation = {};    ///< estimated, of Transfer
  int averaged = 0;           ///< seeds, of means groups, whose rows could be predicted
  /// The first seed's that failed; figures are of the others. "validation: ..." where only that
  /// did: figures of unseen rows are not concerned. Of means: how many groups could be predicted,
  /// if not all.
  std::string failure;
};

struct TransferValidation {
  SpreadMetrics all_seen;             ///< validation of a model fitted to all groups
  std::string all_seen_failure;       ///< the first seed's that failed
  std::vector<TransferScore> scores;  ///< by method, group and samples
  /// Averages over groups, deviations too, as the thesis has them; group is -1.
  std::vector<TransferScore> means;
};

/// `data` with groups. A preset with searched settings searches them for each group and seed, and
/// keeps them. Throws InputError on a single group, without samples, methods or seeds, as
/// check_possible(), and if no group has more rows than the smallest number of samples.
TransferValidation validate_transfer(const TrainingSet& data,
                                     const TransferValidationOptions& options = {});

}  // namespace repose::surrogate

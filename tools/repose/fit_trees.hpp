// Models of `repose fit` other than its own Gaussian process: options of trees and ensembles, and
// what is said of a fitted model of any kind.
#pragma once

#include <optional>
#include <string>

#include "command.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/surrogate/tree.hpp"

namespace repose::cli {

/// What is not given has the library's default.
struct TreeFitOptions {
  std::optional<Eigen::Index> trees;
  std::optional<double> learning_rate;
  std::optional<Eigen::Index> minimum_leaf;
  std::optional<Eigen::Index> maximum_splits;
  std::optional<Eigen::Index> maximum_depth;
  std::optional<Eigen::Index> predictors;
  std::string stop_early = "none";
  Eigen::Index folds = 5;
};
void add_tree_options(CLI::App* command, TreeFitOptions* options);

/// "tree", "bagged-trees" or "boosted-trees".
bool is_tree_model(const std::string& model);
/// Throws InputError for options that mean nothing for this model.
void refuse_options_of_other_models(const CLI::App& command, const std::string& model);

/// A way to fit `model` with these options, on so many threads (0: one each core).
surrogate::Trainer tree_model_trainer(const std::string& model, const TreeFitOptions& options,
                                      unsigned threads);

/// The same way to fit twice.
struct FitMethod {
  surrogate::Trainer of_all_rows;
  /// On one thread, for refits side by side without rows or groups (of data.groups), which judge
  /// the model. None where they would search for settings: that is for `repose cv`.
  std::optional<surrogate::Trainer> of_folds;
};

/// Fits and judges, then writes `output` and prints: the error, and the importance of the inputs.
void fit_regressor(const FitMethod& method, const surrogate::TrainingSet& data,
                   const std::vector<std::string>& names, const std::string& response,
                   std::uint64_t seed, const std::string& output, const CommonOptions& common);

}  // namespace repose::cli

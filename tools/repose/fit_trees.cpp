#include "fit_trees.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <numeric>

#include "repose/base/error.hpp"
#include "repose/surrogate/bagged_trees.hpp"
#include "repose/surrogate/boosted_trees.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "validation.hpp"

namespace repose::cli {
namespace {

using namespace surrogate;

/// The error at rows the model has not seen, and the importance of its inputs.
struct Judgement {
  std::string left_out;  ///< "rows out of bag", "rows (10 folds)", "groups"; else empty, and
  std::string unknown = "there are too few rows to leave some out";
  double rmse = std::nan("");
  double q2 = std::nan("");
  std::size_t folds = 0;
  int failed_folds = 0;  ///< of whose rows the error does not know
  std::string first_failure = {};
  std::vector<Importance> importance = {};
  std::string exchanged = "rows";  ///< among which importance exchanges an input
};

TreeOptions tree_options(const TreeFitOptions& o, TreeOptions tree) {
  if (o.minimum_leaf) tree.minimum_leaf = *o.minimum_leaf;
  if (o.maximum_splits) tree.maximum_splits = o.maximum_splits;
  if (o.maximum_depth) tree.maximum_depth = o.maximum_depth;
  if (o.predictors) tree.predictors = o.predictors;
  return tree;
}

BaggedTreesOptions bag_options(const TreeFitOptions& o, unsigned threads) {
  BaggedTreesOptions bag;
  bag.trees = o.trees.value_or(bag.trees);
  bag.tree = tree_options(o, bag.tree);
  bag.threads = threads;
  return bag;
}

BoostedTreesOptions boosting_options(const TreeFitOptions& o, unsigned threads) {
  BoostedTreesOptions boosting;
  boosting.trees = o.trees.value_or(boosting.trees);
  boosting.learning_rate = o.learning_rate.value_or(boosting.learning_rate);
  if (o.maximum_depth) boosting.tree.maximum_splits = std::nullopt;
  boosting.tree = tree_options(o, boosting.tree);
  boosting.stopping = named(o.stop_early, {Stopping::none, Stopping::held_out, Stopping::k_fold});
  boosting.folds = o.folds;
  boosting.threads = threads;
  return boosting;
}

/// Groups where there are any, else ten folds, or as many as there are points.
std::vector<Fold> folds_of(const TrainingSet& data, std::uint64_t seed) {
  if (!data.groups.empty()) return leave_group_out(data);
  const std::vector<Eigen::Index> points = points_of(data);
  const auto number = static_cast<int>(*std::max_element(points.begin(), points.end()) + 1);
  if (number < 2) return {};
  return k_folds(data, {.folds = std::min(10, number), .seed = seed});
}

void judge_by_folds(const Trainer& trainer, const std::vector<Fold>& folds, const TrainingSet& data,
                    std::uint64_t seed, Judgement& result) {
  const CrossValidation cv = cross_validate(data, trainer, folds, {.seed = seed, .threads = 0});
  result.left_out = data.groups.empty() ? fmt::format("rows ({} folds)", folds.size()) : "groups";
  result.rmse = cv.metrics.rmse;
  result.q2 = cv.metrics.r2;
  result.folds = folds.size();
  result.failed_folds = cv.failed_folds;
  for (const FoldResult& fold : cv.folds) {
    if (fold.failure.empty()) continue;
    result.first_failure = fmt::format("{}: {}", fold.name, fold.failure);
    break;
  }
}

void find_importance(const Regressor& model, const TrainingSet& data, std::uint64_t seed,
                     Judgement& result) {
  if (const auto* bag = model.target<BaggedTrees>()) {
    try {
      result.importance = bag->importance(data, seed);
      result.exchanged = "rows out of bag";
      return;
    } catch (const InputError&) {
      // too few trees have rows out of their bags
    }
  }
  result.importance = permutation_importance(model, data, {.seed = seed});
}

Judgement judge(const Regressor& model, const std::optional<Trainer>& of_folds,
                const TrainingSet& data, std::uint64_t seed) {
  Judgement result;
  const auto* bag = model.target<BaggedTrees>();
  if (!of_folds) {
    result.unknown = "repose cv tells the error at rows left out, searching without them";
  } else if (bag != nullptr && data.groups.empty()) {
    result.left_out = "rows out of bag";
    result.rmse = bag->out_of_bag().rmse;
    result.q2 = bag->out_of_bag().q2;
  } else if (const auto folds = folds_of(data, seed); !folds.empty()) {
    judge_by_folds(*of_folds, folds, data, seed, result);
  }
  if (data.rows() > 1) find_importance(model, data, seed, result);
  return result;
}

/// Most important first.
std::vector<std::size_t> ranking(const std::vector<Importance>& importance) {
  std::vector<std::size_t> order(importance.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return importance[a].increase > importance[b].increase;
  });
  return order;
}

void print_json(const std::string& kind, const NamedRegressor& named, const Judgement& judgement,
                Eigen::Index rows, double seconds, const std::string& file) {
  nlohmann::json importance = nlohmann::json::array();
  for (const std::size_t k : ranking(judgement.importance))
    importance.push_back({{"input", named.inputs[k]},
                          {"increase", judgement.importance[k].increase},
                          {"standard_error", judgement.importance[k].standard_error}});
  const nlohmann::json json{{"response", named.response},
                            {"inputs", named.inputs},
                            {"rows", rows},
                            {"model", kind},
                            {"description", named.model.describe()},
                            {"left_out", judgement.left_out},
                            {"rmse", number_or_null(judgement.rmse)},
                            {"q2", number_or_null(judgement.q2)},
                            {"failed_folds", judgement.failed_folds},
                            {"first_failure", judgement.first_failure},
                            {"importance", importance},
                            {"seconds", seconds},
                            {"file", file}};
  fmt::print("{}\n", json.dump(2));
}

void print_text(const NamedRegressor& named, const Judgement& judgement, Eigen::Index rows,
                double seconds, const std::string& file) {
  fmt::print("{} of {} rows and {} inputs, {:.2f} s\n{}\n\n", named.response, rows,
             named.inputs.size(), seconds, named.model.describe());
  if (judgement.left_out.empty())
    fmt::print("  {}\n", judgement.unknown);
  else
    fmt::print("  {:<40} {:>12.4f}\n  {:<40} {:>12.5g}\n", judgement.left_out + ": Q2",
               judgement.q2, judgement.left_out + ": root mean square error", judgement.rmse);
  if (judgement.failed_folds > 0)
    fmt::print("  without {} of {} folds, which failed; {}\n", judgement.failed_folds,
               judgement.folds, judgement.first_failure);
  if (!judgement.importance.empty())
    fmt::print("\n  by how much the mean square error grows when an input is exchanged among {}\n",
               judgement.exchanged);
  for (const std::size_t k : ranking(judgement.importance))
    fmt::print("  {:<40} {:>12.5g} ± {:.2g}\n", named.inputs[k], judgement.importance[k].increase,
               judgement.importance[k].standard_error);
  fmt::print("\nwritten to {}\n", file);
}

}  // namespace

void add_tree_options(CLI::App* command, TreeFitOptions* o) {
  const auto positive = CLI::Range(Eigen::Index{1}, Eigen::Index{1000000});
  command->add_option("--trees", o->trees, "of an ensemble; else 100")->check(positive);
  command
      ->add_option("--learning-rate", o->learning_rate,
                   "of boosting: the part of each tree that is added, up to 1; else 0.1")
      ->check(CLI::Range(0.0, 1.0));
  command
      ->add_option("--minimum-leaf", o->minimum_leaf,
                   "rows in a leaf of a tree; else 1 where bagged, 5 elsewhere")
      ->check(positive);
  command
      ->add_option("--maximum-splits", o->maximum_splits,
                   "of a tree; else 10 where boosted, no limit elsewhere")
      ->check(positive);
  command->add_option("--maximum-depth", o->maximum_depth, "of a tree; else no limit")
      ->check(positive);
  command->add_option("--predictors", o->predictors, "inputs drawn for each split; else all")
      ->check(positive);
  command
      ->add_option("--stop-early", o->stop_early,
                   "boosted trees: as many as suit rows left out: none, held-out, k-fold")
      ->capture_default_str()
      ->check(CLI::IsMember({"none", "held-out", "k-fold"}).description(""));
  command->add_option("--folds", o->folds, "of --stop-early")
      ->capture_default_str()
      ->check(CLI::Range(2, 1000));
}

bool is_tree_model(const std::string& model) {
  return model == "tree" || model == "bagged-trees" || model == "boosted-trees";
}

void refuse_options_of_other_models(const CLI::App& command, const std::string& model) {
  const std::string why = "with --model " + model;
  if (model != "gpr")
    refuse_options(command,
                   {"--kernel", "--basis", "--select", "--noise", "--estimator", "--prior",
                    "--parameter-uncertainty", "--bound", "--response-scale", "--starts"},
                   why);
  if (model != "gpr" && !model.starts_with("optimisable-"))
    refuse_options(command, {"--optimise"}, why);
  if (!is_tree_model(model))
    refuse_options(
        command,
        {"--trees", "--minimum-leaf", "--maximum-splits", "--maximum-depth", "--predictors"}, why);
  if (model != "boosted-trees")
    refuse_options(command, {"--learning-rate", "--stop-early", "--folds"}, why);
  if (model == "tree") refuse_options(command, {"--trees"}, why);
}

Trainer tree_model_trainer(const std::string& model, const TreeFitOptions& options,
                           unsigned threads) {
  if (model == "tree") return tree_trainer(model, tree_options(options, {}));
  if (model == "bagged-trees") return bagged_trees_trainer(model, bag_options(options, threads));
  return boosted_trees_trainer(model, boosting_options(options, threads));
}

void fit_regressor(const FitMethod& method, const TrainingSet& data,
                   const std::vector<std::string>& names, const std::string& response,
                   std::uint64_t seed, const std::string& output, const CommonOptions& common) {
  const auto start = std::chrono::steady_clock::now();
  const NamedRegressor fitted{method.of_all_rows.fit(data, seed), names, response};
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const Judgement judgement = judge(fitted.model, method.of_folds, data, seed);
  save_regressor(output, fitted);
  if (common.json)
    print_json(method.of_all_rows.name, fitted, judgement, data.rows(), seconds, output);
  else
    print_text(fitted, judgement, data.rows(), seconds, output);
}

}  // namespace repose::cli

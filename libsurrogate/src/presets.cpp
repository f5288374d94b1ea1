#include "repose/surrogate/presets.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/surrogate/bagged_trees.hpp"
#include "repose/surrogate/boosted_trees.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/linear_model.hpp"
#include "repose/surrogate/perceptron.hpp"
#include "repose/surrogate/support_vector_regression.hpp"

namespace repose::surrogate {
namespace {

using TrainerOf =
    std::function<Trainer(const std::string& name, const SettingsSearchOptions& search)>;

struct Row {
  ModelPreset preset;
  TrainerOf trainer;
  ModelFamily family = {};  ///< where settings are searched
};

TrainerOf linear(const LinearModelOptions& options) {
  return [options](const std::string& name, const SettingsSearchOptions&) {
    return linear_model_trainer(name, options);
  };
}

TrainerOf tree(Eigen::Index minimum_leaf) {
  return [minimum_leaf](const std::string& name, const SettingsSearchOptions&) {
    return tree_trainer(name, {.minimum_leaf = minimum_leaf});
  };
}

Trainer boosted(const std::string& name, const SettingsSearchOptions&) {
  return boosted_trees_trainer(
      name, {.trees = 30, .learning_rate = 0.1, .tree = {.minimum_leaf = 8, .maximum_splits = 10}});
}

/// All predictors at each split.
Trainer bagged(const std::string& name, const SettingsSearchOptions&) {
  return {.name = name, .fit = [](const TrainingSet& data, std::uint64_t seed) {
            return Regressor(
                BaggedTrees::fit(data, {.trees = 30,
                                        .tree = {.minimum_leaf = 8, .predictors = data.dimension()},
                                        .seed = seed}));
          }};
}

TrainerOf svr(const SvrOptions& options) {
  return [options](const std::string& name, const SettingsSearchOptions&) {
    return svr_trainer(name, options);
  };
}

/// MATLAB's: isotropic; ours: the restricted likelihood with its prior.
TrainerOf gpr(Correlation correlation) {
  return [correlation](const std::string& name, const SettingsSearchOptions&) {
    return gaussian_process_trainer(name, {.kernel = {correlation, LengthScales::shared}});
  };
}

TrainerOf network(std::vector<int> layers) {
  return [layers = std::move(layers)](const std::string& name, const SettingsSearchOptions&) {
    return perceptron_trainer(name, {.layers = layers, .networks = 1});
  };
}

Row process(ModelPreset preset, TrainerOf trainer) {
  preset.gaussian_process = true;
  return {std::move(preset), std::move(trainer)};
}

Row searched(ModelPreset preset, const ModelFamily& family) {
  preset.searched = true;
  return {std::move(preset),
          [family](const std::string& name, const SettingsSearchOptions& search) {
            return searching_trainer(name, family, search);
          },
          family};
}

std::vector<Row> make_rows() {
  using enum LinearMethod;
  constexpr const char* kLinear = "Linear Regression";
  constexpr const char* kTree = "Regression Tree";
  constexpr const char* kEnsemble = "Ensemble of Trees";
  constexpr const char* kSvm = "SVM";
  constexpr const char* kGpr = "GPR";
  constexpr const char* kAnn = "ANN";
  return {
      {{"linear", kLinear, "-"}, linear({})},
      {{"interactions-linear", kLinear, "Interactions"},
       linear({.terms = LinearTerms::interactions})},
      {{"robust-linear", kLinear, "Robust"}, linear({.method = robust})},
      {{"stepwise-linear", kLinear, "Stepwise"},
       linear({.terms = LinearTerms::interactions, .method = stepwise})},
      {{"fine-tree", kTree, "Fine"}, tree(4)},
      {{"medium-tree", kTree, "Medium"}, tree(12)},
      {{"coarse-tree", kTree, "Coarse"}, tree(36)},
      searched({"optimisable-tree", kTree, "Optimisable (BO)"}, tree_family()),
      {{"linear-svm", kSvm, "Kernel: linear"}, svr({.kernel = SvrKernel::linear})},
      {{"quadratic-svm", kSvm, "Kernel: quadratic"}, svr({.kernel = SvrKernel::quadratic})},
      {{"cubic-svm", kSvm, "Kernel: cubic"}, svr({.kernel = SvrKernel::cubic})},
      {{"fine-gaussian-svm", kSvm, "Kernel: Fine Gaussian"}, svr({.kernel_scale = 0.25})},
      {{"medium-gaussian-svm", kSvm, "Kernel: Medium Gaussian"}, svr({.kernel_scale = 1.0})},
      {{"coarse-gaussian-svm", kSvm, "Kernel: Coarse Gaussian"}, svr({.kernel_scale = 4.0})},
      searched({"optimisable-svm", kSvm, "Optimisable (BO)"}, svr_family()),
      {{"boosted-ensemble", kEnsemble, "Boosted"}, boosted},
      {{"bagged-ensemble", kEnsemble, "Bagged"}, bagged},
      searched({"optimisable-ensemble", kEnsemble, "Optimisable (BO)"}, ensemble_family()),
      process({"exponential-gpr", kGpr, "Kernel = Exponential"}, gpr(Correlation::exponential)),
      process({"squared-exponential-gpr", kGpr, "Kernel = Squared Exponential"},
              gpr(Correlation::squared_exponential)),
      process({"rational-quadratic-gpr", kGpr, "Kernel = Rational Quadratic"},
              gpr(Correlation::rational_quadratic)),
      process({"matern52-gpr", kGpr, "Kernel = Matern 5/2"}, gpr(Correlation::matern52)),
      searched({"optimisable-gpr", kGpr, "Optimisable (BO)", false, true},
               gaussian_process_family()),
      {{"narrow-network", kAnn, "One layer [10] neurons"}, network({10})},
      {{"medium-network", kAnn, "One layer [25] neurons"}, network({25})},
      {{"wide-network", kAnn, "One layer [100] neurons"}, network({100})},
      {{"bilayered-network", kAnn, "Two layers [10,10] neurons"}, network({10, 10})},
      {{"trilayered-network", kAnn, "Three layers [10,10,10] neurons"}, network({10, 10, 10})},
      searched({"optimisable-network", kAnn, "Optimisable (BO)"}, perceptron_family()),
      process({"gpr", "repose", "Gaussian process, default"},
              [](const std::string& name, const SettingsSearchOptions&) {
                return gaussian_process_trainer(name);
              }),
  };
}

const std::vector<Row>& rows() {
  static const std::vector<Row> kRows = make_rows();
  return kRows;
}

}  // namespace

const std::vector<ModelPreset>& model_presets() {
  static const std::vector<ModelPreset> kPresets = [] {
    std::vector<ModelPreset> presets;
    for (const Row& row : rows()) presets.push_back(row.preset);
    return presets;
  }();
  return kPresets;
}

namespace {

const Row& row_named(const std::string& name) {
  std::vector<std::string> names;
  for (const Row& row : rows()) {
    if (row.preset.name == name) return row;
    names.push_back(row.preset.name);
  }
  const std::string closest = closest_name(name, names);
  throw InputError(closest.empty()
                       ? fmt::format("there is no model '{}'; choose {}", name, listed(names))
                       : fmt::format("there is no model '{}'; did you mean {}?", name, closest));
}

/// With its hyper-parameters.
Trainer trainer_like(std::string name, const GaussianProcess& process) {
  return {std::move(name), [process](const TrainingSet& data, std::uint64_t) -> Regressor {
            check(data);
            refuse_weights(data);
            return GaussianProcessRegressor(GaussianProcess::with_parameters(
                data.x, data.y, process.inputs(), process.hyperparameters(),
                {.kernel = process.kernel(),
                 .basis = process.basis(),
                 .response_scale = process.response_scale(),
                 .estimator = process.estimator()}));
          }};
}

}  // namespace

const ModelPreset& model_preset(const std::string& name) {
  return row_named(name).preset;
}

Trainer preset_trainer(const std::string& name, const SettingsSearchOptions& search) {
  return row_named(name).trainer(name, search);
}

PretrainedModel pretrained(const std::string& name, const TrainingSet& data, std::uint64_t seed,
                           const SettingsSearchOptions& search) {
  const Row& row = row_named(name);
  Trainer trainer = row.trainer(name, search);
  if (row.preset.searched) {
    SettingsSearchOptions own = search;
    own.seed = seed;
    const SettingsSearch found = search_settings(data, row.family, own);
    trainer = row.family.trainer(found.trials[found.best].settings);
  }
  Regressor model = trainer.fit(data, seed);
  // without variance, of a constant response, there are no hyper-parameters to keep
  const GaussianProcess* process = gaussian_process(model);
  if (process != nullptr && process->hyperparameters().process_variance > 0.0)
    trainer = trainer_like(name, *process);
  return {std::move(model), std::move(trainer)};
}

}  // namespace repose::surrogate

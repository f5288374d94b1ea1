#include <algorithm>
#include <cmath>

#include "repose/surrogate/bagged_trees.hpp"
#include "repose/surrogate/boosted_trees.hpp"
#include "repose/surrogate/perceptron.hpp"
#include "repose/surrogate/settings_search.hpp"
#include "repose/surrogate/support_vector_regression.hpp"

namespace repose::surrogate {
namespace {

Parameter log_parameter(std::string name, double lower, double upper) {
  return {.name = std::move(name), .lower = lower, .upper = upper, .scale = Scale::log};
}

Parameter whole_number(std::string name, double lower, double upper, Scale scale) {
  return {.name = std::move(name),
          .lower = lower,
          .upper = upper,
          .scale = scale,
          .kind = ParameterKind::integer};
}

Parameter choice(std::string name, std::vector<std::string> categories) {
  return {.name = std::move(name),
          .kind = ParameterKind::categorical,
          .categories = std::move(categories)};
}

Standardisation standardisation_of(double value) {
  return value == 1.0 ? Standardisation::standard_deviation : Standardisation::none;
}

/// Of a standardised row with itself, inputs divided by `scale` roots of their number.
double kernel_size(SvrKernel kernel, double scale) {
  const double square = 1.0 / (scale * scale);
  switch (kernel) {
    case SvrKernel::linear:
      return square;
    case SvrKernel::quadratic:
      return std::pow(1.0 + square, 2);
    case SvrKernel::cubic:
      return std::pow(1.0 + square, 3);
    case SvrKernel::gaussian:
      break;
  }
  return 1.0;
}

Eigen::Index whole(double value) {
  return static_cast<Eigen::Index>(value);
}

Parameter minimum_leaf(const TrainingSet& data) {
  const auto half = std::floor(0.5 * static_cast<double>(data.rows()));
  return whole_number("minimum_leaf", 1.0, std::max(2.0, half), Scale::log);
}

Regressor fitted_ensemble(const Vector& s, const TrainingSet& data, std::uint64_t seed) {
  const TreeOptions tree{.minimum_leaf = whole(s[3]),
                         .maximum_splits = whole(s[4]),
                         .predictors = std::min(whole(s[5]), data.dimension())};
  if (s[0] == 0.0)
    return BaggedTrees::fit(data, {.trees = whole(s[1]), .tree = tree, .seed = seed});
  return BoostedTrees::fit(
      data, {.trees = whole(s[1]), .learning_rate = s[2], .tree = tree, .seed = seed});
}

}  // namespace

ModelFamily svr_family() {
  return {.name = "support vector regression",
          .space =
              [](const TrainingSet&) {
                return ParameterSpace(
                    {choice("kernel", {"linear", "quadratic", "cubic", "gaussian"}),
                     log_parameter("box_constraint", 1e-3, 1e2),
                     log_parameter("epsilon", 1e-3, 1e2), log_parameter("kernel_scale", 0.05, 50.0),
                     choice("standardise", {"false", "true"})});
              },
          .trainer =
              [](const Vector& s) {
                const auto kernel = static_cast<SvrKernel>(static_cast<int>(s[0]));
                return svr_trainer("support vector regression",
                                   {.kernel = kernel,
                                    .kernel_scale = s[3],
                                    .box_constraint = s[1] / kernel_size(kernel, s[3]),
                                    .epsilon = s[2],
                                    .standardisation = standardisation_of(s[4])});
              }};
}

ModelFamily perceptron_family() {
  return {.name = "neural network",
          .space =
              [](const TrainingSet& data) {
                const auto n = static_cast<double>(data.rows());
                return ParameterSpace({whole_number("layers", 1, 3, Scale::linear),
                                       whole_number("neurons_1", 1, 100, Scale::log),
                                       whole_number("neurons_2", 1, 100, Scale::log),
                                       whole_number("neurons_3", 1, 100, Scale::log),
                                       log_parameter("penalty", 1e-5 / n, 1e5 / n),
                                       choice("standardise", {"false", "true"})});
              },
          .trainer =
              [](const Vector& s) {
                std::vector<int> layers;
                for (Eigen::Index l = 0; l < static_cast<Eigen::Index>(s[0]); ++l)
                  layers.push_back(static_cast<int>(s[1 + l]));
                return perceptron_trainer("neural network",
                                          {.layers = layers,
                                           .penalty = s[4],
                                           .networks = 1,
                                           .standardisation = standardisation_of(s[5]),
                                           .max_evaluations = 300});
              }};
}

ModelFamily tree_family() {
  return {.name = "tree",
          .space = [](const TrainingSet& data) { return ParameterSpace({minimum_leaf(data)}); },
          .trainer =
              [](const Vector& s) { return tree_trainer("tree", {.minimum_leaf = whole(s[0])}); }};
}

ModelFamily ensemble_family() {
  return {.name = "ensemble of trees",
          .space =
              [](const TrainingSet& data) {
                const auto n = static_cast<double>(data.rows());
                const auto d = static_cast<double>(data.dimension());
                return ParameterSpace(
                    {choice("method", {"bagging", "boosting"}),
                     whole_number("trees", 10.0, 500.0, Scale::log),
                     log_parameter("learning_rate", 1e-3, 1.0), minimum_leaf(data),
                     whole_number("maximum_splits", 1.0, std::max(2.0, n - 1.0), Scale::log),
                     whole_number("predictors", 1.0, std::max(2.0, d), Scale::linear)});
              },
          .trainer =
              [](const Vector& s) {
                return Trainer{"ensemble of trees",
                               [s](const TrainingSet& data, std::uint64_t seed) {
                                 return fitted_ensemble(s, data, seed);
                               }};
              }};
}

}  // namespace repose::surrogate

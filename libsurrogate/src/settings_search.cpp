#include "repose/surrogate/settings_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "repose/surrogate/fitter.hpp"

namespace repose::surrogate {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A failed trial counts as if it were off by three deviations of y, as does one that is worse; a
/// perfect one is not minus infinity.
double loss_of(const SettingsTrial& trial, double sd) {
  const double worst = 3.0 * sd;
  const double rmse = trial.failure.empty() ? std::min(trial.rmse, worst) : worst;
  return 2.0 * std::log(std::max(rmse, 1e-12 * sd));
}

void cross_validate(SettingsTrial& trial, const TrainingSet& data, const ModelFamily& family,
                    const std::vector<Fold>& folds, const SettingsSearchOptions& options) {
  const CrossValidation result =
      surrogate::cross_validate(data, family.trainer(trial.settings), folds,
                                {.seed = options.seed, .threads = options.threads});
  trial.rmse = result.metrics.rmse;
  for (const FoldResult& fold : result.folds)
    if (!fold.failure.empty() && trial.failure.empty()) trial.failure = fold.failure;
}

/// Of y, weights as repeats; positive.
double deviation_of(const TrainingSet& data) {
  const Vector w = data.weights.size() > 0 ? data.weights : Vector(Vector::Ones(data.rows()));
  const double mean = data.y.dot(w) / w.sum();
  return std::max(std::sqrt((data.y.array() - mean).square().matrix().dot(w) / w.sum()),
                  std::numeric_limits<double>::min());
}

/// Of the trials that could be fitted; the optimiser's if that is one of them.
std::size_t best_trial(const std::vector<SettingsTrial>& trials, std::size_t recommended) {
  if (trials[recommended].failure.empty()) return recommended;
  const auto rank = [](const SettingsTrial& t) { return std::pair(!t.failure.empty(), t.rmse); };
  return static_cast<std::size_t>(
      std::min_element(
          trials.begin(), trials.end(),
          [&rank](const SettingsTrial& a, const SettingsTrial& b) { return rank(a) < rank(b); }) -
      trials.begin());
}

}  // namespace

SettingsSearch search_settings(const TrainingSet& data, const ModelFamily& family,
                               const SettingsSearchOptions& options) {
  if (options.initial_points < 2 || options.evaluations < options.initial_points)
    throw InputError(
        fmt::format("{} evaluations of which the first {} are by chance; there must be at least 2 "
                    "by chance and no fewer in all",
                    options.evaluations, options.initial_points));
  const auto folds = k_folds(data, {.folds = options.folds, .seed = options.seed});
  SettingsSearch search{.space = family.space(data)};
  const opt::OptimizationProblem problem{.parameters = search.space,
                                         .responses = {"log_mean_square_error"}};
  opt::BayesianOptimizationOptions bayesian{.initial_points = options.initial_points,
                                            .seed = options.seed};
  bayesian.propose.repeats = opt::Repeats::avoid;
  bayesian.propose.threads = options.threads;
  // the optimiser's own model: noise estimated, categories exchangeable
  opt::BayesianOptimizer optimizer(problem, gaussian_process_fitter(search.space), bayesian);
  const double sd = deviation_of(data);
  double best = kInfinity;
  for (int i = 0; i < options.evaluations; ++i) {
    const opt::Trial asked = optimizer.ask()[0];
    SettingsTrial trial{.settings = asked.x};
    cross_validate(trial, data, family, folds, options);
    optimizer.tell(asked.id, Vector::Constant(1, loss_of(trial, sd)));
    if (trial.failure.empty()) best = std::min(best, trial.rmse);
    search.trials.push_back(std::move(trial));
    if (options.progress)
      options.progress(i + 1, options.evaluations, fmt::format("smallest error {:.4g}", best));
  }
  if (!std::isfinite(best))
    throw InputError(fmt::format("none of {} settings of {} could be fitted; the first: {}",
                                 search.trials.size(), family.name, search.trials.front().failure));
  search.best =
      best_trial(search.trials, static_cast<std::size_t>(optimizer.recommend().trial - 1));
  return search;
}

std::string settings_text(const ParameterSpace& space, const Vector& settings) {
  std::string text;
  for (std::size_t k = 0; k < space.dimension(); ++k) {
    const Parameter& p = space.parameters()[k];
    const double value = settings[static_cast<Eigen::Index>(k)];
    text += fmt::format("{}{} {}", k == 0 ? "" : ", ", p.name,
                        p.kind == ParameterKind::categorical
                            ? p.categories[static_cast<std::size_t>(value)]
                            : fmt::format("{:.4g}", value));
  }
  return text;
}

Trainer searching_trainer(std::string name, ModelFamily family,
                          const SettingsSearchOptions& options) {
  return {
      .name = std::move(name),
      .fit = [family = std::move(family), options](const TrainingSet& data, std::uint64_t seed) {
        SettingsSearchOptions own = options;
        own.seed = seed;
        const SettingsSearch search = search_settings(data, family, own);
        return family.trainer(search.trials[search.best].settings).fit(data, seed);
      }};
}

}  // namespace repose::surrogate

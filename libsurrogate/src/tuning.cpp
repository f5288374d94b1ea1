#include "repose/surrogate/tuning.hpp"

#include <utility>

#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/settings_search.hpp"

namespace repose::surrogate {
namespace {

TuningTrial trial_of(const ParameterSpace& space, const SettingsTrial& trial) {
  const Vector& s = trial.settings;
  const auto name = [&](std::size_t k) {
    return space.parameters()[k]
        .categories[static_cast<std::size_t>(s[static_cast<Eigen::Index>(k)])];
  };
  return {.kernel = kernel_named(name(0)),
          .basis = basis_named(name(1)),
          .noise_standard_deviation = s[2],
          .kernel_scale = s[3],
          .standardised = s[4] == 1.0,
          .rmse = trial.rmse,
          .failure = trial.failure};
}

}  // namespace

Tuning tune_model(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                  const GaussianProcessOptions& options, const TuningOptions& tuning) {
  const TrainingSet data{.x = x, .y = y, .inputs = inputs, .replicates = tuning.groups};
  GaussianProcessOptions quick = options;
  quick.starts = 1;
  quick.threads = 1;
  const SettingsSearch search = search_settings(data, gaussian_process_family(quick),
                                                {.evaluations = tuning.evaluations,
                                                 .initial_points = tuning.initial_points,
                                                 .folds = tuning.folds,
                                                 .seed = tuning.seed,
                                                 .threads = tuning.threads,
                                                 .progress = tuning.progress});
  const Regressor best = gaussian_process_family(options)
                             .trainer(search.trials[search.best].settings)
                             .fit(data, tuning.seed);
  Tuning result{.model = *gaussian_process(best), .trials = {}, .best = search.best};
  for (const SettingsTrial& trial : search.trials)
    result.trials.push_back(trial_of(search.space, trial));
  return result;
}

}  // namespace repose::surrogate

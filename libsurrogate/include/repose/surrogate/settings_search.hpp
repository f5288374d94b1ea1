// Settings of a kind of model, such as the size of a leaf or the width of a kernel, found by
// Bayesian optimisation of the error in cross-validation.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "repose/base/progress.hpp"
#include "repose/surrogate/gaussian_process_options.hpp"
#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// A kind of model whose settings are searched.
struct ModelFamily {
  std::string name;
  /// What may vary and where, for these data.
  std::function<ParameterSpace(const TrainingSet& data)> space;
  /// The trainer with these values of the space's free parameters.
  std::function<Trainer(const Vector& settings)> trainer;
};

/// Support vector regression: kernel, box constraint [1e-3, 1e2] in deviations of y over the
/// kernel's size (1 of gaussian, 1/s^2 of linear, (1 + 1/s^2)^2 and ^3 of the others), epsilon
/// [1e-3, 1e2] in deviations of y, kernel scale s [0.05, 50] roots of the number of coordinates,
/// standardisation. (MATLAB's fitrsvm lets box constraint and scale go from 1e-3 to 1e3; LIBSVM
/// takes time in proportion to box constraint times kernel.)
ModelFamily svr_family();
/// Perceptrons: one to three layers of 1 to 100 neurons each, penalty [1e-5, 1e5]/n,
/// standardisation. One network, 300 evaluations. (MATLAB's fitrnet goes to 300 neurons.)
ModelFamily perceptron_family();
/// One tree: minimum leaf [1, n/2].
ModelFamily tree_family();
/// Bagged or boosted trees over [Hadi2026, Table C.3]: method, number of trees [10, 500], learning
/// rate [1e-3, 1] (of boosting), minimum leaf [1, n/2], maximum splits [1, n - 1], predictors drawn
/// for each split [1, d].
ModelFamily ensemble_family();
/// Gaussian processes over [Hadi2026, Table C.4]: kernel; basis; noise deviation, held fixed,
/// [1e-4, max(1e-3, 10 sd(y))]; length scale of kernels that share one, held fixed, [1e-3, 1] of
/// the inputs' largest range; standardisation of the inputs. What the settings leave open maximises
/// the likelihood from options.starts starts. Kernel, basis, noise, estimator, prior and bounds of
/// `options` are not used.
ModelFamily gaussian_process_family(const GaussianProcessOptions& options = {.starts = 1});

struct SettingsSearchOptions {
  int evaluations = 50;    ///< cross-validations, each of `folds` fits; >= initial_points
  int initial_points = 4;  ///< by chance; >= 2
  int folds = 5;           ///< repeats of a point stay together, see k_folds()
  std::uint64_t seed = 1;
  unsigned threads = 1;            ///< over folds; the result does not depend on it
  ProgressCallback progress = {};  ///< in evaluations
};

struct SettingsTrial {
  Vector settings;      ///< of the free parameters, in order
  double rmse = 0.0;    ///< of the rows left out, over all folds
  std::string failure;  ///< why a fold could not be fitted; such a trial counts as bad
};

struct SettingsSearch {
  ParameterSpace space;
  std::vector<SettingsTrial> trials;
  std::size_t best = 0;  ///< the trial of smallest rmse as the optimiser's own model expects it
};

/// Expected improvement of the logarithm of the mean square error. Throws InputError as k_folds(),
/// on numbers of evaluations out of range, and if no trial could be fitted.
SettingsSearch search_settings(const TrainingSet& data, const ModelFamily& family,
                               const SettingsSearchOptions& options = {});

/// "kernel gaussian, box_constraint 0.35"
std::string settings_text(const ParameterSpace& space, const Vector& settings);

/// Searches among the rows it is given and fits all of them with the best settings: nothing else
/// can leak into the choice. The seed of the fit replaces that of the options.
Trainer searching_trainer(std::string name, ModelFamily family,
                          const SettingsSearchOptions& options = {});

}  // namespace repose::surrogate

// A Gaussian process tuned as a black box, the way of the thesis this project follows; for
// comparison with the likelihood and with select_model.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "repose/base/progress.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

struct TuningOptions {
  int evaluations = 50;  ///< cross-validations, each of `folds` fits; >= initial_points
  int initial_points = 4;
  int folds = 5;
  /// A group for each row; a fold takes groups whole. Empty: rows with equal x are one.
  std::vector<Eigen::Index> groups = {};
  std::uint64_t seed = 1;
  unsigned threads = 1;  ///< over folds; the result does not depend on it
  ProgressCallback progress = {};
};

/// One setting of [Hadi2026, Table C.4] and how well it predicts what is left out.
struct TuningTrial {
  Kernel kernel;
  Basis basis = Basis::constant;
  double noise_standard_deviation = 0.0;  ///< held fixed; [1e-4, max(1e-3, 10 sd)]
  /// The length scale of kernels that share one, held fixed, in units of the standardised or of the
  /// given inputs; [1e-3, 1] of their largest range. Kernels with one for each input ignore it and
  /// standardisation, and find theirs by the likelihood.
  double kernel_scale = 0.0;
  bool standardised = false;  ///< inputs by their standard deviations
  double rmse = 0.0;          ///< of the rows left out, over all folds
  std::string failure;        ///< why a fold could not be fitted; such a trial counts as bad
};

struct Tuning {
  GaussianProcess model;  ///< fitted to all rows with the setting of the best trial
  std::vector<TuningTrial> trials;
  std::size_t best = 0;  ///< the trial of smallest rmse as the optimiser's own model expects it
};

/// Searches basis, kernel, noise, kernel scale and standardisation by Bayesian optimisation:
/// expected improvement of the logarithm of the mean square error in k-fold cross-validation. Each
/// fit maximises the likelihood over what the setting leaves open. Kernel, basis, noise, estimator,
/// prior and bounds of `options` are not used. Throws InputError as GaussianProcess::fit, on fewer
/// than two folds, fewer groups or rows than folds, and if no trial could be fitted.
Tuning tune_model(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                  const GaussianProcessOptions& options = {}, const TuningOptions& tuning = {});

}  // namespace repose::surrogate

// Which inputs matter: Sobol' indices and partial dependence, of a Gaussian process with how
// certain they are.
#pragma once

#include <cstdint>
#include <vector>

#include "repose/surrogate/gaussian_process.hpp"
#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// Joint draws of the function at the rows of x (m x d): m x draws, natural units. Exact but for
/// what a pivoted Cholesky factor of the posterior covariance leaves over, a fraction of 1e-6 of
/// its trace (at most 1000 columns are kept; the rest is drawn independently) [Harbrecht2012]. O(m
/// n^2 + m k (n + k)), k columns.
Matrix joint_sample(const GaussianProcess& model, const Matrix& x, Eigen::Index draws,
                    std::uint64_t seed);

struct SensitivityOptions {
  Eigen::Index points = 1024;  ///< quasi-random base points; (d + 2) times as many are predicted
  /// Of the function; each uses its own bootstrap sample of the points.
  Eigen::Index draws = 200;
  std::uint64_t seed = 1;
};

/// A share of the variance, 0 to 1, and the central 95 % of what it may be. An estimate may leave
/// [0, 1] by its error.
struct SobolIndex {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};

struct InputSensitivity {
  SobolIndex first;  ///< of the input alone: Var E[y|x_k] / Var y
  SobolIndex total;  ///< with all its interactions: 1 - Var E[y|x_-k] / Var y
};

/// Of every input, all independent and uniform over their declared ranges (on their scale; over
/// levels). The function is drawn from the posterior, so that the intervals hold what the data
/// leave open, and the points are bootstrapped, so that they hold the error of integration
/// [LeGratiet2014]; estimators of [Janon2014] (first) and [Jansen1999] (total). Noise has no part.
/// All are NaN where the function does not vary.
std::vector<InputSensitivity> sobol_indices(const GaussianProcess& model,
                                            const SensitivityOptions& options = {});
/// Of any other model its means alone: the intervals hold the error of integration only.
std::vector<InputSensitivity> sobol_indices(const Regressor& model,
                                            const SensitivityOptions& options = {});

/// The mean response as a function of one input, over all others. Averages are of the modelled
/// response, brought back to natural units: where that is log y, they are geometric.
struct PartialDependence {
  std::vector<double> x;  ///< natural units, or levels
  std::vector<double> mean;
  std::vector<double> lower;  ///< central 95 %
  std::vector<double> upper;
};

struct PartialDependenceOptions {
  Eigen::Index points = 256;  ///< quasi-random, over the other inputs
  Eigen::Index grid = 21;     ///< values of the input, ends included; of a category, its levels
  std::uint64_t seed = 1;
};

PartialDependence partial_dependence(const GaussianProcess& model, Eigen::Index input,
                                     const PartialDependenceOptions& options = {});
/// Of any other model the mean alone; lower and upper are empty.
PartialDependence partial_dependence(const Regressor& model, Eigen::Index input,
                                     const PartialDependenceOptions& options = {});

}  // namespace repose::surrogate

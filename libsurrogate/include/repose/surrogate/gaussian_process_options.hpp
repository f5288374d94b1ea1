// What a Gaussian process is to be: kernel, trend, noise, and how its parameters are found.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "repose/opt/minimizer.hpp"
#include "repose/surrogate/kernel.hpp"

namespace repose::surrogate {

/// Of observations about the function. Numerical jitter is something else and is never tuned.
enum class Noise {
  none,       ///< the function itself is observed
  estimated,  ///< one variance for all observations
  known,      ///< a variance for each observation: GaussianProcessOptions::noise_variances
  /// A variance for each point from its repeats, drawn towards the pooled one: s~^2 = (w s0^2 +
  /// (r-1) s^2) / (w + r-1), w = GaussianProcessOptions::pooled_weight.
  by_point
};
const char* to_string(Noise noise);

/// Regression functions of the mean, of inputs scaled to [0, 1] (logarithms of inputs on a log
/// scale); coefficients by generalised least squares, their uncertainty in the variance. A category
/// that is not coded by label has an indicator for each level but the first and no square.
enum class Basis {
  none,
  constant,  ///< 1
  linear,    ///< 1, u_1 ... u_d
  quadratic  ///< 1, u_1 ... u_d, u_1^2 ... u_d^2
};
const char* to_string(Basis basis);
Basis basis_named(std::string_view name);

/// Regression functions of the user, added to those of the basis: another model's prediction, a
/// law of physics.
struct BasisFunctions {
  std::vector<std::string> names = {};
  /// names.size() finite values at x (d inputs in natural units). Called from one thread at a time
  /// when fitting, from those of the caller when predicting.
  std::function<Vector(const Vector& x)> evaluate = nullptr;
};

enum class Estimator {
  ml,    ///< likelihood maximised over coefficients and amplitude too
  reml,  ///< restricted: coefficients integrated out
  loo    ///< sum of the log predictive densities of left-out points [Sundararajan2001]
};
const char* to_string(Estimator estimator);
/// On length scales and noise ratio: jointly robust [Gu2019] keeps off the degenerate fits R -> I
/// and R -> 1. A second search follows, with the length scales of inert inputs held and a weaker
/// prior on the others; the model that better predicts left-out points is kept.
enum class Prior { none, jointly_robust };

/// Whether predictions know that the hyper-parameters were estimated from the same data.
enum class ParameterUncertainty {
  ignored,  ///< taken as known
  /// Their posterior as a Gaussian, its effect on the mean to first order: variances grow, those of
  /// noise found in closed form too, means stay. Not with Estimator::loo, which is no likelihood.
  first_order
};
const char* to_string(ParameterUncertainty uncertainty);

/// What is modelled: y, log y (y > 0) or log(y/(1-y)) (0 < y < 1). Predictions are mean and
/// variance of y.
enum class ResponseScale { linear, log, logit };
const char* to_string(ResponseScale scale);

/// Where a hyper-parameter may be, in its natural unit; lower == upper fixes it. Names and default
/// ranges as in FitReport::parameters; "process_variance" and "noise_variance" may be given instead
/// of "noise_ratio".
struct ParameterBounds {
  std::string name;
  double lower = 0.0;
  double upper = 0.0;
};

struct GaussianProcessOptions {
  Kernel kernel = {};
  Noise noise = Noise::estimated;
  Vector noise_variances = {};  ///< Noise::known: of each row, in squared units of y, > 0
  double pooled_weight = 6.0;   ///< Noise::by_point: degrees of freedom of the pooled variance
  Basis basis = Basis::constant;
  BasisFunctions functions = {};
  ResponseScale response_scale = ResponseScale::linear;
  Estimator estimator = Estimator::reml;
  Prior prior = Prior::jointly_robust;
  /// An evaluation more for each parameter, and a prediction costs some n d more.
  ParameterUncertainty parameter_uncertainty = ParameterUncertainty::first_order;
  std::vector<ParameterBounds> bounds = {};  ///< of parameters that are not free
  /// The best of a grid at each of three noise ratios, where noise is searched for; the others
  /// around the best of those.
  int starts = 5;
  std::uint64_t seed = 1;
  unsigned threads =
      1;  ///< over starts; the result does not depend on it (0: one for each processor)
  /// Of the negative log posterior over log parameters, with gradient. A curvature of 1 where none
  /// is known lets the first steps reach over small basins (docs/decisions/0007).
  opt::Minimizer minimizer = opt::BuiltinMinimizer{{.relative_x_tolerance = 1e-7,
                                                    .relative_f_tolerance = 1e-10,
                                                    .max_evaluations = 500,
                                                    .initial_curvature = 1.0}};
};

}  // namespace repose::surrogate

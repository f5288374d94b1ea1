// What a fit of a Gaussian process and its validation say.
#pragma once

#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::surrogate {

enum class ParameterState { converged, at_lower_bound, at_upper_bound, inert, fixed };
const char* to_string(ParameterState state);

/// A hyper-parameter with the bounds it had. Names:
/// - "length_scale_1" ... in units of their input (of its natural logarithm on a log scale);
///   "length_scale_2_3" is that of the third level of a one-hot category; "length_scale" is shared
///   by all inputs, in units of their ranges;
/// - "alpha" of the rational quadratic;
/// - "noise_ratio", noise variance / process variance, the process variance then being found in
///   closed form; or "process_variance" and "noise_variance", in squared units of y, where one of
///   them was bounded or noise variances were given.
struct FittedParameter {
  std::string name;
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  ParameterState state = ParameterState::converged;
  /// Length scales: P_k = s (C_k/l_k) / sum_i (C_i/l_i), C_k the mean distance in input k, s the
  /// number of scales; inert below 0.1 [Gu2019]. Else 1.
  double relevance = 1.0;
};

/// How the fit went.
struct FitReport {
  std::vector<FittedParameter> parameters;
  opt::Termination termination = opt::Termination::converged;
  std::string message;
  int evaluations = 0;
  double seconds = 0.0;
  /// For which processors the loops were compiled, "x86-64" or "x86-64-v3": the same data give
  /// the same bits with the same of them.
  std::string instruction_set;
  double jitter = 0.0;  ///< added to the correlation matrix' diagonal; 0 where not needed
};

/// Everything about the covariance, in natural units.
struct Hyperparameters {
  Vector length_scales;  ///< one each, or the shared one in units of the ranges
  double process_variance = 1.0;
  double noise_variance = 0.0;  ///< not used where the variances are known
  double alpha = 1.0;           ///< of the rational quadratic
};

/// Predictions of each row by the model without the rows of its group (its point, when single
/// points are left out), hyper-parameters fixed, trend re-estimated; vectors in order of the rows.
/// Undefined rows (that alone determine a regression coefficient) are NaN and not counted in the
/// figures.
struct LeftOut {
  Vector predicted;  ///< mean
  Vector variance;   ///< of an observation there, noise included
  Vector residual;   ///< observed - predicted
  double q2 = 0.0;   ///< 1 - sum residual^2 / sum (y - mean y)^2
  double rmse = 0.0;
  double coverage95 = 0.0;  ///< fraction of rows within their central 95 % interval
  /// Sum over groups of the log density of their observations, together, given all others;
  /// infinite where the trend explains the response.
  double log_density = 0.0;
  /// The rows of each group and the covariance of their residuals (of the transformed response
  /// where it is modelled on a log or logit scale); empty where undefined.
  struct Group {
    std::vector<Eigen::Index> rows;
    Matrix covariance;
  };
  std::vector<Group> groups;
};

}  // namespace repose::surrogate

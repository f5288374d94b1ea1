// Gaussian process regression (universal kriging) with likelihood-fitted length scales, amplitude
// and noise.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "repose/base/gaussian.hpp"
#include "repose/base/parameter_space.hpp"
#include "repose/opt/minimizer.hpp"
#include "repose/opt/objective.hpp"

namespace repose::surrogate {

/// Stationary, one length scale for each input; r^2 = sum_k (dx_k/l_k)^2, radial (not a product of
/// 1-d kernels).
enum class Kernel {
  squared_exponential,  ///< exp(-r^2/2)
  matern52              ///< (1 + sqrt5 r + 5 r^2/3) exp(-sqrt5 r)
};
/// "ard-squared-exponential", "ard-matern52".
const char* to_string(Kernel kernel);
/// Throws InputError listing the names.
Kernel kernel_named(std::string_view name);

/// Of observations about the function. Numerical jitter is something else and is never tuned.
enum class Noise { none, estimated };
/// Regression functions of the mean; coefficients by generalised least squares, their uncertainty
/// in the variance.
enum class Basis { none, constant };
enum class Estimator {
  ml,   ///< likelihood maximised over coefficients and amplitude too
  reml  ///< restricted: coefficients integrated out
};
/// On length scales and noise ratio: jointly robust [Gu2019] keeps off the degenerate fits R -> I
/// and R -> 1.
enum class Prior { none, jointly_robust };

struct GaussianProcessOptions {
  Kernel kernel = Kernel::matern52;
  Noise noise = Noise::estimated;
  Basis basis = Basis::constant;
  Estimator estimator = Estimator::reml;
  Prior prior = Prior::jointly_robust;
  int starts = 5;  ///< the best of a grid, and starts - 1 around it
  std::uint64_t seed = 1;
  unsigned threads =
      1;  ///< over starts; the result does not depend on it (0: one for each processor)
  /// Of the negative log posterior over log parameters, with gradient.
  opt::Minimizer minimizer = opt::NloptMinimizer{
      {.relative_x_tolerance = 1e-7, .relative_f_tolerance = 1e-10, .max_evaluations = 500}};
};

enum class ParameterState { converged, at_lower_bound, at_upper_bound, inert };
const char* to_string(ParameterState state);

/// A hyper-parameter that was searched for, with the bounds it had. Length scales are in units of
/// their input, "noise_ratio" is noise variance / process variance.
struct FittedParameter {
  std::string name;  ///< "length_scale_1" ... , "noise_ratio"
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
  ParameterState state = ParameterState::converged;
  /// Length scales: P_k = d (C_k/l_k) / sum_i (C_i/l_i), C_k the mean distance in input k; inert
  /// below 0.1 [Gu2019]. Else 1.
  double relevance = 1.0;
};

/// How the fit went.
struct FitReport {
  std::vector<FittedParameter> parameters;
  opt::Termination termination = opt::Termination::converged;
  std::string message;
  int evaluations = 0;
  double seconds = 0.0;
  double jitter = 0.0;  ///< added to the correlation matrix' diagonal; 0 where not needed
};

/// Everything about the covariance, in natural units.
struct Hyperparameters {
  Vector length_scales;
  double process_variance = 1.0;
  double noise_variance = 0.0;
};

/// Predictions of each row by the model without any row of the same x, hyper-parameters fixed,
/// trend re-estimated; vectors in order of the rows. Undefined rows (that alone determine a
/// regression coefficient) are NaN and not counted in the figures.
struct LeaveOneOut {
  Vector predicted;  ///< mean
  Vector variance;   ///< of an observation there, noise included
  Vector residual;   ///< observed - predicted
  double q2 = 0.0;   ///< 1 - sum residual^2 / sum (y - mean y)^2
  double rmse = 0.0;
  double coverage95 = 0.0;  ///< fraction of rows within 1.96 standard deviations
};

/// A fitted model; never unfitted. Cheap to copy (shares its immutable state), safe to use from
/// several threads.
class GaussianProcess {
 public:
  /// x: n x d in natural units, y: n values. Inputs are scaled by `declared`, the range of the
  /// parameters, not by the data. Rows with equal x are repeats. Bounds of the search: length
  /// scales [0.02, 1e5] of the range, noise ratio [1e-14, 1e4]. A constant y gives amplitude 0:
  /// that constant, without doubt. Throws InputError naming row and column on values that are not
  /// finite, on fewer different points than coefficients + 1, on bounds with lower >= upper, and
  /// without noise on repeats that differ.
  static GaussianProcess fit(const Matrix& x, const Vector& y, const opt::Bounds& declared,
                             const GaussianProcessOptions& options = {});
  /// The same with given hyper-parameters: nothing is searched for.
  static GaussianProcess with_parameters(const Matrix& x, const Vector& y,
                                         const opt::Bounds& declared,
                                         const Hyperparameters& parameters,
                                         const GaussianProcessOptions& options = {});

  Eigen::Index dimension() const;
  Eigen::Index rows() const;  ///< observations, repeats counted

  /// Of the function at x (length d; rows: m x d), natural units; add noise_variance() for an
  /// observation. One point and rows agree to rounding. predict_rows costs O(n^2) a row, in blocks.
  Gaussian predict(const Vector& x) const;
  std::vector<Gaussian> predict_rows(const Matrix& x) const;

  /// The model told y at x too, everything else kept: O(n^2), O(n^3) where x is a repeat.
  GaussianProcess condition_on(const Vector& x, double y) const;

  Hyperparameters hyperparameters() const;
  double noise_variance() const;
  /// Regression coefficients in natural units of y; constant: the mean.
  Vector coefficients() const;
  const opt::Bounds& declared_bounds() const;
  Kernel kernel() const;
  Noise noise() const;
  Basis basis() const;
  Estimator estimator() const;
  /// Of the data at these hyper-parameters, 2 pi included, prior excluded. ml: at the coefficients
  /// of generalised least squares. reml: restricted, not comparable between bases.
  double negative_log_likelihood() const;
  LeaveOneOut leave_one_out() const;
  const FitReport& report() const;

 private:
  struct State;
  explicit GaussianProcess(std::shared_ptr<const State> state);
  friend struct ModelAccess;  // reads and rebuilds the state for model files
  std::shared_ptr<const State> state_;
};

}  // namespace repose::surrogate

// Nonlinear least squares inside a box, plain or robust: curves through measurements, with the
// uncertainty of their parameters. Component `least_squares`, which needs Ceres.
#pragma once

#include <functional>
#include <string>

#include "repose/opt/minimizer.hpp"

namespace repose::opt {

/// The n residuals at x (length d), always as many. Where `jacobian` is not null it is n x d and is
/// filled in with dr_i/dx_k; asked for with Derivatives::analytic only. Residuals that are not
/// finite mean "not here".
using Residuals = std::function<Vector(const Vector& x, Matrix* jacobian)>;

enum class Derivatives {
  analytic,  ///< by the residuals
  numeric    ///< central differences inside the bounds, relative error about 1e-10
};

/// rho(s) of s = (r/scale)^2, how a residual counts; rho(s) = s for small s.
enum class Loss {
  none,    ///< s
  huber,   ///< s below 1, then 2 sqrt(s) - 1: outliers pull with constant force
  cauchy,  ///< log(1 + s): outliers far away hardly pull
  soft_l1  ///< 2 (sqrt(1 + s) - 1), huber without the seam
};

struct LeastSquaresOptions {
  Derivatives derivatives = Derivatives::numeric;
  Loss loss = Loss::none;
  double loss_scale = 1.0;  ///< residuals above it are outliers; in units of r, > 0
  /// Stop when the cost falls by less than this of itself.
  double relative_f_tolerance = 1e-18;
  /// Stop when a step is shorter than this of |x|.
  double relative_x_tolerance = 1e-12;
  int max_evaluations = 5000;  ///< of the residuals, those for differences included; >= 1
};

struct LeastSquaresResult {
  Vector x;           ///< inside the bounds
  double cost = 0.0;  ///< scale^2/2 sum rho((r/scale)^2), without loss sum r^2/2
  Vector residuals;   ///< at x
  Termination termination = Termination::failed;
  std::string message;  ///< one sentence
  int evaluations = 0;
  double seconds = 0.0;
  /// d x d: s^2 (J'WJ)^-1 over the parameters off their bounds, zero in the others, with
  /// W = diag rho' and s^2 = sum W r^2/(n - p). First order in the residuals; with a loss it takes
  /// the weights for given. 0 x 0 where it is not defined.
  Matrix covariance;
  std::string no_covariance;  ///< why it is not defined, else empty
};

/// The smallest cost found from `start`, which is first projected onto the bounds, by the
/// trust-region method of Levenberg and Marquardt [Ceres]. May be called from several threads at
/// once. Throws InputError on bad bounds, start, options or a Jacobian of another shape, and where
/// the number of residuals changes; exceptions of `residuals` pass.
LeastSquaresResult fit_least_squares(const Residuals& residuals, const Vector& start,
                                     const Bounds& bounds, const LeastSquaresOptions& options = {});

}  // namespace repose::opt

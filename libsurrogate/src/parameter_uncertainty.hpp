// What the data leave open of the hyper-parameters, and what that adds to a prediction's variance.
//
// To first order in the log parameters: with posterior covariance S of these and D(x) the
// derivatives of the mean, m(x) varies by D^T S D, and the variance that estimated parameters
// flatter grows by the freedom which they took [Zimmerman1992], [Abt1999].
#pragma once

#include "likelihood.hpp"

namespace repose::surrogate {

/// How many parameters shape the covariance: rows of ParameterPosterior::root.
inline Eigen::Index shape_parameters(const Dataset& data, const Covariance& c) {
  return data.encoding.scales() + (c.correlation == Correlation::rational_quadratic ? 1 : 0) + 1;
}

/// Of the s parameters that shape the covariance, in this order: log length scales; log alpha, for
/// the rational quadratic; log noise ratio. All that are bounded to a point, or sit on a bound,
/// count as known.
struct ParameterPosterior {
  Matrix root;  ///< s x r: their covariance is root root^T; empty where all is taken as known
  /// Of the process variance and the noise, where these are found in closed form: with nu =
  /// observations less coefficients and what was spent on the shape, predictions have a t
  /// distribution whose variance is squares/(nu - 2). 1 else.
  double variance_factor = 1.0;
};

struct Freedom {
  double observations = 0.0;
  double coefficients = 0.0;
  Estimator estimator = Estimator::reml;

  /// What the process variance is a sum of squares divided by.
  double divisor() const {
    return estimator == Estimator::reml ? observations - coefficients : observations;
  }
};

/// Gaussian approximation at the mode p of exp(-objective), whose Hessian H comes from differences
/// of gradients (an evaluation for each free parameter); times a vague Gaussian prior of standard
/// deviation 2, which says that a log parameter the data do not determine is known to a factor of
/// some tens: (H + I/4)^-1. Spent are tr H (H + I/4)^-1.
ParameterPosterior approximate_posterior(const NegativeLogPosterior& objective, const Vector& p,
                                         const opt::Bounds& bounds, const Freedom& freedom);

/// E(x) = root^T dm(x)/d(log parameters), so that E^T E is added to a prediction's variance.
class MeanSensitivity {
 public:
  MeanSensitivity() = default;
  /// O(n^2 (p + r)). In units of `unit` (of the standardised response).
  MeanSensitivity(const Dataset& data, const Covariance& covariance, const Factor& factor,
                  const Matrix& root, double unit);

  Eigen::Index directions() const { return root_.cols(); }  ///< r; 0 where all is known
  /// r x m at m points: encoded ones q (m x p), their regression functions h (m x q), and
  /// correlations k with their slopes (n x m).
  Matrix at(const Dataset& data, const Correlator& correlator, const Vector& alpha, const Matrix& q,
            const Matrix& h, const CrossCorrelation& k) const;
  /// d(E^T E)/du, u the p coordinates, at one point where E is e; what h contributes is left to
  /// by_trend(e), d(E^T E)/dh.
  Vector squared_by_coordinates(const Dataset& data, const Correlator& correlator,
                                const Vector& alpha, const Matrix& q, const CrossCorrelation& k,
                                const Vector& e) const;
  Vector squared_by_trend(const Vector& e) const { return -2.0 * by_trend_ * e; }

 private:
  Matrix root_;            // s x r, in the unit
  Matrix by_correlation_;  // n x r: Q dC a root
  Matrix by_trend_;        // q x r: (H^T C^-1 H)^-1 H^T C^-1 dC a root
};

}  // namespace repose::surrogate

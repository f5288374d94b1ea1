// The factored covariance of the data and the generalised least squares that rests on it.
#pragma once

#include <optional>

#include "correlation.hpp"
#include "dataset.hpp"

namespace repose::surrogate {

/// Covariance in the units of the dataset: amplitude * (R + noise_ratio diag(v)), v the noise
/// weights of the dataset.
struct Covariance {
  Correlation correlation = Correlation::matern52;
  Vector length_scales;  ///< in units of the encoded coordinates
  double noise_ratio = 0.0;
  double alpha = 1.0;
  Correlator correlator(const Encoding& encoding) const {
    return {correlation, alpha, encoding.weights(length_scales)};
  }
};

/// C = L L^T = R + noise_ratio diag(v) + jitter I and, with W = L^-1, W H = Q1 U (thin QR):
/// beta = U^-1 Q1^T W y, residual e = W y - W H beta. [Rasmussen2006, algorithm 2.1 and
/// section 2.7]
struct Factor {
  Matrix l;  ///< n x n, lower triangle
  double jitter = 0.0;
  Matrix q1;                     ///< n x q
  Matrix u;                      ///< q x q, upper triangle
  Vector beta;                   ///< q
  Vector residual;               ///< e, n
  Vector alpha;                  ///< L^-T e = Q y, n
  double log_det() const;        ///< log |C|
  double log_det_trend() const;  ///< log |H^T C^-1 H|
};

/// Cholesky factor of `lower` (diagonal included) with the smallest jitter of 0, 1e-12, 1e-11 ...
/// 1e-6 for which every pivot stands clear of rounding; nothing if none does or a value is not
/// finite.
struct Cholesky {
  Matrix l;
  double jitter = 0.0;
};
/// `storage` is used again for the factor: large matrices are costly to allocate.
std::optional<Cholesky> factorise(const Matrix& lower, Matrix storage = {});

/// What follows from the Cholesky factor.
Factor complete(const Dataset& data, Cholesky cholesky);

/// Throws NumericalError where no jitter helps.
Factor make_factor(const Dataset& data, const Covariance& covariance);

/// L^-1, lower triangle, zeros above.
Matrix lower_inverse(const Matrix& l);
/// Lower triangle of C^-1 from L^-1; the rest is left undefined.
Matrix inverse_from(const Matrix& l_inverse);

/// Observations that count: those of a point are one without noise.
double effective_observations(const Dataset& data, double noise_ratio);

/// Of the data given amplitude sigma^2, 2 pi included; in units of the dataset.
double negative_log_likelihood(const Dataset& data, const Factor& factor, double noise_ratio,
                               double amplitude, Estimator estimator);
/// The amplitude that makes it smallest.
double best_amplitude(const Dataset& data, const Factor& factor, double noise_ratio,
                      Estimator estimator);

}  // namespace repose::surrogate

// The objective of a fit: negative log likelihood with the amplitude profiled out, plus prior, over
// log parameters.
#pragma once

#include "factor.hpp"

namespace repose::surrogate {

/// Log parameters are log length scales (units of the declared range) and, with noise, log noise
/// ratio.
class NegativeLogPosterior {
 public:
  NegativeLogPosterior(const Dataset& data, const GaussianProcessOptions& options);

  /// +infinity where the covariance cannot be factored. Cost O(n^3 + n^2 d). Thread-safe.
  double operator()(const Vector& log_parameters, Vector* gradient) const;

  Eigen::Index size() const { return data_.dimension() + (has_noise() ? 1 : 0); }
  Covariance covariance(const Vector& log_parameters) const;
  /// C_k: mean distance of two points in input k.
  const Vector& mean_distance() const { return mean_distance_; }

 private:
  bool has_noise() const { return noise_ == Noise::estimated; }
  void add_likelihood_gradient(const Covariance& c, const Factor& f, const Matrix& slope,
                               double amplitude, Vector& gradient) const;
  double prior(const Covariance& c, Vector* gradient) const;

  const Dataset& data_;
  Kernel kernel_;
  Noise noise_;
  Basis basis_;
  Estimator estimator_;
  Prior prior_;
  Vector mean_distance_;
};

}  // namespace repose::surrogate

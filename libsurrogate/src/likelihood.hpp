// The objective of a fit: a negative log likelihood or leave-one-out density, plus prior, over log
// parameters.
#pragma once

#include "factor.hpp"

namespace repose::surrogate {

/// Whether the process variance is found in closed form for given other parameters (never bounded,
/// never penalised), or is a parameter itself.
enum class Amplitude { profiled, searched };

/// Of the jointly robust prior against short length scales, see prior().
enum class PriorRate {
  of_all,   ///< that of [Gu2019]
  by_scale  ///< the weaker
};

/// Log parameters are, in this order: log length scales (units of the coordinates); log alpha, for
/// the rational quadratic; then, in units of the dataset,
/// - amplitude profiled: log noise ratio, where the noise is estimated;
/// - amplitude searched: log process variance and, where the noise is estimated, log noise
///   variance. Known noise variances are in the dataset: their noise ratio is 1/process variance.
class NegativeLogPosterior {
 public:
  NegativeLogPosterior(const Dataset& data, const GaussianProcessOptions& options,
                       Amplitude amplitude = Amplitude::profiled,
                       PriorRate prior_rate = PriorRate::of_all);

  /// +infinity where the covariance cannot be factored. Flops: n^3/3 for the value, n^3 with the
  /// gradient (Cholesky factor, its inverse, their product), loo n^3/3 and 2 n^3; and 3/2 n^2 p for
  /// the coordinates, twice with the gradient. Memory: five n x n matrices. Thread-safe.
  double operator()(const Vector& log_parameters, Vector* gradient) const;

  Eigen::Index size() const { return noise_parameter() + (estimates_noise() ? 1 : 0); }
  Eigen::Index amplitude_parameter() const {
    return data_.encoding.scales() + (has_alpha() ? 1 : 0);
  }
  Eigen::Index noise_parameter() const {
    return amplitude_parameter() + (searches_amplitude() ? 1 : 0);
  }
  bool has_alpha() const { return correlation_ == Correlation::rational_quadratic; }
  bool searches_amplitude() const { return amplitude_ == Amplitude::searched; }
  bool estimates_noise() const { return noise_ == Noise::estimated; }

  Covariance covariance(const Vector& log_parameters) const;
  /// Searched, or best for this factored covariance.
  double amplitude(const Vector& log_parameters, const Covariance& c, const Factor& factor) const;
  /// C_k: mean distance of two points in the coordinates of each length scale.
  const Vector& mean_distance() const { return mean_distance_; }

 private:
  struct LeftOut {
    Vector q;              ///< diagonal of Q; 0 where the point alone determines a coefficient
    double points = 0.0;   ///< others
    double squares = 0.0;  ///< sum (Qy)_i^2/Q_ii
  };
  /// Kept by each thread from one evaluation to the next: fresh pages for five n x n matrices would
  /// cost as much as the evaluation.
  struct Evaluation {
    Covariance c;
    Factor f;
    Matrix lower;
    Matrix slope;
    Matrix alpha_slope;
    Matrix l_inverse;
    Matrix inverse;  ///< of C, lower triangle
    LeftOut left_out;
    double amplitude = 0.0;
  };
  LeftOut leave_out(const Factor& f, const Matrix& l_inverse) const;
  double within(const Covariance& c) const;
  double left_out_observations(const Covariance& c, const LeftOut& out) const;
  double amplitude(const Vector& p, const Covariance& c, const Factor& f, const LeftOut& out) const;
  double value(const Evaluation& e) const;
  double by_log_amplitude(const Evaluation& e) const;
  const Matrix& twice_sensitivity(Evaluation& e) const;
  void add_gradient(Evaluation& e, double prior_by_noise, Vector& gradient) const;
  double prior(const Covariance& c, Vector* gradient, double& by_noise) const;

  const Dataset& data_;
  Correlation correlation_;
  Noise noise_;
  Estimator estimator_;
  Prior prior_;
  PriorRate prior_rate_;
  Amplitude amplitude_;
  Vector mean_distance_;
};

}  // namespace repose::surrogate

#include "likelihood.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "correlation.hpp"

namespace repose::surrogate {
namespace {

Vector mean_distances(const Matrix& x) {
  Vector sum = Vector::Zero(x.cols());
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    for (Eigen::Index j = 0; j < x.rows(); ++j)
      for (Eigen::Index i = j + 1; i < x.rows(); ++i) sum[k] += std::abs(x(i, k) - x(j, k));
  const auto n = static_cast<double>(x.rows());
  return sum / std::max(1.0, 0.5 * n * (n - 1.0));
}

}  // namespace

NegativeLogPosterior::NegativeLogPosterior(const Dataset& data,
                                           const GaussianProcessOptions& options)
    : data_(data),
      kernel_(options.kernel),
      noise_(options.noise),
      basis_(options.basis),
      estimator_(options.estimator),
      prior_(options.prior),
      mean_distance_(mean_distances(data.x)) {}

Covariance NegativeLogPosterior::covariance(const Vector& log_parameters) const {
  const Eigen::Index d = data_.dimension();
  return {kernel_, log_parameters.head(d).array().exp(),
          has_noise() ? std::exp(log_parameters[d]) : 0.0};
}

double NegativeLogPosterior::operator()(const Vector& log_parameters, Vector* gradient) const {
  const Covariance c = covariance(log_parameters);
  const Eigen::Index n = data_.points();
  Matrix lower(n, n);
  Matrix slope(gradient != nullptr ? n : 0, gradient != nullptr ? n : 0);
  fill_correlation(kernel_, data_.x, c.length_scales, lower,
                   gradient != nullptr ? &slope : nullptr);
  lower.diagonal().array() += c.noise_ratio / data_.count.array();
  std::optional<Cholesky> cholesky = factorise(lower);
  if (!cholesky) {
    if (gradient != nullptr) gradient->setZero();
    return std::numeric_limits<double>::infinity();
  }
  const Factor f = complete(data_, basis_, std::move(*cholesky));
  const double amplitude = best_amplitude(data_, f, c.noise_ratio, estimator_);
  const double value = negative_log_likelihood(data_, f, c.noise_ratio, amplitude, estimator_);
  if (gradient != nullptr) {
    gradient->setZero(size());
    add_likelihood_gradient(c, f, slope, amplitude, *gradient);
  }
  return prior_ == Prior::jointly_robust ? value + prior(c, gradient) : value;
}

/// d/dphi = (tr(M dC) - a^T dC a / sigma^2) / 2 with a = Q y and M = Q (reml) or C^-1 (ml): one
/// pass over the pairs i > j for all length scales.
void NegativeLogPosterior::add_likelihood_gradient(const Covariance& c, const Factor& f,
                                                   const Matrix& slope, double amplitude,
                                                   Vector& gradient) const {
  const Eigen::Index n = data_.points();
  const Eigen::Index d = data_.dimension();
  const Matrix l_inverse = lower_inverse(f.l);
  Matrix m = inverse_from(l_inverse);
  if (estimator_ == Estimator::reml && f.q1.cols() > 0) {
    const Matrix b = l_inverse.transpose() * f.q1;  // Q = C^-1 - B B^T
    m.triangularView<Eigen::Lower>() -= b * b.transpose();
  }
  const Vector a = f.alpha / std::sqrt(amplitude);
  std::vector<double> coefficient(static_cast<std::size_t>(n));
  Vector sums = Vector::Zero(d);
  for (Eigen::Index j = 0; j + 1 < n; ++j) {
    const Eigen::Index below = n - 1 - j;
    const double* mj = m.data() + j * n + j + 1;
    const double* sj = slope.data() + j * n + j + 1;
    const double* ai = a.data() + j + 1;
    for (Eigen::Index i = 0; i < below; ++i)
      coefficient[static_cast<std::size_t>(i)] = (mj[i] - ai[i] * a[j]) * sj[i];
    for (Eigen::Index k = 0; k < d; ++k)
      sums[k] += weighted_square_sum(data_.x.data() + k * n + j + 1, below, data_.x(j, k),
                                     coefficient.data());
  }
  gradient.head(d).array() += sums.array() / c.length_scales.array().square();
  if (!has_noise()) return;
  const double repeats = static_cast<double>(data_.observations() - n);
  const double trace = ((m.diagonal().array() - a.array().square()) / data_.count.array()).sum();
  gradient[d] +=
      0.5 * (c.noise_ratio * trace + repeats - data_.within / (c.noise_ratio * amplitude));
}

/// -log pi, log pi = a log t - b t, t = sum_k C_k / l_k + noise ratio, a = 0.2, b = n^(-1/d) (a +
/// d) [Gu2019], in its own parameters: no Jacobian of the logarithms.
double NegativeLogPosterior::prior(const Covariance& c, Vector* gradient) const {
  const Eigen::Index d = data_.dimension();
  const auto dimension = static_cast<double>(d);
  constexpr double kA = 0.2;
  const double b =
      std::pow(static_cast<double>(data_.points()), -1.0 / dimension) * (kA + dimension);
  const Vector part = mean_distance_.array() / c.length_scales.array();
  const double t = part.sum() + c.noise_ratio;
  if (gradient != nullptr) {
    const double slope = kA / t - b;
    gradient->head(d) += slope * part;
    if (has_noise()) (*gradient)[d] -= slope * c.noise_ratio;
  }
  return b * t - kA * std::log(t);
}

}  // namespace repose::surrogate

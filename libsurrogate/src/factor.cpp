#include "factor.hpp"

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <numbers>

#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

double degrees_of_freedom(const Dataset& data, const Factor& factor, double noise_ratio,
                          Estimator estimator) {
  return effective_observations(data, noise_ratio) -
         (estimator == Estimator::reml ? static_cast<double>(factor.beta.size()) : 0.0);
}

/// y^T Q y, with the squares within repeats: N degrees of freedom less those of the trend.
double sum_of_squares(const Dataset& data, const Factor& factor, double noise_ratio) {
  const double within = noise_ratio > 0.0 ? data.within / noise_ratio : 0.0;
  return factor.residual.squaredNorm() + within;
}

}  // namespace

double Factor::log_det() const {
  return 2.0 * l.diagonal().array().log().sum();
}
double Factor::log_det_trend() const {
  return 2.0 * u.diagonal().array().abs().log().sum();
}

std::optional<Cholesky> factorise(const Matrix& lower, Matrix storage) {
  if (!lower.diagonal().allFinite()) return std::nullopt;
  const double clear = 10.0 * std::numeric_limits<double>::epsilon() * lower.diagonal().maxCoeff();
  Cholesky result{std::move(storage)};
  for (int exponent = -15; exponent <= -6; ++exponent) {
    result.jitter = exponent == -15 ? 0.0 : std::pow(10.0, exponent);
    result.l = lower;
    result.l.diagonal().array() += result.jitter;
    if (!dense().cholesky(result.l.data(), result.l.rows())) continue;
    const double smallest = result.l.diagonal().minCoeff();
    if (smallest * smallest >= clear) return result;
  }
  return std::nullopt;
}

Factor complete(const Dataset& data, Cholesky cholesky) {
  Factor f;
  f.l = std::move(cholesky.l);
  f.jitter = cholesky.jitter;
  const auto l = f.l.triangularView<Eigen::Lower>();
  const Vector wy = l.solve(data.y);
  const Eigen::Index q = data.h.cols();
  f.u.resize(q, q);
  f.beta.resize(q);
  f.q1.resize(data.points(), q);
  f.residual = wy;
  if (q > 0) {
    const Matrix wh = l.solve(data.h);
    const Eigen::HouseholderQR<Matrix> qr(wh);
    f.q1 = qr.householderQ() * Matrix::Identity(data.points(), q);
    f.u = qr.matrixQR().topRows(q).triangularView<Eigen::Upper>();
    const Vector projected = f.q1.transpose() * wy;
    f.beta = f.u.triangularView<Eigen::Upper>().solve(projected);
    f.residual -= f.q1 * projected;
  }
  f.alpha = f.l.transpose().triangularView<Eigen::Upper>().solve(f.residual);
  return f;
}

Factor make_factor(const Dataset& data, const Covariance& covariance) {
  Matrix lower = Matrix::Zero(data.points(), data.points());
  fill_correlation(covariance.correlator(data.encoding), data.x, lower);
  lower.diagonal().array() += covariance.noise_ratio * data.noise.array();
  std::optional<Cholesky> cholesky = factorise(lower);
  if (!cholesky)
    throw NumericalError(
        "the covariance matrix of the training points cannot be factored even with a jitter of "
        "1e-6: "
        "remove points that almost coincide, shorten the length scales or estimate noise");
  return complete(data, std::move(*cholesky));
}

Matrix lower_inverse(const Matrix& l) {
  Matrix p(l.rows(), l.cols());
  dense().lower_inverse(l.data(), l.rows(), p.data());
  return p;
}

Matrix inverse_from(const Matrix& l_inverse) {
  Matrix c(l_inverse.rows(), l_inverse.cols());
  dense().inverse_from(l_inverse.data(), c.rows(), c.data());
  return c;
}

double effective_observations(const Dataset& data, double noise_ratio) {
  return static_cast<double>(noise_ratio > 0.0 ? data.observations() : data.points());
}

double best_amplitude(const Dataset& data, const Factor& factor, double noise_ratio,
                      Estimator estimator) {
  return sum_of_squares(data, factor, noise_ratio) /
         degrees_of_freedom(data, factor, noise_ratio, estimator);
}

double negative_log_likelihood(const Dataset& data, const Factor& factor, double noise_ratio,
                               double amplitude, Estimator estimator) {
  const double freedom = degrees_of_freedom(data, factor, noise_ratio, estimator);
  double twice = freedom * std::log(2.0 * std::numbers::pi * amplitude) +
                 sum_of_squares(data, factor, noise_ratio) / amplitude + factor.log_det();
  if (noise_ratio > 0.0)  // without noise, repeats say nothing new
    twice += static_cast<double>(data.observations() - data.points()) * std::log(noise_ratio) +
             data.log_repeats;
  if (estimator == Estimator::reml) twice += factor.log_det_trend();
  return 0.5 * twice;
}

}  // namespace repose::surrogate

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace repose::surrogate {
namespace {

double negative_log_density(const Vector& residual, const Vector& variance) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < residual.size(); ++i)
    sum += 0.5 * (std::log(2.0 * std::numbers::pi * variance[i]) +
                  residual[i] * residual[i] / variance[i]);
  return sum / static_cast<double>(residual.size());
}

}  // namespace

Metrics metrics_of(const Vector& observed, const Vector& predicted, const Vector& variance) {
  const Eigen::Index n = observed.size();
  if (predicted.size() != n || (variance.size() != 0 && variance.size() != n))
    throw InputError(
        fmt::format("{} observations, {} predictions and {} variances; they must agree", n,
                    predicted.size(), variance.size()));
  Metrics m{.rows = n};
  if (n == 0) return m;
  const Vector residual = observed - predicted;
  const auto count = static_cast<double>(n);
  const double squares = residual.squaredNorm();
  m.rmse = std::sqrt(squares / count);
  m.mae = residual.cwiseAbs().sum() / count;
  const Vector y = observed.array() - observed.mean();
  const Vector p = predicted.array() - predicted.mean();
  if (observed.maxCoeff() > observed.minCoeff()) {
    m.r2 = 1.0 - squares / y.squaredNorm();
    if (predicted.maxCoeff() > predicted.minCoeff())
      m.squared_correlation = std::pow(y.dot(p), 2) / (y.squaredNorm() * p.squaredNorm());
  }
  if (variance.size() > 0) m.negative_log_density = negative_log_density(residual, variance);
  return m;
}

}  // namespace repose::surrogate

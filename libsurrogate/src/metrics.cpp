#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace repose::surrogate {
namespace {

/// Sum of (weighted) values.
double sum_of(const Vector& values, const Vector& weights) {
  return weights.size() > 0 ? values.dot(weights) : values.sum();
}

Vector negative_log_densities(const Vector& residual, const Vector& variance) {
  return 0.5 * ((2.0 * std::numbers::pi * variance.array()).log() +
                residual.array().square() / variance.array());
}

void check_length(const Vector& values, Eigen::Index rows, const char* what) {
  if (values.size() != 0 && values.size() != rows)
    throw InputError(fmt::format("{} {} for {} observations; there must be one for each",
                                 values.size(), what, rows));
}

}  // namespace

Metrics metrics_of(const Vector& observed, const Vector& predicted, const Vector& variance,
                   const Vector& weights) {
  const Eigen::Index n = observed.size();
  if (predicted.size() != n)
    throw InputError(fmt::format("{} predictions of {} observations; there must be one for each",
                                 predicted.size(), n));
  check_length(variance, n, "variances");
  check_length(weights, n, "weights");
  Metrics m{.rows = n};
  if (n == 0) return m;
  const Vector residual = observed - predicted;
  const double count = weights.size() > 0 ? weights.sum() : static_cast<double>(n);
  const double squares = sum_of(residual.cwiseAbs2(), weights);
  m.rmse = std::sqrt(squares / count);
  m.mae = sum_of(residual.cwiseAbs(), weights) / count;
  const Vector y = observed.array() - sum_of(observed, weights) / count;
  const Vector p = predicted.array() - sum_of(predicted, weights) / count;
  if (observed.maxCoeff() > observed.minCoeff()) {
    const double y_squares = sum_of(y.cwiseAbs2(), weights);
    m.r2 = 1.0 - squares / y_squares;
    if (predicted.maxCoeff() > predicted.minCoeff())
      m.squared_correlation = std::pow(sum_of(y.cwiseProduct(p), weights), 2) /
                              (y_squares * sum_of(p.cwiseAbs2(), weights));
  }
  if (variance.size() > 0)
    m.negative_log_density = sum_of(negative_log_densities(residual, variance), weights) / count;
  return m;
}

}  // namespace repose::surrogate

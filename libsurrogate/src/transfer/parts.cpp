#include "parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/surrogate/cross_validation.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"

namespace repose::surrogate {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kPointsForScale = 4;

/// What a source says of itself at some rows, means over them.
struct SourceVariances {
  double noise = 0.0;         ///< 0 where it does not tell
  double observation = kNaN;  ///< its own doubt included; NaN where it does not tell

  SourceVariances(const Regressor& source, const Matrix& x) {
    const Predictions p = source.predict_with_variances(x);
    if (p.observation_variance.size() == 0) return;
    if (const double mean = p.observation_variance.mean(); std::isfinite(mean)) observation = mean;
    if (p.function_variance.size() == 0) return;
    const double mean = (p.observation_variance - p.function_variance).mean();
    if (std::isfinite(mean)) noise = std::max(0.0, mean);
  }
};

Vector not_negative(const Vector& variance) {  // NaN stays
  return (variance.array() < 0.0).select(0.0, variance);
}

}  // namespace

ShiftedModel ShiftedModel::fit(const Regressor& source, const TrainingSet& target) {
  const Vector m = source.predict(target.x);
  const Vector& y = target.y;
  const Vector w = target.weights.size() > 0 ? target.weights : Vector(Vector::Ones(y.size()));
  const double n = w.sum();  // weights count as repeats
  const double m_mean = w.dot(m) / n, y_mean = w.dot(y) / n;
  ShiftedModel model{.source = source, .covariance = Matrix::Zero(2, 2)};
  const Vector centred = m.array() - m_mean;
  const double spread = w.dot(centred.cwiseAbs2());
  const bool scaled =
      number_of_points(target) >= kPointsForScale && spread > 1e-20 * w.dot(m.cwiseAbs2());
  if (scaled) model.scale = w.cwiseProduct(centred).dot(y) / spread;
  model.shift = y_mean - model.scale * m_mean;
  const Vector residual = y.array() - model.shift - model.scale * m.array();
  const double freedom = n - (scaled ? 2.0 : 1.0);
  const SourceVariances known(source, target.x);
  model.noise_variance = known.noise;
  model.residual_variance = freedom > 0.0
                                ? std::max(w.dot(residual.cwiseAbs2()) / freedom, known.noise)
                                : known.observation;
  model.covariance(0, 0) = model.residual_variance / n;
  if (scaled) {
    model.covariance(1, 1) = model.residual_variance / spread;
    model.covariance(0, 1) = model.covariance(1, 0) = -m_mean * model.covariance(1, 1);
    model.covariance(0, 0) += m_mean * m_mean * model.covariance(1, 1);
  }
  return model;
}

Vector ShiftedModel::predict(const Matrix& x) const {
  return shift + scale * source.predict(x).array();
}

Predictions ShiftedModel::predict_with_variances(const Matrix& x) const {
  const Predictions of_source = source.predict_with_variances(x);
  const Vector& m = of_source.mean;
  const Vector of_coefficients =
      covariance(0, 0) + 2.0 * covariance(0, 1) * m.array() + covariance(1, 1) * m.array().square();
  Vector function = not_negative(of_coefficients).array() + (residual_variance - noise_variance);
  if (of_source.function_variance.size() > 0)
    function += scale * scale * of_source.function_variance;
  return {shift + scale * m.array(), function, function.array() + noise_variance};
}

std::string ShiftedModel::describe() const {
  return fmt::format("{:.4g} + {:.4g} times the source", shift, scale);
}

BasisFunctions mean_function(const GaussianProcess& source) {
  return {.names = {"source"}, .evaluate = [source](const Vector& x) {
            return Vector::Constant(1, source.predict(x).mean);
          }};
}

SourceBasisProcess SourceBasisProcess::fit(const GaussianProcess& source, const TrainingSet& target,
                                           std::uint64_t seed) {
  refuse_weights(target);
  return {source,
          GaussianProcess::fit(
              target.x, target.y, source.inputs(),
              {.kernel = source.kernel(), .functions = mean_function(source), .seed = seed})};
}

Vector SourceBasisProcess::predict(const Matrix& x) const {
  return GaussianProcessRegressor(target).predict(x);
}

Predictions SourceBasisProcess::predict_with_variances(const Matrix& x) const {
  Predictions result = GaussianProcessRegressor(target).predict_with_variances(x);
  const Vector added = scale() * scale() *
                       GaussianProcessRegressor(source).predict_with_variances(x).function_variance;
  result.function_variance += added;
  result.observation_variance += added;
  return result;
}

std::string SourceBasisProcess::describe() const {
  return fmt::format("{:.4g} times the source and a process of its own, {}", scale(),
                     to_string(target.kernel()));
}

Vector TransferredModel::predict(const Matrix& x) const {
  Vector mean = Vector::Zero(x.rows());
  for (const Part& part : parts) mean += part.weight * part.model.predict(x);
  return mean;
}

Predictions TransferredModel::predict_with_variances(const Matrix& x) const {
  const Vector zero = Vector::Zero(x.rows());
  Predictions sum{zero, zero, zero};  // of means, then of squares
  for (const Part& part : parts) {
    const Predictions p = part.model.predict_with_variances(x);
    if (p.function_variance.size() != x.rows() || p.observation_variance.size() != x.rows()) {
      const Vector unknown = Vector::Constant(x.rows(), kNaN);
      return {predict(x), unknown, unknown};
    }
    sum.mean += part.weight * p.mean;
    sum.function_variance += part.weight * (p.function_variance + p.mean.cwiseAbs2());
    sum.observation_variance += part.weight * (p.observation_variance + p.mean.cwiseAbs2());
  }
  const Vector square = sum.mean.cwiseAbs2();
  sum.function_variance = not_negative(sum.function_variance - square);
  sum.observation_variance = not_negative(sum.observation_variance - square);
  return sum;
}

std::string TransferredModel::describe() const {
  std::string text = "transferred";
  for (const Part& part : parts)
    text += fmt::format("{} {:.2f} {}", &part == parts.data() ? ":" : ",", part.weight,
                        to_string(part.method));
  if (std::isfinite(correlation)) text += fmt::format("; correlation {:.2f}", correlation);
  return text;
}

}  // namespace repose::surrogate

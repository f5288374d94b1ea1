#include "parts.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"

namespace repose::surrogate {
namespace {

constexpr Eigen::Index kRowsForScale = 4;

double source_noise(const Regressor& source) {
  const GaussianProcess* process = gaussian_process(source);
  return process == nullptr ? 0.0 : process->noise_variance();
}

/// Without runs to spare, how well the source knows its own function.
double presumed_residual(const Regressor& source, const Matrix& x) {
  const Vector variance = source.predict_with_variances(x).observation_variance;
  return variance.size() > 0 ? variance.mean() : 0.0;
}

}  // namespace

ShiftedModel ShiftedModel::fit(const Regressor& source, const Matrix& x, const Vector& y) {
  const Vector m = source.predict(x);
  const auto n = static_cast<double>(y.size());
  ShiftedModel model{.source = source, .covariance = Matrix::Zero(2, 2)};
  const Vector centred = m.array() - m.mean();
  const double spread = centred.squaredNorm();
  const bool scaled = y.size() >= kRowsForScale && spread > 1e-20 * m.squaredNorm();
  if (scaled) model.scale = centred.dot(y) / spread;
  model.shift = y.mean() - model.scale * m.mean();
  const Vector residual = y.array() - model.shift - model.scale * m.array();
  const double freedom = n - (scaled ? 2.0 : 1.0);
  model.residual_variance =
      freedom > 0.0 ? residual.squaredNorm() / freedom : presumed_residual(source, x);
  model.noise_variance = std::min(source_noise(source), model.residual_variance);
  model.covariance(0, 0) = model.residual_variance / n;
  if (scaled) {
    model.covariance(1, 1) = model.residual_variance / spread;
    model.covariance(0, 1) = model.covariance(1, 0) = -m.mean() * model.covariance(1, 1);
    model.covariance(0, 0) += m.mean() * m.mean() * model.covariance(1, 1);
  }
  return model;
}

Vector ShiftedModel::predict(const Matrix& x) const {
  return shift + scale * source.predict(x).array();
}

Predictions ShiftedModel::predict_with_variances(const Matrix& x) const {
  const Vector m = source.predict(x);
  const Vector of_coefficients =
      covariance(0, 0) + 2.0 * covariance(0, 1) * m.array() + covariance(1, 1) * m.array().square();
  const Vector function = of_coefficients.array().max(0.0) + (residual_variance - noise_variance);
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

SourceBasisProcess SourceBasisProcess::fit(const GaussianProcess& source, const Matrix& x,
                                           const Vector& y, std::uint64_t seed) {
  return {source,
          GaussianProcess::fit(
              x, y, source.inputs(),
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
      const Vector unknown = Vector::Constant(x.rows(), std::numeric_limits<double>::quiet_NaN());
      return {predict(x), unknown, unknown};
    }
    sum.mean += part.weight * p.mean;
    sum.function_variance += part.weight * (p.function_variance + p.mean.cwiseAbs2());
    sum.observation_variance += part.weight * (p.observation_variance + p.mean.cwiseAbs2());
  }
  const Vector square = sum.mean.cwiseAbs2();
  sum.function_variance = (sum.function_variance - square).cwiseMax(0.0);
  sum.observation_variance = (sum.observation_variance - square).cwiseMax(0.0);
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

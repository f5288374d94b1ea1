#include <cmath>
#include <limits>

#include "state.hpp"

namespace repose::surrogate {
namespace {

/// Below this fraction of (C^-1)_ii a point alone determines a regression coefficient.
constexpr double kUndetermined = 1e-12;

struct Omitted {
  Vector mean;      ///< at each point, from all others
  Vector variance;  ///< of one observation there; not a number where undetermined
};

/// e_i = (Qy)_i / Q_ii and variance of the mean of the point's observations sigma^2 / Q_ii
/// [Dubrule1983; Ginsbourger2024]. Points stand for all their repeats.
Omitted omit_each(const Dataset& data, const Covariance& covariance, const Factor& f,
                  double amplitude) {
  const Matrix w = lower_inverse(f.l);
  const Vector full = w.colwise().squaredNorm();
  const Matrix b = w.transpose() * f.q1;
  const Vector q = full - b.rowwise().squaredNorm();
  Omitted result{Vector(data.points()), Vector(data.points())};
  for (Eigen::Index i = 0; i < data.points(); ++i) {
    if (q[i] <= kUndetermined * full[i]) {
      result.mean[i] = result.variance[i] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    result.mean[i] = data.y[i] - f.alpha[i] / q[i];
    const double function = 1.0 / q[i] - covariance.noise_ratio / data.count[i] - f.jitter;
    result.variance[i] = amplitude * (std::max(0.0, function) + covariance.noise_ratio);
  }
  return result;
}

}  // namespace

LeaveOneOut GaussianProcess::leave_one_out() const {
  const Dataset& data = state_->data;
  const Omitted omitted = omit_each(data, state_->covariance, state_->factor, state_->amplitude);
  const Eigen::Index rows = data.observations();
  LeaveOneOut result{Vector(rows), Vector(rows), Vector(rows)};
  double defined = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  double covered = 0.0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto row = static_cast<std::size_t>(i);
    const Eigen::Index point = data.point_of_row[row];
    const double residual = (data.value_of_row[row] - omitted.mean[point]) * data.scale;
    result.predicted[i] = data.shift + data.scale * omitted.mean[point];
    result.variance[i] = data.scale * data.scale * omitted.variance[point];
    result.residual[i] = residual;
    if (std::isnan(residual)) continue;
    defined += 1.0;
    sum += data.value_of_row[row];
    squares += residual * residual;
    // a constant response has neither residual nor variance beyond rounding: covered
    if (std::abs(residual) <= 1.96 * std::sqrt(result.variance[i]) + 1e-12 * data.scale)
      covered += 1.0;
  }
  double total = 0.0;
  for (Eigen::Index i = 0; i < rows; ++i)
    if (!std::isnan(result.residual[i]))
      total += std::pow(
          data.scale * (data.value_of_row[static_cast<std::size_t>(i)] - sum / defined), 2);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  result.q2 = total > 0.0 ? 1.0 - squares / total : kNaN;
  result.rmse = defined > 0.0 ? std::sqrt(squares / defined) : kNaN;
  result.coverage95 = defined > 0.0 ? covered / defined : kNaN;
  return result;
}

}  // namespace repose::surrogate

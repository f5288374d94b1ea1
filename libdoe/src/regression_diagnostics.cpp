// Diagnostics of least-squares models.
#include "repose/doe/regression_diagnostics.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "columns.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"
#include "repose/doe/least_squares.hpp"
#include "scaled_qr.hpp"

namespace repose::doe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A row with this leverage determines a coefficient alone: leaving it out leaves that undefined.
constexpr double kAlone = 1.0 - 1e-10;

Vector variance_inflation(const Matrix& x, const LeastSquaresFit& fit) {
  const bool about_mean = has_constant_column(x);
  Vector inflation(x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const double ss = about_mean ? centred_ss(x.col(j)) : x.col(j).squaredNorm();
    inflation(j) = about_mean && (x.col(j).array() == x(0, j)).all()
                       ? kNaN
                       : ss * fit.unscaled_covariance(j, j);
  }
  return inflation;
}

}  // namespace

RegressionDiagnostics diagnose_regression(const Matrix& x, const Vector& y) {
  const LeastSquaresFit fit = fit_least_squares(x, y);
  const auto p = static_cast<double>(x.cols());
  RegressionDiagnostics result;
  result.residual = y - fit.fitted;
  result.leverage = ScaledQr(x, {}).leverage();
  result.studentised = result.studentised_deleted = result.cooks_distance = result.left_out =
      Vector::Constant(y.size(), kNaN);
  for (Eigen::Index i = 0; i < y.size(); ++i) {
    const double e = result.residual(i), h = result.leverage(i);
    if (h > kAlone) continue;
    result.left_out(i) = y(i) - e / (1.0 - h);
    if (fit.residual_df == 0) continue;
    result.studentised(i) = e / (fit.sigma * std::sqrt(1.0 - h));
    result.cooks_distance(i) = std::pow(result.studentised(i), 2) * h / ((1.0 - h) * p);
    if (fit.residual_df == 1) continue;
    const double deleted_ss = fit.residual_ss - e * e / (1.0 - h);
    result.studentised_deleted(i) =
        e / std::sqrt(std::max(0.0, deleted_ss) / (fit.residual_df - 1) * (1.0 - h));
  }
  result.press = (y - result.left_out).squaredNorm();
  const double total = centred_ss(y);
  result.predicted_r_squared = total > 0.0 ? 1.0 - result.press / total : kNaN;
  result.variance_inflation = variance_inflation(x, fit);
  return result;
}

LackOfFit lack_of_fit(const Matrix& x, const Vector& y, const Matrix& points) {
  const LeastSquaresFit fit = fit_least_squares(x, y);
  if (points.rows() != x.rows())
    throw InputError(
        fmt::format("lack of fit: {} points for {} observations", points.rows(), x.rows()));
  std::map<std::vector<double>, std::vector<double>> repeats;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Vector row = points.row(i);
    repeats[{row.begin(), row.end()}].push_back(y(i));
  }
  LackOfFit result;
  for (const auto& [row, values] : repeats)
    result.pure_ss += centred_ss(
        Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size())));
  const auto different = static_cast<int>(repeats.size());
  result.pure_df = static_cast<int>(x.rows()) - different;
  result.lack_df = different - static_cast<int>(x.cols());
  result.lack_ss = std::max(0.0, fit.residual_ss - result.pure_ss);
  result.f = result.p = kNaN;
  if (result.pure_df > 0 && result.lack_df > 0) {
    result.f = result.lack_ss / result.lack_df / (result.pure_ss / result.pure_df);
    result.p = f_upper_tail(result.f, result.lack_df, result.pure_df);
  }
  return result;
}

InformationCriteria information_criteria(double residual_ss, int observations, int coefficients) {
  if (!(residual_ss >= 0.0) || observations < 1 || coefficients < 0)
    throw InputError(fmt::format(
        "information criteria: a residual sum of squares of {} from {} observations and {} "
        "coefficients; none may be negative, and one observation is needed",
        residual_ss, observations, coefficients));
  const double n = observations, k = coefficients + 1.0;
  const double minus_two_log_likelihood = n * (std::log(2.0 * M_PI * residual_ss / n) + 1.0);
  InformationCriteria result;
  result.bic = minus_two_log_likelihood + k * std::log(n);
  result.aicc = n > k + 1.0
                    ? minus_two_log_likelihood + 2.0 * k + 2.0 * k * (k + 1.0) / (n - k - 1.0)
                    : std::numeric_limits<double>::infinity();
  return result;
}

}  // namespace repose::doe

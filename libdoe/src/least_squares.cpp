// Least squares by Householder QR.
#include "repose/doe/least_squares.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "columns.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"
#include "scaled_qr.hpp"

namespace repose::doe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void check_input(const Matrix& x, const Vector& y, std::vector<std::string>& names) {
  if (names.empty())
    for (Eigen::Index j = 0; j < x.cols(); ++j) names.push_back(fmt::format("column {}", j + 1));
  if (static_cast<Eigen::Index>(names.size()) != x.cols())
    throw InputError(fmt::format("least squares: {} names for {} columns", names.size(), x.cols()));
  if (x.cols() == 0 || x.rows() != y.size())
    throw InputError(fmt::format("least squares: {} x {} model matrix for {} responses", x.rows(),
                                 x.cols(), y.size()));
  if (x.rows() < x.cols())
    throw InputError(
        fmt::format("least squares: {} observations for {} coefficients; at least as many "
                    "observations are needed",
                    x.rows(), x.cols()));
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    if (!x.col(j).allFinite())
      throw InputError(fmt::format("least squares: {} has a value that is not finite",
                                   names[static_cast<std::size_t>(j)]));
  if (!y.allFinite())
    throw InputError("least squares: the response has a value that is not finite");
  const double largest = y.cwiseAbs().maxCoeff();
  if (largest > 1e140 || (largest > 0.0 && largest < 1e-140))
    throw InputError(
        fmt::format("least squares: the largest value of the response is {:.1e}, whose square no "
                    "double holds; give it in another unit",
                    largest));
}

double total_sum_of_squares(const Matrix& x, const Vector& y) {
  return has_constant_column(x) ? centred_ss(y) : y.squaredNorm();
}

void add_tests(LeastSquaresFit& fit) {
  const Eigen::Index columns = fit.coefficients.size();
  fit.standard_errors = Vector::Constant(columns, kNaN);
  fit.t = fit.p = fit.standard_errors;
  fit.sigma = kNaN;
  if (fit.residual_df == 0) return;
  fit.sigma = std::sqrt(fit.residual_ss / fit.residual_df);
  for (Eigen::Index j = 0; j < columns; ++j) {
    fit.standard_errors(j) = fit.sigma * std::sqrt(fit.unscaled_covariance(j, j));
    fit.t(j) = fit.coefficients(j) / fit.standard_errors(j);
    fit.p(j) = t_two_sided(fit.t(j), fit.residual_df);
  }
}

}  // namespace

LeastSquaresFit fit_least_squares(const Matrix& x, const Vector& y,
                                  std::vector<std::string> names) {
  check_input(x, y, names);
  const Eigen::Index n = x.rows(), p = x.cols();
  const ScaledQr qr(x, names);
  const Vector rotated = qr.rotated(y);

  LeastSquaresFit fit;
  fit.names = std::move(names);
  fit.coefficients = qr.solve(rotated);
  fit.residual_ss = rotated.tail(n - p).squaredNorm();
  fit.residual_df = static_cast<int>(n - p);
  fit.unscaled_covariance = qr.unscaled_covariance();
  fit.fitted = x * fit.coefficients;
  fit.total_ss = total_sum_of_squares(x, y);
  fit.r_squared = fit.total_ss > 0.0 ? 1.0 - fit.residual_ss / fit.total_ss : kNaN;
  add_tests(fit);
  return fit;
}

}  // namespace repose::doe

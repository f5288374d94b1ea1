// Least squares by Householder QR.
#include "repose/doe/least_squares.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/doe/distributions.hpp"

namespace repose::doe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

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
}

/// Powers of two that bring every column's norm into [1/2, 1): scaling by them is exact.
Vector column_scales(const Matrix& x) {
  Vector scales = Vector::Ones(x.cols());
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const double norm = x.col(j).stableNorm();
    int exponent = 0;
    if (norm > 0.0) std::frexp(norm, &exponent);
    scales(j) = std::ldexp(1.0, -exponent);
  }
  return scales;
}

/// |R_jj| is the distance of column j from the span of those before it.
void refuse_dependent_columns(const Matrix& scaled, const Matrix& qr,
                              const std::vector<std::string>& names) {
  const double tolerance = 10.0 * kEpsilon * static_cast<double>(scaled.rows());
  for (Eigen::Index j = 0; j < scaled.cols(); ++j)
    if (!(std::abs(qr(j, j)) > tolerance * scaled.col(j).norm()))
      throw InputError(
          fmt::format("least squares: {} depends linearly on the columns before it; leave it "
                      "out or add observations that tell them apart",
                      names[static_cast<std::size_t>(j)]));
}

bool has_constant_column(const Matrix& x) {
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    if (x(0, j) != 0.0 && (x.col(j).array() == x(0, j)).all()) return true;
  return false;
}

double total_sum_of_squares(const Matrix& x, const Vector& y) {
  if (!has_constant_column(x)) return y.squaredNorm();
  const Vector from_first = y.array() - y(0);
  return (from_first.array() - from_first.mean()).square().sum();
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
  const Vector scales = column_scales(x);
  const Matrix scaled = x * scales.asDiagonal();
  const Eigen::HouseholderQR<Matrix> qr(scaled);
  refuse_dependent_columns(scaled, qr.matrixQR(), names);

  const auto r = qr.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const Vector rotated = qr.householderQ().adjoint() * y;
  const Matrix r_inverse = r.solve(Matrix::Identity(p, p));

  LeastSquaresFit fit;
  fit.names = std::move(names);
  fit.coefficients = scales.asDiagonal() * r.solve(rotated.head(p));
  fit.residual_ss = rotated.tail(n - p).squaredNorm();
  fit.residual_df = static_cast<int>(n - p);
  const Matrix half = scales.asDiagonal() * r_inverse;
  fit.unscaled_covariance = half * half.transpose();
  fit.fitted = x * fit.coefficients;
  fit.total_ss = total_sum_of_squares(x, y);
  fit.r_squared = fit.total_ss > 0.0 ? 1.0 - fit.residual_ss / fit.total_ss : kNaN;
  add_tests(fit);
  return fit;
}

std::vector<AnovaRow> analysis_of_variance(const LeastSquaresFit& fit,
                                           const std::vector<ColumnGroup>& groups) {
  std::vector<AnovaRow> rows;
  for (const ColumnGroup& group : groups) {
    const auto size = static_cast<Eigen::Index>(group.columns.size());
    const auto outside = [&](int column) {
      return column < 0 || column >= fit.coefficients.size();
    };
    if (size == 0 || std::any_of(group.columns.begin(), group.columns.end(), outside))
      throw InputError(
          fmt::format("analysis of variance: term {} has no columns, or one that the model "
                      "does not have",
                      group.name));
    Vector b(size);
    Matrix covariance(size, size);
    for (Eigen::Index i = 0; i < size; ++i) {
      const int row = group.columns[static_cast<std::size_t>(i)];
      b(i) = fit.coefficients(row);
      for (Eigen::Index j = 0; j < size; ++j)
        covariance(i, j) = fit.unscaled_covariance(row, group.columns[static_cast<std::size_t>(j)]);
    }
    AnovaRow row{group.name, b.dot(covariance.llt().solve(b)), static_cast<int>(size), kNaN, kNaN};
    if (fit.residual_df > 0) {
      row.f = row.sum_of_squares / row.df / (fit.residual_ss / fit.residual_df);
      row.p = f_upper_tail(row.f, row.df, fit.residual_df);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<AnovaRow> analysis_of_variance(const LeastSquaresFit& fit) {
  std::vector<ColumnGroup> groups;
  for (std::size_t j = 0; j < fit.names.size(); ++j)
    if (fit.names[j] != "1") groups.push_back({fit.names[j], {static_cast<int>(j)}});
  return analysis_of_variance(fit, groups);
}

}  // namespace repose::doe

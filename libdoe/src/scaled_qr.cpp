// Householder QR of scaled columns.
#include "scaled_qr.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "repose/base/error.hpp"

namespace repose::doe {
namespace {

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
  const double tolerance =
      10.0 * std::numeric_limits<double>::epsilon() * static_cast<double>(scaled.rows());
  for (Eigen::Index j = 0; j < scaled.cols(); ++j)
    if (!(std::abs(qr(j, j)) > tolerance * scaled.col(j).norm()))
      throw InputError(fmt::format(
          "least squares: {} depends linearly on the columns before it; leave it "
          "out or add observations that tell them apart",
          names.empty() ? fmt::format("column {}", j + 1) : names[static_cast<std::size_t>(j)]));
}

}  // namespace

ScaledQr::ScaledQr(const Matrix& x, const std::vector<std::string>& names)
    : scales_(column_scales(x)) {
  const Matrix scaled = x * scales_.asDiagonal();
  qr_.compute(scaled);
  refuse_dependent_columns(scaled, qr_.matrixQR(), names);
}

Vector ScaledQr::solve(const Vector& rotated) const {
  const Eigen::Index p = scales_.size();
  const auto r = qr_.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  return scales_.asDiagonal() * r.solve(rotated.head(p));
}

Matrix ScaledQr::unscaled_covariance() const {
  const Eigen::Index p = scales_.size();
  const auto r = qr_.matrixQR().topRows(p).triangularView<Eigen::Upper>();
  const Matrix half = scales_.asDiagonal() * r.solve(Matrix::Identity(p, p));
  return half * half.transpose();
}

Vector ScaledQr::leverage() const {
  const Matrix thin = qr_.householderQ() * Matrix::Identity(qr_.rows(), scales_.size());
  return thin.rowwise().squaredNorm();
}

}  // namespace repose::doe

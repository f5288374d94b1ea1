// Householder QR of a model matrix with scaled columns: the one factorisation behind least squares,
// analysis of variance and diagnostics.
#pragma once

#include <Eigen/QR>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// Columns are scaled by powers of two, which is exact, so that their norms lie in [1/2, 1).
class ScaledQr {
 public:
  /// Throws InputError naming the first column that depends linearly on those before it; x must be
  /// finite with at least as many rows as columns. `names` may be empty.
  ScaledQr(const Matrix& x, const std::vector<std::string>& names);

  /// Q^T y: its first p values are explained by the columns in their order, the rest is residual.
  Vector rotated(const Vector& y) const { return qr_.householderQ().adjoint() * y; }
  /// Coefficients of the unscaled columns.
  Vector solve(const Vector& rotated) const;
  /// (X^T X)^-1 of the unscaled columns.
  Matrix unscaled_covariance() const;
  /// Diagonal of the projection on the columns.
  Vector leverage() const;

 private:
  Vector scales_;
  Eigen::HouseholderQR<Matrix> qr_;
};

}  // namespace repose::doe

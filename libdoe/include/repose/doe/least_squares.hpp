// Ordinary least squares with the tests that belong to it.
#pragma once

#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// y = X b + e. With no residual degrees of freedom, sigma, errors, t and p are NaN; with an exact
/// fit sigma is 0 or rounding.
struct LeastSquaresFit {
  std::vector<std::string> names;  ///< of the columns
  Vector coefficients;
  Vector standard_errors;
  Vector t;
  Vector p;  ///< two-sided
  double residual_ss = 0.0;
  int residual_df = 0;
  double sigma = 0.0;  ///< sqrt(residual_ss / residual_df)
  /// 1 - residual_ss / total_ss; the total is about the mean if X has a constant column, else about
  /// 0.
  double r_squared = 0.0;
  double total_ss = 0.0;
  Matrix unscaled_covariance;  ///< (X^T X)^-1
  Vector fitted;
};

/// Householder QR after scaling every column by a power of two; the residual sum of squares is that
/// of the rotated y. `x` is n x p with n >= p, `names` the p columns' names ("column 1", ... if
/// empty). Digits reached on certified data: docs/methods/screening.md. Throws InputError if the
/// sizes do not fit, a value is not finite, or a column depends linearly on those before it (it is
/// named).
LeastSquaresFit fit_least_squares(const Matrix& x, const Vector& y,
                                  std::vector<std::string> names = {});

}  // namespace repose::doe

// Least squares where the columns may depend on each other.
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::surrogate {

/// The coefficients b of smallest norm among those that minimise sum w (y - X b)^2, with what
/// variances need: the rank r, V (p x r, orthonormal) that spans the rows of W^1/2 X and a root R
/// (p x r) of its pseudo-inverse, (X^T W X)^+ = R R^T.
struct MinimumNormFit {
  Vector coefficients;
  Eigen::Index rank = 0;
  Matrix row_space;
  Matrix root;
};

/// By a complete orthogonal decomposition [GolubVanLoan2013, 5.4.7]; a pivot below 1e-11 of the
/// largest counts as 0. Columns should be of about the same size.
MinimumNormFit minimum_norm_fit(const Matrix& x, const Vector& y, const Vector& weights);

}  // namespace repose::surrogate

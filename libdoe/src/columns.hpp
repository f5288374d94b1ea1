// Small sums over columns that several analyses need.
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// Whether some column is a constant other than 0: an intercept.
bool has_constant_column(const Matrix& x);

/// sum (v - mean v)^2, exactly 0 for values that are all equal: deviations are taken from the first
/// value before the mean is.
double centred_ss(const Vector& values);

/// Squares and means of values as large as this one are no more than rounding below the returned
/// sum of squares of n of them.
double negligible_ss(double largest, Eigen::Index n);

}  // namespace repose::doe

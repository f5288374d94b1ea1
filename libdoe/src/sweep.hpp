// A growing linear model as an orthonormal basis: what would a further column explain?
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// y minus its projection on the columns appended so far, by Gram-Schmidt done twice.
class Sweep {
 public:
  explicit Sweep(const Vector& y);

  /// Adds a column. False, and nothing is changed, if it lies in the span of those before it (less
  /// than 1e-8 of its length is left).
  bool append(const Vector& column) { return append(column, column.squaredNorm()); }
  /// The same with the squared length to compare with, for a column that was projected before.
  bool append(const Vector& column, double full_squared_length);

  /// What is left of the residual sum of squares if the column were added; NaN where append() would
  /// be false.
  double residual_ss_with(const Vector& column) const {
    return residual_ss_with(column, column.squaredNorm());
  }
  double residual_ss_with(const Vector& column, double full_squared_length) const;
  /// Each column that does not depend on others.
  void append_all(const Matrix& columns) {
    for (Eigen::Index j = 0; j < columns.cols(); ++j) append(columns.col(j));
  }

  auto basis() const { return basis_.leftCols(columns_); }  ///< orthonormal
  const Vector& residual() const { return residual_; }
  double residual_ss() const { return residual_.squaredNorm(); }
  /// The residual is no more than rounding of y: tests against it mean nothing.
  bool is_exact() const { return residual_ss() <= negligible_ss_; }
  int residual_df() const { return static_cast<int>(residual_.size() - columns_); }

 private:
  /// The column less its projection, of length 1; empty if hardly anything is left.
  Vector direction_of(const Vector& column, double full_squared_length) const;

  Matrix basis_;  // its first columns_ columns; the rest is room
  Eigen::Index columns_ = 0;
  Vector residual_;
  double negligible_ss_ = 0.0;
};

}  // namespace repose::doe

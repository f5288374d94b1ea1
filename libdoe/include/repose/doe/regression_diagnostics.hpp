// Is a least-squares model to be trusted? Influence of single runs, prediction of runs left out,
// collinearity, lack of fit, information criteria.
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// Of the model y = X b + e; vectors over the n rows unless said otherwise.
struct RegressionDiagnostics {
  Vector residual;
  Vector leverage;  ///< h_i, the diagonal of X (X^T X)^-1 X^T; their sum is the number of columns
  /// residual / (sigma sqrt(1 - h)), sigma of the whole model; NaN where h = 1 or sigma is
  /// undefined.
  Vector studentised;
  /// The same with sigma of the model without that row [BelsleyKuhWelsch1980]: t distributed with
  /// n - p - 1 degrees of freedom.
  Vector studentised_deleted;
  Vector cooks_distance;  ///< studentised^2 h / ((1 - h) p) [Cook1977]
  Vector left_out;        ///< prediction of each row by the model without it; NaN where h = 1
  double press = 0.0;     ///< sum of (y - left_out)^2 [Allen1974]; NaN if a row cannot be left out
  /// 1 - press / sum (y - mean y)^2; NaN if y is constant. Negative for a model that predicts worse
  /// than the mean.
  double predicted_r_squared = 0.0;
  /// Of each column: how many times collinearity raises the variance of its coefficient, 1 / (1 -
  /// R_j^2) [BelsleyKuhWelsch1980]; NaN for a constant column. Without a constant column R_j^2 is
  /// about 0, not about the mean.
  Vector variance_inflation;
};

/// `x` is n x p with n >= p. Throws InputError as fit_least_squares() does.
RegressionDiagnostics diagnose_regression(const Matrix& x, const Vector& y);

/// The residual sum of squares split into what repeated rows show and the rest.
struct LackOfFit {
  double pure_ss = 0.0;  ///< within repeats
  int pure_df = 0;       ///< rows - different points; 0: nothing is repeated, nothing is tested
  double lack_ss = 0.0;
  int lack_df = 0;  ///< different points - columns
  double f = 0.0;   ///< NaN unless both have degrees of freedom
  double p = 0.0;
};

/// Observations whose rows of `points` (the levels of all factors, and the block) are equal repeat
/// each other; rows of the model matrix `x` that agree may still differ in factors that the model
/// leaves out. Throws InputError as fit_least_squares() does, and if rows differ in number.
LackOfFit lack_of_fit(const Matrix& x, const Vector& y, const Matrix& points);

/// For comparing least-squares models of the same data; smaller is better.
struct InformationCriteria {
  double aicc = 0.0;  ///< infinity if observations <= coefficients + 2 [HurvichTsai1989]
  double bic = 0.0;   ///< [Schwarz1978]
};

/// -2 ln L of normal errors at sigma^2 = residual_ss / observations, penalised for `coefficients`
/// + 1 parameters, sigma being one. -infinity for a residual of 0. Throws InputError for a negative
/// residual or no observation.
InformationCriteria information_criteria(double residual_ss, int observations, int coefficients);

}  // namespace repose::doe

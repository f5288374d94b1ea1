// What a transferred model is made of, besides coregionalised processes; for its implementation and
// for model files.
#pragma once

#include <array>

#include "repose/surrogate/transfer.hpp"

namespace repose::surrogate {

inline constexpr std::array kTransferMethods{
    TransferMethod::retrained,    TransferMethod::target_only,    TransferMethod::shift_and_scale,
    TransferMethod::source_basis, TransferMethod::coregionalised, TransferMethod::weighted};

/// b + a f_s(x), of any source.
struct ShiftedModel {
  Regressor source;
  double shift = 0.0;      ///< b
  double scale = 1.0;      ///< a
  Matrix covariance = {};  ///< 2 x 2, of b and a
  /// Of the target's rows about it, no less than the source's noise; without rows to spare that of
  /// the source's observations. NaN, as the covariance, where neither is known.
  double residual_variance = 0.0;
  double noise_variance = 0.0;  ///< the source's, 0 where it has none; the rest is misfit

  /// By (weighted) least squares; a = 1 below four different points.
  static ShiftedModel fit(const Regressor& source, const TrainingSet& target);
  Vector predict(const Matrix& x) const;
  /// The misfit counts as the function's, and a^2 times the source's variance where it has one.
  Predictions predict_with_variances(const Matrix& x) const;
  const std::vector<Input>& inputs() const { return source.inputs(); }
  std::string describe() const;
};

/// The source's mean as a regression function with these values.
BasisFunctions mean_function(const GaussianProcess& source);

/// A Gaussian process of the target with mean_function(source) in its trend.
struct SourceBasisProcess {
  GaussianProcess source;
  GaussianProcess target;

  static SourceBasisProcess fit(const GaussianProcess& source, const TrainingSet& target,
                                std::uint64_t seed);
  double scale() const { return target.coefficients().tail(1)[0]; }  ///< a
  Vector predict(const Matrix& x) const;
  Predictions predict_with_variances(const Matrix& x) const;  ///< a^2 times the source's added
  const std::vector<Input>& inputs() const { return source.inputs(); }
  std::string describe() const;
};

/// Models of the same target, weighted; at least one.
struct TransferredModel {
  struct Part {
    TransferMethod method;
    double weight;
    Regressor model;
  };
  Regressor source;
  std::vector<Part> parts;
  double correlation;  ///< as in Transfer
  double correlation_deviation;

  Vector predict(const Matrix& x) const;
  /// Of the mixture; NaN where a part has none.
  Predictions predict_with_variances(const Matrix& x) const;
  const std::vector<Input>& inputs() const { return source.inputs(); }
  std::string describe() const;
};

}  // namespace repose::surrogate

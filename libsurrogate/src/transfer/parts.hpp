// What a transferred model is made of, besides coregionalised processes; for its implementation and
// for model files.
#pragma once

#include "repose/surrogate/transfer.hpp"

namespace repose::surrogate {

/// b + a f_s(x), of any source.
struct ShiftedModel {
  Regressor source;
  double shift = 0.0;              ///< b
  double scale = 1.0;              ///< a
  Matrix covariance = {};          ///< 2 x 2, of b and a
  double residual_variance = 0.0;  ///< of the target's rows about it
  double noise_variance = 0.0;     ///< at most the residual variance; the rest is misfit

  static ShiftedModel fit(const Regressor& source, const Matrix& x, const Vector& y);
  Vector predict(const Matrix& x) const;
  /// The misfit counts as the function's.
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

  static SourceBasisProcess fit(const GaussianProcess& source, const Matrix& x, const Vector& y,
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

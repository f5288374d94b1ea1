// Support vector regression: a function of smallest norm that passes within epsilon of most
// training values.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "repose/surrogate/regressor.hpp"
#include "repose/surrogate/standardisation.hpp"

namespace repose::surrogate {

/// Of coordinates u, v (standardised inputs divided by the kernel scale).
enum class SvrKernel {
  linear,     ///< u.v
  quadratic,  ///< (1 + u.v)^2
  cubic,      ///< (1 + u.v)^3
  gaussian    ///< exp(-|u - v|^2)
};
const char* to_string(SvrKernel kernel);

/// Deviations of y are iqr(y)/1.349 over the training rows, for normal values their standard
/// deviation; the standard deviation where the quartiles agree.
struct SvrOptions {
  SvrKernel kernel = SvrKernel::gaussian;
  /// In units of the root of the number of coordinates, > 0 (MATLAB's presets: fine 1/4, medium 1,
  /// coarse 4).
  double kernel_scale = 1.0;
  double box_constraint = 1.0;  ///< C, in deviations of y, > 0
  double epsilon = 0.1;         ///< half width of the free tube, in deviations of y, >= 0
  Standardisation standardisation = Standardisation::standard_deviation;
  /// By which the conditions of optimality may be missed, in deviations of y; [1e-6, 0.1], kernel
  /// values being single precision.
  double tolerance = 1e-3;
};

/// A fitted model; never unfitted. Cheap to copy, safe to use from several threads.
class SupportVectorRegression {
 public:
  /// epsilon-SVR [Vapnik1998] by LIBSVM [ChangLin2011]. A category has an indicator for each level
  /// (one number where it is coded by label). A constant y, one row too, gives that constant.
  /// Throws InputError as check(TrainingSet), on weights and on options out of their range.
  static SupportVectorRegression fit(const TrainingSet& data, const SvrOptions& options = {});

  const std::vector<Input>& inputs() const;
  std::string describe() const;  ///< "support vectors, gaussian kernel of scale 4.24, 92 vectors"
  SvrKernel kernel() const;
  Eigen::Index support_vectors() const;

  /// At the rows of x (m x d), natural units. O(s p) a row, s support vectors.
  Vector predict(const Matrix& x) const;

 private:
  struct State;
  explicit SupportVectorRegression(std::shared_ptr<const State> state);
  friend struct SvrAccess;  // reads and rebuilds the state for model files
  std::shared_ptr<const State> state_;
};

/// SupportVectorRegression::fit with these options.
Trainer svr_trainer(std::string name, const SvrOptions& options = {});

}  // namespace repose::surrogate

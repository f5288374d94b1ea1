// Linear regression: terms of the inputs weighted by least squares, robustly, or after a choice
// among them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// Besides the constant. A category has an indicator for each level but the first (one number
/// where it is coded by label), and these are multiplied with those of other inputs only.
enum class LinearTerms {
  linear,       ///< u_1 ... u_d, numbers scaled from their declared range to [-1, 1]
  interactions  ///< and u_i u_j, i < j
};
const char* to_string(LinearTerms terms);

enum class LinearMethod {
  least_squares,
  /// Iteratively reweighted with Tukey's bisquare: residuals beyond `bisquare_constant` deviations
  /// have no weight [HollandWelsch1977].
  robust,
  /// Terms enter and leave by their p values (doe::stepwise_regression, mixed, combined entry).
  stepwise
};
const char* to_string(LinearMethod method);

struct LinearModelOptions {
  LinearTerms terms = LinearTerms::linear;
  LinearMethod method = LinearMethod::least_squares;
  /// In deviations of the errors, > 0; 4.685: 95 % efficient with normal errors.
  double bisquare_constant = 4.685;
  double p_enter = 0.05;  ///< of stepwise, as in doe::StepwiseOptions
  double p_leave = 0.10;
};

/// How the fit went.
struct LinearFitReport {
  Eigen::Index coefficients = 0;  ///< constant included
  Eigen::Index rank = 0;          ///< of the model matrix; below `coefficients` some are aliased
  Eigen::Index residual_df = 0;   ///< rows - rank; 0: the variance of the errors is not known
  int iterations = 1;             ///< of reweighting
  /// Of reweighting, within 50 iterations; false too where it stopped because every row that
  /// determines a coefficient had become an outlier.
  bool converged = true;
};

/// A fitted model; never unfitted. Cheap to copy, safe to use from several threads.
class LinearModel {
 public:
  /// Aliased coefficients, as with more terms than rows, are those of smallest norm among all that
  /// fit best; aliased by a category's level that no row has, that level is taken for the first.
  /// Weights count as repeats and are for least squares only. Throws InputError as
  /// check(TrainingSet), and on a bisquare constant that is not positive.
  static LinearModel fit(const TrainingSet& data, const LinearModelOptions& options = {});

  const std::vector<Input>& inputs() const;
  std::string describe() const;  ///< "linear regression, least squares, 19 coefficients"
  const LinearFitReport& report() const;
  /// "1", "NAME", "NAME=LEVEL", "NAME*OTHER" ... and their coefficients, in units of y.
  std::vector<std::string> term_names(const std::vector<std::string>& inputs) const;
  const Vector& coefficients() const;
  /// Of the errors, in squared units of y; NaN where no degree of freedom is left. Robust:
  /// [Huber1981, 7.6].
  double error_variance() const;

  /// At the rows of x (m x d), natural units. O(p) a row, p coefficients.
  Vector predict(const Matrix& x) const;
  /// Of the function: what the uncertain coefficients give it; of an observation: and the errors'.
  /// NaN without a degree of freedom, infinite where x asks for a combination of terms that the
  /// training rows do not determine. O(p rank) a row.
  Predictions predict_with_variances(const Matrix& x) const;

 private:
  struct State;
  explicit LinearModel(std::shared_ptr<const State> state);
  friend struct LinearModelAccess;  // reads and rebuilds the state for model files
  std::shared_ptr<const State> state_;
};

/// LinearModel::fit with these options.
Trainer linear_model_trainer(std::string name, const LinearModelOptions& options = {});

}  // namespace repose::surrogate

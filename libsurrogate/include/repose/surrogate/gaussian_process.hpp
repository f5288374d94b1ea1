// Gaussian process regression (universal kriging): a smooth function of some inputs, known at a few
// points and perhaps with noise, predicted everywhere with a variance.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "repose/base/gaussian.hpp"
#include "repose/opt/surrogate.hpp"
#include "repose/surrogate/fit_report.hpp"
#include "repose/surrogate/gaussian_process_options.hpp"
#include "repose/surrogate/input.hpp"

namespace repose::surrogate {

/// What a model says at a point, and whether it should be believed.
struct Prediction {
  Gaussian function;
  double observation_variance = 0.0;  ///< function and noise
  bool outside_range = false;         ///< of an input
  /// The data tell little here: the standard deviation, that of the trend left out, is above 0.8 of
  /// what it would be without data.
  bool far_from_data = false;
};

/// A fitted model; never unfitted. Cheap to copy (shares its immutable state), safe to use from
/// several threads.
class GaussianProcess {
 public:
  /// x: n x d in natural units, y: n values. Rows with equal x are repeats. A y that the trend
  /// explains gives amplitude 0: that trend, without doubt. Default bounds of the search: length
  /// scales [0.02, 1e5] of the range, noise ratio [1e-15, 1e4], alpha [1e-2, 1e3]. Throws
  /// InputError naming row and column on values that are not finite or not allowed, on fewer
  /// different points than coefficients + 1, on regression functions that depend on each other, on
  /// an empty range, and without noise on repeats that differ.
  static GaussianProcess fit(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                             const GaussianProcessOptions& options = {});
  static GaussianProcess fit(const Matrix& x, const Vector& y, const opt::Bounds& declared,
                             const GaussianProcessOptions& options = {});
  /// The same with given hyper-parameters: nothing is searched for.
  static GaussianProcess with_parameters(const Matrix& x, const Vector& y,
                                         const std::vector<Input>& inputs,
                                         const Hyperparameters& parameters,
                                         const GaussianProcessOptions& options = {});
  static GaussianProcess with_parameters(const Matrix& x, const Vector& y,
                                         const opt::Bounds& declared,
                                         const Hyperparameters& parameters,
                                         const GaussianProcessOptions& options = {});

  Eigen::Index dimension() const;
  Eigen::Index rows() const;     ///< observations, repeats counted
  const Matrix& points() const;  ///< the different ones, natural units

  /// Of the function at x (length d; rows: m x d), natural units. One point and rows agree to
  /// rounding, times the root of the covariance's condition where rows are many. predict_rows costs
  /// O(n^2) a row, in blocks.
  Gaussian predict(const Vector& x) const;
  std::vector<Gaussian> predict_rows(const Matrix& x) const;
  std::vector<Prediction> predictions(const Matrix& x) const;
  /// In natural units, 0 for categories. O(n^2). Regression functions of the user are
  /// differentiated by central differences.
  opt::PredictionGradient predict_gradient(const Vector& x) const;
  /// m x p, of the function at the rows of a and of b. Of a modelled log y or logit y: its
  /// correlation times the standard deviations of y. O((m + p) n^2 + m p n).
  Matrix covariance(const Matrix& a, const Matrix& b) const;

  /// The model told y at x too, everything else kept: O(n^2) for each uncertain parameter, O(n^3)
  /// where x is a repeat. With known noise variances the new one is their mean.
  GaussianProcess condition_on(const Vector& x, double y) const;

  /// As estimated; predictions have larger variances, see ParameterUncertainty.
  Hyperparameters hyperparameters() const;
  /// Of an observation, in squared units of y (of the transformed y where that is modelled); the
  /// mean of those that are known. Prediction::observation_variance holds it times the factor of
  /// ParameterUncertainty.
  double noise_variance() const;
  /// Regression coefficients in units of the (transformed) y, of inputs scaled to [0, 1]; constant:
  /// the mean.
  Vector coefficients() const;
  const std::vector<Input>& inputs() const;
  opt::Bounds declared_bounds() const;
  Kernel kernel() const;
  Noise noise() const;
  Basis basis() const;
  const std::vector<std::string>& function_names() const;  ///< of the user's regression functions
  ResponseScale response_scale() const;
  Estimator estimator() const;
  /// Of the data at these hyper-parameters, 2 pi included, prior excluded, in units of y. ml (and
  /// loo): at the coefficients of generalised least squares. reml: restricted, not comparable
  /// between bases.
  double negative_log_likelihood() const;

  /// Closed form, each point with all its repeats left out in turn.
  LeftOut leave_one_out() const;
  /// Closed form, the rows of each group left out in turn: groups[i] is that of row i, any number.
  /// A point may belong to several groups. O(n^3 + sum m^3), m the rows of a group.
  LeftOut leave_groups_out(std::span<const Eigen::Index> groups) const;
  const FitReport& report() const;

 private:
  struct State;
  explicit GaussianProcess(std::shared_ptr<const State> state);
  friend struct ModelAccess;  // reads and rebuilds the state for model files
  std::shared_ptr<const State> state_;
};

}  // namespace repose::surrogate

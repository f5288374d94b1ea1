// Two functions that are alike to a degree nobody knows: many runs of one, few of the other.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "repose/surrogate/gaussian_process.hpp"
#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// One possibility of how the target relates to the source.
struct TaskRelation {
  double correlation = 0.0;      ///< rho, of the two functions over the source's points
  double scale = 1.0;            ///< a
  double own_variance = 0.0;     ///< of the target's own part
  Vector length_factors = {};    ///< its length scales over the source's
  double shift_deviation = 0.0;  ///< of b, a priori
  double noise_variance = 0.0;   ///< of the target's observations
  double weight = 0.0;           ///< posterior probability among the relations of a model
};

/// f_t(x) = m + b + a (f_s(x) - m) + g(x): f_s as the source's Gaussian process knows it from its
/// own data, with mean m and variance v over its points; g a Gaussian process with the source's
/// kernel, each length scale times a factor c; b ~ N(0, t^2). With the correlation rho and the
/// ratio s of the functions' standard deviations, a = rho s, and g has the process variance that is
/// expected to give it (1 - rho^2) s^2 v over the source's points. This is the autoregressive model
/// of [KennedyOHagan2000] at the source's hyper-parameters, with a mean and a noise of each task;
/// with c = 1 it has the form of the intrinsic model of coregionalisation [Bonilla2008].
///
/// rho, s, t, the noise and a c for each length scale are averaged over their posterior: 1,024
/// quasi-random points of the prior, with the likelihood as weights. A priori the target is, each
/// in a quarter of all cases,
/// - nearly the source: 1 - rho^2 log-uniform in [0.001, 1], rho > 0, log s ~ N(0, 0.1^2),
///   t^2 = 0.04 v;
/// - much like it: the same with log s ~ N(0, 0.5^2) and t^2 = v;
/// - something else: rho uniform in (-1, 1), s and t likewise;
/// - unrelated: rho = 0, log s ~ N(0, 0.7^2), t^2 = 9 v.
/// log c ~ N(log 2, 1.2^2), and log of the noise variance ~ N(that of the source, 0.7^2). Where the
/// source is constant, the variance of the target's rows stands for v.
class CoregionalisedProcess {
 public:
  /// x: n x d, n >= 1. Throws InputError where the source models log y or logit y, on x as
  /// GaussianProcess::fit; NumericalError where responses are so large that no likelihood is
  /// finite.
  static CoregionalisedProcess fit(const GaussianProcess& source, const Matrix& x, const Vector& y);
  struct Judged;
  /// The same, and each row as fit() to the rows of the other groups predicts it, of all relations
  /// and in closed form. groups: a number for each row, or none. An O(n^3) more for each relation.
  static Judged fit_and_leave_out(const GaussianProcess& source, const Matrix& x, const Vector& y,
                                  std::span<const Eigen::Index> groups);
  /// At given relations, as a model file has them. Throws InputError unless there is one, each has
  /// a length factor for each length scale of the source, shift deviation, noise and factors are
  /// positive, and the weights sum to 1; NumericalError where a covariance is singular.
  static CoregionalisedProcess with_relations(const GaussianProcess& source, const Matrix& x,
                                              const Vector& y,
                                              const std::vector<TaskRelation>& relations);

  Vector predict(const Matrix& x) const;
  /// O(n^2) a row for each relation that is kept, see relations().
  Predictions predict_with_variances(const Matrix& x) const;
  const std::vector<Input>& inputs() const;
  std::string describe() const;

  /// Of rho: posterior mean and variance.
  Gaussian correlation() const;
  /// Without the improbable ones, which together have less than a thousandth of the weight.
  const std::vector<TaskRelation>& relations() const;
  const GaussianProcess& source() const;
  const Matrix& points() const;  ///< x
  const Vector& values() const;  ///< y

 private:
  struct State;
  explicit CoregionalisedProcess(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

struct CoregionalisedProcess::Judged {
  CoregionalisedProcess process;
  /// NaN where a group is all rows, and without groups. Differs from fit() to the other rows by the
  /// improbable relations that fit() drops and by rounding.
  Predictions left_out;
};

}  // namespace repose::surrogate

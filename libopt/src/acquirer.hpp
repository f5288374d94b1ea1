// How much a point promises while everything else is fixed: a batch finds each of its points with
// one of these.
#pragma once

#include <limits>
#include <optional>

#include "joint_draws.hpp"

namespace repose::opt {

class Acquirer {
 public:
  Acquirer(const BelievedModels& models, const Goal& goal, const ProposeOptions& options,
           std::uint64_t seed);

  /// Posterior means of the objective at the models' incumbents.
  const std::vector<double>& incumbent_means() const { return incumbent_means_; }
  /// Where there are none: the smallest expected value anywhere is what must be beaten.
  void beat_the_best_of(const std::vector<Predictions>& predicted);

  /// log expected improvement or minus the lower confidence bound.
  std::vector<double> values(const Matrix& points, const std::vector<Predictions>& predicted) const;
  double value(const Vector& x) const;
  bool has_gradient() const;
  double value(const Vector& x, Vector& gradient) const;

 private:
  /// The value at row p where the draws at the visited points are known.
  double noisy_value(const Predictions& predicted,
                     const std::vector<JointDraws::Conditional>& given, Eigen::Index p) const;
  double noisy_log_improvement(const Gaussian& predicted, const JointDraws::Conditional& given,
                               Eigen::Index p) const;
  std::vector<JointDraws::Conditional> given(const Matrix& points) const;

  const BelievedModels& models_;
  const Goal& goal_;
  const ProposeOptions& options_;
  Matrix normals_;  ///< draws x quantities
  std::vector<double> incumbent_means_;
  double best_ = std::numeric_limits<double>::infinity();
  std::optional<JointDraws> visited_;  ///< of noisy expected improvement
  Vector best_of_draw_;
};

/// Up to `count` different rows of `points`: the one with the smallest mean of the objective, then
/// those that may well be better, by mean minus two standard deviations.
Matrix promising_rows(const Matrix& points, const std::vector<Predictions>& predicted,
                      const Goal& goal, Eigen::Index count);

}  // namespace repose::opt

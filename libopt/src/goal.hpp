// What is minimised, as a function of what the surrogates predict.
#pragma once

#include <span>
#include <vector>

#include "repose/opt/composite.hpp"

namespace repose::opt {

/// One modelled quantity itself, or the weighted error of several.
class Goal {
 public:
  /// Without targets: the only quantity is the objective.
  explicit Goal(std::span<const Target> targets);

  bool is_composite() const { return !targets_.empty(); }
  /// Its variance is what runs can reduce: of the error against the nominal targets, whose own
  /// uncertainty is in the mean alone.
  Gaussian objective(std::span<const Gaussian> quantities) const;
  double objective(std::span<const double> quantities) const;
  /// log expected improvement on `best`; `normals` (draws x quantities) for composite ones.
  double log_improvement(std::span<const Gaussian> quantities, double best,
                         const Matrix& normals) const;
  /// With its derivatives in each mean and standard deviation.
  CompositeGradient log_improvement_gradient(std::span<const Gaussian> quantities, double best,
                                             const Matrix& normals) const;

 private:
  std::span<const Target> targets_;
  std::vector<Target> nominal_;
};

}  // namespace repose::opt

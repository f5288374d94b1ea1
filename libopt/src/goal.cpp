#include "goal.hpp"

#include "repose/opt/acquisition.hpp"

namespace repose::opt {

Goal::Goal(std::span<const Target> targets)
    : targets_(targets), nominal_(targets.begin(), targets.end()) {
  for (Target& t : nominal_) t.standard_deviation = 0.0;
}

Gaussian Goal::objective(std::span<const Gaussian> quantities) const {
  if (!is_composite()) return quantities[0];
  return {weighted_error(quantities, targets_).mean, weighted_error(quantities, nominal_).variance};
}

double Goal::objective(std::span<const double> quantities) const {
  return is_composite() ? weighted_error(quantities, targets_) : quantities[0];
}

double Goal::log_improvement(std::span<const Gaussian> quantities, double best,
                             const Matrix& normals) const {
  return is_composite() ? log_composite_expected_improvement(quantities, targets_, best, normals)
                        : log_expected_improvement(quantities[0], best);
}

CompositeGradient Goal::log_improvement_gradient(std::span<const Gaussian> quantities, double best,
                                                 const Matrix& normals) const {
  if (is_composite())
    return log_composite_expected_improvement_gradient(quantities, targets_, best, normals);
  const AcquisitionGradient g = log_expected_improvement_gradient(quantities[0], best);
  return {.value = g.value,
          .by_mean = Vector::Constant(1, g.by_mean),
          .by_standard_deviation = Vector::Constant(1, g.by_standard_deviation)};
}

}  // namespace repose::opt

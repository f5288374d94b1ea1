#include "recorder.hpp"

#include <cmath>
#include <utility>

namespace repose::opt {

ReducedSet::ReducedSet(const FeasibleSet& set) : set_(set), free_(free_coordinates(set)) {
  const Bounds all = narrowed_bounds(set);
  bounds_ = {all.lower(free_), all.upper(free_)};
  for (LinearInequality c : set.inequalities) {
    for (const LinearTie& tie : set.ties) c.bound -= c.coefficients[tie.follower] * tie.offset;
    c.coefficients = reduced_gradient(c.coefficients);
    const double range = c.coefficients.cwiseAbs().dot(bounds_.upper - bounds_.lower);
    if (!(range > 0.0)) continue;  // the same everywhere, and check_feasible_set has seen it
    c.coefficients /= range;
    c.bound /= range;
    inequalities_.push_back(std::move(c));
  }
}

Vector ReducedSet::complete(const Vector& y) const {
  if (set_.ties.empty()) return project(y, bounds_);
  Vector x = set_.bounds.lower;
  x(free_) = y;
  return rounded(x, set_);
}

Vector ReducedSet::reduced_gradient(const Vector& gradient) const {
  Vector all = gradient;
  for (const LinearTie& tie : set_.ties) all[tie.leader] += tie.ratio * gradient[tie.follower];
  return all(free_);
}

double Recorder::value_at(const Vector& y, Vector* gradient) {
  ++points_;
  x_ = space_.complete(y);
  gradient_.setZero();
  const double off = violation(x_, space_.set());
  double value = std::numeric_limits<double>::quiet_NaN();
  if (off <= kConstraintRounding) {
    ++evaluations_;
    value = objective_(x_, gradient != nullptr ? &gradient_ : nullptr);
  }
  if (gradient != nullptr)
    *gradient = space_.reduced_gradient(gradient_.array().isFinite().select(gradient_, 0.0));
  if (!std::isfinite(value)) return value;
  worst_ = std::max(worst_, value);
  if (value < best_value_ && off == 0.0) {
    best_value_ = value;
    best_ = x_;
  }
  return value;
}

double Recorder::penalty() const {
  return std::isfinite(worst_) ? worst_ + 10.0 * (1.0 + std::abs(worst_)) : 1e30;
}

}  // namespace repose::opt

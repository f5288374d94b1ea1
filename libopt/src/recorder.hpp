// What stands between the methods and the user's objective: the free coordinates of a feasible set,
// and a memory for the best point.
#pragma once

#include <limits>
#include <vector>

#include "repose/opt/feasible_set.hpp"

namespace repose::opt {

/// A feasible set without whole numbers as a method sees it: its free coordinates y within their
/// narrowed bounds, and inequalities in them, scaled so that one unit is their range over the box.
class ReducedSet {
 public:
  explicit ReducedSet(const FeasibleSet& set);

  const FeasibleSet& set() const { return set_; }
  const Bounds& bounds() const { return bounds_; }
  const std::vector<LinearInequality>& inequalities() const { return inequalities_; }
  /// The point of the box that y stands for, followers computed.
  Vector complete(const Vector& y) const;
  Vector reduced(const Vector& x) const { return x(free_); }
  /// The gradient in y of a function with this gradient in x.
  Vector reduced_gradient(const Vector& gradient) const;

 private:
  const FeasibleSet& set_;
  std::vector<Eigen::Index> free_;
  Bounds bounds_;
  std::vector<LinearInequality> inequalities_;
};

/// In ranges of a constraint: what a method may leave of it by rounding.
inline constexpr double kConstraintRounding = 1e-10;

/// Stands between a method and the objective: counts, remembers the best point that obeys the
/// constraints, and asks for none that breaks them by more than rounding.
class Recorder {
 public:
  Recorder(const Objective& objective, const ReducedSet& space, const Vector& start)
      : objective_(objective), space_(space), best_(start), x_(start), gradient_(start.size()) {}

  const ReducedSet& space() const { return space_; }
  const Vector& best() const { return best_; }
  double best_value() const { return best_value_; }
  int points() const { return points_; }            ///< proposed by the method
  int evaluations() const { return evaluations_; }  ///< of the objective, at most as many

  /// The value at y and its gradient, if asked for, in the free coordinates. Where the constraints
  /// are broken NaN; a derivative that is not finite is taken for 0.
  double value_at(const Vector& y, Vector* gradient);
  /// Worse than all seen, for methods that know only finite values.
  double penalty() const;

 private:
  const Objective& objective_;
  const ReducedSet& space_;
  Vector best_;
  Vector x_;
  Vector gradient_;
  double best_value_ = std::numeric_limits<double>::infinity();
  double worst_ = -std::numeric_limits<double>::infinity();
  int points_ = 0;
  int evaluations_ = 0;
};

}  // namespace repose::opt

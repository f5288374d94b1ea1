// One run of an NLopt method over a feasible set, with a memory for the best point.
#pragma once

#include <nlopt.h>

#include <exception>
#include <limits>
#include <vector>

#include "repose/opt/feasible_set.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::opt {

/// A feasible set without whole numbers as NLopt sees it: its free coordinates y within their
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

/// Stands between NLopt and the objective: counts, remembers the best point that obeys the
/// constraints, asks for none that breaks them by more than rounding, and replaces values that are
/// not finite by one worse than all seen.
class Recorder {
 public:
  Recorder(const Objective& objective, const ReducedSet& space, const Vector& start)
      : objective_(objective), space_(space), best_(start), x_(start), gradient_(start.size()) {}

  const ReducedSet& space() const { return space_; }
  const Vector& best() const { return best_; }
  double best_value() const { return best_value_; }
  int points() const { return points_; }            ///< proposed by the method
  int evaluations() const { return evaluations_; }  ///< of the objective, at most as many

  void attach(nlopt_opt handle) { handle_ = handle; }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }
  static double call(unsigned n, const double* y, double* gradient, void* self);

 private:
  double evaluate(const Vector& y, double* gradient);
  double remember(double value, double violation);

  const Objective& objective_;
  const ReducedSet& space_;
  Vector best_;
  Vector x_;
  Vector gradient_;
  double best_value_ = std::numeric_limits<double>::infinity();
  double worst_ = -std::numeric_limits<double>::infinity();
  int points_ = 0;
  int evaluations_ = 0;
  nlopt_opt handle_ = nullptr;
  std::exception_ptr error_;
};

/// One method from x, a point of the box; what it found is in the recorder. Rethrows exceptions of
/// the objective.
nlopt_result run_nlopt(Algorithm algorithm, const Vector& x, const MinimizerOptions& options,
                       Recorder& recorder);

/// The point nearest to x, in units of the box, that obeys the inequalities: a projection, by
/// SLSQP. If none is found, one that breaks them little.
Vector nearest_feasible(const Vector& x, const ReducedSet& space);

const char* algorithm_name(Algorithm algorithm);

}  // namespace repose::opt

// What a point must obey beside its bounds: linear constraints and whole numbers.
#pragma once

#include <string>
#include <vector>

#include "repose/opt/objective.hpp"

namespace repose::opt {

/// coefficients . x <= bound.
struct LinearInequality {
  std::string name;  ///< for messages; may be empty
  Vector coefficients;
  double bound = 0.0;
};

/// A box with linear inequalities, in which some coordinates are whole numbers.
struct FeasibleSet {
  Bounds bounds;
  std::vector<LinearInequality> inequalities = {};
  std::vector<Eigen::Index> whole = {};  ///< coordinates that are whole numbers
};

/// Throws InputError, naming constraint and coordinate, for bad bounds, coefficients of another
/// length or that are not finite, a whole coordinate that does not exist or has no whole number
/// within its bounds, and a constraint that no point of the box obeys.
void check_feasible_set(const FeasibleSet& set);

/// The point of the box nearest to `x` whose whole coordinates are whole.
Vector rounded(const Vector& x, const FeasibleSet& set);

/// How far x breaks the inequalities: sum max(0, a.x - b) / |a|_1 range, 0 if it obeys all. Less
/// than 1e-12 of the size of the terms counts as obeyed.
double violation(const Vector& x, const FeasibleSet& set);

}  // namespace repose::opt

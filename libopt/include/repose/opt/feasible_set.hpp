// What a point must obey beside its bounds: linear constraints, ties and whole numbers.
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

/// x[follower] = offset + ratio x[leader]: a search moves the leader alone, and the follower's
/// bounds become bounds of the leader. With the defaults the two coordinates are equal.
struct LinearTie {
  Eigen::Index follower = 0;
  Eigen::Index leader = 0;
  double ratio = 1.0;  ///< not 0
  double offset = 0.0;
};

/// A box with linear inequalities, in which some coordinates are whole numbers and some follow
/// others. A leader may have several followers, but follows none itself.
struct FeasibleSet {
  Bounds bounds;
  std::vector<LinearInequality> inequalities = {};
  std::vector<Eigen::Index> whole = {};  ///< coordinates that are whole numbers
  std::vector<LinearTie> ties = {};
};

/// Throws InputError, naming constraint and coordinate, for bad bounds, coefficients of another
/// length or that are not finite, a whole coordinate that does not exist or has no whole number
/// within its bounds, a constraint that no point of the box obeys, and ties that are no ties: of a
/// coordinate to itself or to a follower, two of one follower, a ratio of 0, no value of the leader
/// with which all followers are within their bounds, a whole follower that need not be whole.
void check_feasible_set(const FeasibleSet& set);

/// The coordinates that follow no other, ascending.
std::vector<Eigen::Index> free_coordinates(const FeasibleSet& set);

/// The bounds with those of the leaders narrowed to what keeps their followers within theirs. Of
/// a set that check_feasible_set accepts, lower <= upper.
Bounds narrowed_bounds(const FeasibleSet& set);

/// The point of the box nearest to `x` in all coordinates that follow no other, with whole ones
/// whole; followers are computed.
Vector rounded(const Vector& x, const FeasibleSet& set);

/// How far x breaks inequalities, max(0, a.x - b) / |a|.range, and ties,
/// |x_f - offset - ratio x_l| / range_f, summed; 0 if it obeys all. Less than 1e-12 of the size of
/// the terms counts as obeyed.
double violation(const Vector& x, const FeasibleSet& set);

}  // namespace repose::opt

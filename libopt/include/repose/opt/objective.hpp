// What is to be minimised, and where.
#pragma once

#include <functional>

#include "repose/base/parameter_space.hpp"

namespace repose::opt {

/// A box, lower <= x <= upper, both of length d and finite.
struct Bounds {
  Vector lower;
  Vector upper;
};

/// The unit cube of dimension d.
Bounds unit_cube(Eigen::Index dimension);

/// Throws InputError, naming the coordinate, unless both ends have the same length >= 1, are finite
/// and lower <= upper.
void check_bounds(const Bounds& bounds);

/// The point of the box nearest to `x`.
Vector project(const Vector& x, const Bounds& bounds);

/// The value at x (length d). Where `gradient` is not null it has length d and is filled in; a
/// function without derivatives leaves it alone and is minimised by bobyqa, crs2, direct_l or
/// isres. A value that is not finite means "not here": the minimiser turns away and goes on.
using Objective = std::function<double(const Vector& x, Vector* gradient)>;

/// The values at all rows of a matrix (m x d), a vector of length m.
using BatchObjective = std::function<Vector(const Matrix& rows)>;

}  // namespace repose::opt

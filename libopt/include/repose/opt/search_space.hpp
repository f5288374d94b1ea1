// The coordinates in which the free parameters of a study are searched.
#pragma once

#include <functional>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/opt/feasible_set.hpp"
#include "repose/opt/surrogate.hpp"

namespace repose::opt {

/// A space's free parameters as coordinates z of a FeasibleSet: ln x of a continuous parameter on a
/// log scale, the place in its list of levels, the value itself of all others; the constraints of
/// the space, in which fixed and tied parameters may stand too, become linear inequalities of z. A
/// parameter of a log scale that stands in a constraint is therefore searched on a linear one.
class SearchSpace {
 public:
  /// Throws InputError, naming both, for a constraint on levels that are not equally spaced, and
  /// as check_feasible_set does.
  explicit SearchSpace(ParameterSpace parameters);

  const ParameterSpace& parameters() const { return parameters_; }
  const FeasibleSet& set() const { return set_; }
  Eigen::Index dimension() const { return set_.bounds.lower.size(); }

  /// Of the nearest allowed values: numbers within their ranges, whole where they are whole.
  Vector natural(const Vector& coordinates) const;
  Matrix natural_rows(const Matrix& coordinates) const;
  Vector coordinates(const Vector& natural) const;
  Matrix coordinates_rows(const Matrix& natural) const;
  /// d natural/d coordinate of each; 0 for levels, whole numbers and categories.
  Vector derivative(const Vector& coordinates) const;

  /// `surrogate` of natural values (free parameters, in order) as one of coordinates.
  Surrogate in_coordinates(const Surrogate& surrogate) const;

 private:
  enum class Kind { natural, logarithm, level };
  ParameterSpace parameters_;
  FeasibleSet set_;
  std::vector<Kind> kinds_;
};

/// `inner` as a function of z, x = map(z); its derivatives by jacobian(z), d x / d z. Both must be
/// safe to call from several threads.
Surrogate mapped_surrogate(const Surrogate& inner, std::function<Vector(const Vector& z)> map,
                           std::function<Matrix(const Vector& z)> jacobian);

}  // namespace repose::opt

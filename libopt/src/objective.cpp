#include "repose/opt/objective.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/error.hpp"

namespace repose::opt {

Bounds unit_cube(Eigen::Index dimension) {
  return {Vector::Zero(dimension), Vector::Ones(dimension)};
}

void check_bounds(const Bounds& bounds) {
  if (bounds.lower.size() != bounds.upper.size() || bounds.lower.size() == 0)
    throw InputError(
        fmt::format("bounds have {} lower and {} upper ends; both must have one for each of at "
                    "least 1 coordinate",
                    bounds.lower.size(), bounds.upper.size()));
  for (Eigen::Index k = 0; k < bounds.lower.size(); ++k) {
    const double lower = bounds.lower[k];
    const double upper = bounds.upper[k];
    if (!std::isfinite(lower) || !std::isfinite(upper) || lower > upper)
      throw InputError(fmt::format(
          "bounds of coordinate {} are [{}, {}]; both must be finite with lower <= upper", k + 1,
          lower, upper));
  }
}

Vector project(const Vector& x, const Bounds& bounds) {
  return x.cwiseMax(bounds.lower).cwiseMin(bounds.upper);
}

}  // namespace repose::opt

// Gram-Schmidt with one reorthogonalisation.
#include "sweep.hpp"

#include <cmath>
#include <limits>

namespace repose::doe {

Sweep::Sweep(const Vector& y) : basis_(y.size(), 0), residual_(y) {
  if (y.size() == 0) return;
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * y.cwiseAbs().maxCoeff();
  negligible_ss_ = static_cast<double>(y.size()) * rounding * rounding;
}

bool Sweep::append(const Vector& column, double full_squared_length) {
  constexpr double kDependent = 1e-8;
  const double length = std::sqrt(full_squared_length);
  Vector direction = column;
  for (int pass = 0; pass < 2; ++pass) direction -= basis_ * (basis_.transpose() * direction);
  const double left = direction.norm();
  if (!(left > kDependent * length)) return false;
  direction /= left;
  basis_.conservativeResize(Eigen::NoChange, basis_.cols() + 1);
  basis_.rightCols(1) = direction;
  residual_ -= direction * direction.dot(residual_);
  return true;
}

}  // namespace repose::doe

// Gram-Schmidt with one reorthogonalisation.
#include "sweep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "columns.hpp"

namespace repose::doe {

Sweep::Sweep(const Vector& y) : basis_(y.size(), 0), residual_(y) {
  if (y.size() > 0) negligible_ss_ = negligible_ss(y.cwiseAbs().maxCoeff(), y.size());
}

Vector Sweep::direction_of(const Vector& column, double full_squared_length) const {
  constexpr double kDependent = 1e-8;
  Vector direction = column;
  for (int pass = 0; pass < 2; ++pass) {
    const Vector along = basis().transpose() * direction;
    direction.noalias() -= basis() * along;
  }
  const double left = direction.norm();
  if (!(left > kDependent * std::sqrt(full_squared_length))) return {};
  return direction / left;
}

double Sweep::residual_ss_with(const Vector& column, double full_squared_length) const {
  const Vector direction = direction_of(column, full_squared_length);
  if (direction.size() == 0) return std::numeric_limits<double>::quiet_NaN();
  return (residual_ - direction * direction.dot(residual_)).squaredNorm();
}

bool Sweep::append(const Vector& column, double full_squared_length) {
  const Vector direction = direction_of(column, full_squared_length);
  if (direction.size() == 0) return false;
  if (columns_ == basis_.cols())
    basis_.conservativeResize(Eigen::NoChange, std::max<Eigen::Index>(4, 2 * columns_));
  basis_.col(columns_++) = direction;
  residual_ -= direction * direction.dot(residual_);
  return true;
}

}  // namespace repose::doe

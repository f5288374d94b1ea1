// Gram-Schmidt with one reorthogonalisation.
#include "sweep.hpp"

#include <algorithm>
#include <cmath>

#include "columns.hpp"

namespace repose::doe {

Sweep::Sweep(const Vector& y) : basis_(y.size(), 0), residual_(y) {
  if (y.size() > 0) negligible_ss_ = negligible_ss(y.cwiseAbs().maxCoeff(), y.size());
}

bool Sweep::append(const Vector& column, double full_squared_length) {
  constexpr double kDependent = 1e-8;
  const double length = std::sqrt(full_squared_length);
  Vector direction = column;
  for (int pass = 0; pass < 2; ++pass) {
    const Vector along = basis().transpose() * direction;
    direction.noalias() -= basis() * along;
  }
  const double left = direction.norm();
  if (!(left > kDependent * length)) return false;
  direction /= left;
  if (columns_ == basis_.cols())
    basis_.conservativeResize(Eigen::NoChange, std::max<Eigen::Index>(4, 2 * columns_));
  basis_.col(columns_++) = direction;
  residual_ -= direction * direction.dot(residual_);
  return true;
}

}  // namespace repose::doe

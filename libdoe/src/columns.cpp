// Sums over columns.
#include "columns.hpp"

#include <limits>

namespace repose::doe {

bool has_constant_column(const Matrix& x) {
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    if (x(0, j) != 0.0 && (x.col(j).array() == x(0, j)).all()) return true;
  return false;
}

double centred_ss(const Vector& values) {
  const Vector from_first = values.array() - values(0);
  return (from_first.array() - from_first.mean()).square().sum();
}

double negligible_ss(double largest, Eigen::Index n) {
  const double rounding = 8.0 * std::numeric_limits<double>::epsilon() * largest;
  return static_cast<double>(n) * rounding * rounding;
}

}  // namespace repose::doe

// Points that a filter allows, taken in the order in which they come.
#pragma once

#include "repose/doe/space_filling.hpp"

namespace repose::doe {

/// Throws InputError unless `found` of `tried` points leave hope of finding more: one in 10000.
void require_some_allowed(Eigen::Index found, Eigen::Index tried);

/// The first `points` points of `next` that are allowed, one a row.
template <class Next>
Matrix first_allowed(Eigen::Index points, Eigen::Index dimensions, const PointFilter& allowed,
                     Next&& next) {
  Matrix x(points, dimensions);
  for (Eigen::Index found = 0, tried = 0; found < points; ++tried) {
    const Vector point = next();
    if (!allowed || allowed(point)) x.row(found++) = point.transpose();
    require_some_allowed(found, tried + 1);
  }
  return x;
}

/// Rows of `x` that are allowed.
Matrix allowed_rows(const Matrix& x, const PointFilter& allowed);

}  // namespace repose::doe

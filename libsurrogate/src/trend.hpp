// Regression functions of a Gaussian process' mean.
#pragma once

#include <string>
#include <vector>

#include "encoding.hpp"
#include "repose/surrogate/gaussian_process_options.hpp"

namespace repose::surrogate {

struct Trend {
  Basis basis = Basis::constant;
  BasisFunctions functions = {};

  bool has_constant() const { return basis != Basis::none; }
};

/// "1", "input 1", "input 1 squared", ... in order of the columns.
std::vector<std::string> trend_names(const Trend& trend, const Encoding& encoding);

/// m x q regression functions at m points, given in natural units and encoded. Throws InputError
/// where a function of the user gives something else than finite numbers, one for each name.
Matrix trend_matrix(const Trend& trend, const Encoding& encoding, const Matrix& natural,
                    const Matrix& encoded);

/// q x d derivatives of the regression functions in the inputs (natural units) at one point; those
/// of the user by central differences over 1e-5 of the range.
Matrix trend_jacobian(const Trend& trend, const Encoding& encoding, const Vector& natural,
                      const Vector& encoded);

/// Throws InputError naming a function that depends on those before it at these points.
void check_independent(const Matrix& h, const std::vector<std::string>& names);

}  // namespace repose::surrogate

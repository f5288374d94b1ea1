// Matrices of independent standard normal numbers.
#pragma once

#include <cstdint>

#include "repose/base/parameter_space.hpp"
#include "repose/base/random.hpp"

namespace repose::test {

inline Matrix random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  RandomStream random(seed);
  Matrix m(rows, columns);
  for (Eigen::Index j = 0; j < columns; ++j)
    for (Eigen::Index i = 0; i < rows; ++i) m(i, j) = random.normal();
  return m;
}

}  // namespace repose::test

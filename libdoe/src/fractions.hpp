// Regular fractions from their generators.
#pragma once

#include <vector>

#include "repose/doe/factorial.hpp"

namespace repose::doe {

/// The fraction whose factors after the base factors are these products of base factors.
FractionalFactorial fraction_of(int base_factors, std::vector<FactorProduct> generators);

}  // namespace repose::doe

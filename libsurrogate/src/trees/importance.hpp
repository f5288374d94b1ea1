// Increases of errors, summed up.
#pragma once

#include "repose/surrogate/permutation_importance.hpp"

namespace repose::surrogate::trees {

/// Mean of each column (an input) over rows (trees or permutations) and its standard error.
std::vector<Importance> importance_of(const Matrix& increase);

}  // namespace repose::surrogate::trees

// What a tree and the ensembles share when they are fitted.
#pragma once

#include <vector>

#include "columns.hpp"
#include "grower.hpp"
#include "repose/surrogate/tree.hpp"

namespace repose::surrogate::trees {

/// Throws InputError naming the option that is out of range for d inputs.
void check_options(const TreeOptions& options, Eigen::Index inputs);
Limits limits_of(const TreeOptions& options, const Columns& columns);

/// The weights of rows, 1 where there are none.
std::vector<double> weights_of(const TrainingSet& data);

/// Calls body(Grower<S>*), a null pointer that names the type, for the sums the data need.
template <class Body>
auto with_sums_of(const TrainingSet& data, Body body) {
  return data.weights.size() == 0 ? body(static_cast<Grower<UnitSums>*>(nullptr))
                                  : body(static_cast<Grower<Sums>*>(nullptr));
}

/// ", minimum leaf 5, at most 10 splits, 6 of 18 predictors".
std::string describe(const TreeOptions& options, Eigen::Index inputs);

}  // namespace repose::surrogate::trees

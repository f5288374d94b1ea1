// Points with their values and how far they break the constraints, ordered from the best.
#pragma once

#include "repose/opt/evolution.hpp"

namespace repose::opt {

/// Rows are points of the unit cube; 0 and 1 are the bounds.
struct Population {
  Matrix genomes;
  Vector values;      ///< +infinity where not finite or not asked for
  Vector violations;  ///< 0 for points that obey the constraints
};

/// The point of the feasible set's box that a genome stands for.
Vector decoded(const Vector& genome, const FeasibleSet& set);

/// Points that obey the constraints are evaluated together, the others not at all. Counts
/// evaluations in `result`.
Population evaluated(const BatchObjective& objective, Matrix genomes, const FeasibleSet& set,
                     EvolutionResult& result);

/// The order of [Deb2000]: points that obey the constraints by their value, then the others by how
/// far they break them; equal ones keep their order.
std::vector<Eigen::Index> ranking(const Population& population);

/// Takes over the best point if it is better than the result's.
void keep_best(const Population& population, const FeasibleSet& set, EvolutionResult& result);

}  // namespace repose::opt

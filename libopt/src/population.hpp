// Points with their values and how far they break the constraints, ordered from the best.
#pragma once

#include "repose/opt/evolution.hpp"

namespace repose::opt {

/// What an evolutionary method searches: genomes have a place for each coordinate that follows no
/// other, and there 0 and 1 are its narrowed bounds.
class GenomeSpace {
 public:
  explicit GenomeSpace(const FeasibleSet& set);

  const FeasibleSet& set() const { return set_; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(free_.size()); }
  /// Upper less lower bound of a place.
  double range(Eigen::Index place) const {
    return bounds_.upper[coordinate(place)] - bounds_.lower[coordinate(place)];
  }
  /// Places whose coordinates are whole numbers.
  const std::vector<Eigen::Index>& whole() const { return whole_; }
  /// The point of the feasible set's box that a genome stands for.
  Vector decoded(const Vector& genome) const;

 private:
  Eigen::Index coordinate(Eigen::Index place) const {
    return free_[static_cast<std::size_t>(place)];
  }
  const FeasibleSet& set_;
  Bounds bounds_;  // of all coordinates
  std::vector<Eigen::Index> free_, whole_;
};

/// Rows are genomes.
struct Population {
  Matrix genomes;
  Vector values;      ///< +infinity where not finite or not asked for
  Vector violations;  ///< 0 for points that obey the constraints
};

/// Points that obey the constraints are evaluated together, the others not at all. Counts
/// evaluations in `result`.
Population evaluated(const BatchObjective& objective, Matrix genomes, const GenomeSpace& space,
                     EvolutionResult& result);

/// The order of [Deb2000]: points that obey the constraints by their value, then the others by how
/// far they break them; equal ones keep their order.
std::vector<Eigen::Index> ranking(const Population& population);

/// Takes over the best point if it is better than the result's.
void keep_best(const Population& population, const GenomeSpace& space, EvolutionResult& result);

}  // namespace repose::opt

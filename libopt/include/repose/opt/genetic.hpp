// A real-coded genetic algorithm that evaluates a whole generation at once.
#pragma once

#include <cstdint>

#include "repose/opt/evolution.hpp"

namespace repose::opt {

/// How parents are chosen.
enum class Selection {
  tournament,           ///< the best of a few drawn at random
  stochastic_universal  ///< in proportion to 1/sqrt(rank), equally spaced draws [Baker1987]
};

/// How two parents make two children, coordinate by coordinate.
enum class Crossover {
  simulated_binary,  ///< near their parents, by the index [Deb1995]
  blend,     ///< uniform over the parents' interval widened by 1/2 on both sides [Eshelman1993]
  scattered  ///< each coordinate from one of them
};

/// How a coordinate changes.
enum class Mutation {
  polynomial,  ///< near, by the index, never out of the bounds [Deb2002; Deb2014]
  gaussian,    ///< deviation 0.1 of the range, falling to 0 with the generations; reflected
  uniform      ///< anywhere
};

/// Defaults: appendix D, Table D.2, of the thesis this project follows; what the table leaves open
/// is marked (ours).
struct GeneticOptions {
  int population = 1000;
  int max_generations = 2000;
  double crossover_probability = 0.6;  ///< a pair is crossed, else copied
  double mutation_probability = 0.05;  ///< of each coordinate of a child
  /// Stop when the best value improved by less than function_tolerance * max(1, |best|) in all of
  /// the last stall_generations.
  double function_tolerance = 1e-6;
  int stall_generations = 50;    ///< (ours; the usual default of MATLAB's ga)
  double elite_fraction = 0.01;  ///< best individuals that survive as they are (ours)
  Selection selection = Selection::tournament;  ///< (ours, and the two that follow)
  Crossover crossover = Crossover::blend;
  Mutation mutation = Mutation::polynomial;
  int tournament = 2;             ///< individuals of which the best is a parent (ours)
  double crossover_index = 15.0;  ///< eta of simulated binary crossover (ours)
  double mutation_index = 20.0;   ///< eta of polynomial mutation (ours)
  std::uint64_t seed = 1;
};

/// Minimises inside a box, with inequalities, ties and whole numbers as in FeasibleSet: points that
/// break a constraint are not evaluated and lose to all that do not [Deb2000], values that are not
/// finite lose to all that are. The same seed gives the same bits. Throws InputError on bad bounds,
/// constraints or options.
EvolutionResult minimize_genetic(const BatchObjective& objective, const FeasibleSet& set,
                                 const GeneticOptions& options = {});

}  // namespace repose::opt

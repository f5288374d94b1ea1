// Covariance matrix adaptation, the stronger evolutionary method where parameters interact.
#pragma once

#include "repose/opt/evolution.hpp"

namespace repose::opt {

struct CmaEsOptions {
  /// Points a generation, >= 4; 0: 4 + 3 ln d [Hansen2016].
  int population = 0;
  double initial_step = 0.3;  ///< standard deviation of the first generation, of the range; > 0
  /// Restarts after the first run, each with twice the population of the one before: global search
  /// on functions with many minima [AugerHansen2005]. >= 0.
  int restarts = 6;
  /// Of all runs together, to the end of a generation; points that break a constraint count too.
  std::int64_t max_points = 200000;
  /// A run ends when the values of a generation, and the best ones of the last 10 + 30 d/population
  /// generations, lie within this; >= 0.
  double function_tolerance = 1e-12;
  double x_tolerance = 1e-12;  ///< or when the deviation of every coordinate is below, of the range
  std::uint64_t seed = 1;
};

/// Minimises inside a box, with inequalities, ties and whole numbers as in FeasibleSet. (mu/mu_w,
/// lambda)-CMA-ES with rank-one and rank-mu updates and negative weights, all constants those of
/// [Hansen2016]. Samples outside the box are reflected into it; points that break a constraint or
/// have no finite value rank last. The first run starts in the middle of the box, the others at
/// random. On whole coordinates the deviation never falls below 0.2 of a unit, or they would
/// freeze. The same seed gives the same bits. Throws InputError on bad bounds or options.
EvolutionResult minimize_cma_es(const BatchObjective& objective, const FeasibleSet& set,
                                const CmaEsOptions& options = {});

}  // namespace repose::opt

// A real-coded genetic algorithm that evaluates a whole generation at once.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "repose/opt/minimizer.hpp"
#include "repose/opt/objective.hpp"

namespace repose::opt {

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
  int stall_generations = 50;     ///< (ours; the usual default of MATLAB's ga)
  double elite_fraction = 0.05;   ///< best individuals that survive as they are (ours)
  int tournament = 3;             ///< individuals of which the best is a parent (ours)
  double crossover_index = 15.0;  ///< eta of simulated binary crossover (ours)
  double mutation_index = 20.0;   ///< eta of polynomial mutation (ours)
  std::uint64_t seed = 1;
};

struct GeneticResult {
  Vector x;
  double value = 0.0;
  int generations = 0;
  std::int64_t evaluations = 0;
  Termination termination = Termination::failed;
  std::string message;
  std::vector<double>
      best_by_generation;  ///< never increases; the first entry is the initial population's
};

/// Minimises inside the box: tournament selection, simulated binary crossover [Deb1995], bounded
/// polynomial mutation [Deb2014], elitism. Values that are not finite lose every tournament. The
/// same seed gives the same bits. Throws InputError on bad bounds or options.
GeneticResult minimize_genetic(const BatchObjective& objective, const Bounds& bounds,
                               const GeneticOptions& options = {});

}  // namespace repose::opt

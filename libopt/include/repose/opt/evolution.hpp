// What the evolutionary methods have in common: populations of points, evaluated at once.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "repose/opt/feasible_set.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::opt {

struct EvolutionResult {
  Vector x;            ///< the best point met that obeys the constraints
  double value = 0.0;  ///< +infinity if none had a finite value
  int generations = 0;
  /// Points the objective was asked for; those that break a constraint are not asked for.
  std::int64_t evaluations = 0;
  Termination termination = Termination::failed;
  std::string message;
  std::vector<double> best_by_generation;  ///< never increases
};

/// The same search with several seeds, as the thesis repeats its genetic algorithm ten times
/// [Hadi2026, Table 5.9]: how far can the optimum be trusted?
struct RepeatedSearch {
  std::vector<EvolutionResult> results;  ///< by repetition
  std::size_t best = 0;                  ///< the one with the smallest value
  Vector mean;                           ///< of the repetitions' x
  Vector standard_deviation;             ///< of the same, n - 1; NaN for one repetition
};

/// Calls `search` with derive_seed(seed, 0), derive_seed(seed, 1), ... on `threads` threads (0: one
/// for each processor), which do not change the result. Throws InputError if repetitions < 1.
RepeatedSearch repeat_search(const std::function<EvolutionResult(std::uint64_t seed)>& search,
                             int repetitions, std::uint64_t seed, unsigned threads = 1);

}  // namespace repose::opt

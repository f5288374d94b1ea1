// The next points to simulate: batches of which each promises most, one believed after another.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "repose/opt/composite.hpp"
#include "repose/opt/feasible_set.hpp"
#include "repose/opt/surrogate.hpp"

namespace repose::opt {

/// What makes a point worth a run.
enum class Acquisition {
  /// By how much it is expected to be below the smallest posterior mean at the visited points.
  expected_improvement,
  /// By how much it is expected to be below the smallest true value at the visited points, which is
  /// not known where they are noisy: the mean over joint draws of these values [Letham2019].
  noisy_expected_improvement,
  /// How low it may be: mean - kappa standard deviations.
  lower_confidence_bound
};
const char* to_string(Acquisition acquisition);

/// What is believed of a point whose run is not done yet.
enum class Belief {
  kriging,   ///< its posterior mean ("Kriging believer") [Ginsbourger2010]
  best_lie,  ///< the values at the best visited point ("constant liar"): spreads a batch least
  mean_lie,  ///< the mean over the visited points
  worst_lie  ///< the values at the worst one: spreads a batch most
};
const char* to_string(Belief belief);

/// Whether a point may be simulated again: useless for a deterministic simulation.
enum class Repeats {
  avoid,
  allow,
  /// Where knowing which of the three best visited points is the best is worth more than the
  /// expected improvement of any new point, the one of them is repeated that may be the best and is
  /// known least.
  deliberate
};
const char* to_string(Repeats repeats);

struct ProposeOptions {
  /// Points (rows, in the coordinates of the set) whose values the surrogates know. The incumbent
  /// is the smallest posterior mean of the objective among them, never the luckiest observation.
  Matrix visited;
  Matrix pending;  ///< points that are being simulated
  /// Points whose simulation failed: no value is known there and none is believed; proposals keep
  /// failed_distance (largest coordinate difference, of the range) away from them.
  Matrix failed;
  double failed_distance = 0.1;
  Acquisition acquisition = Acquisition::expected_improvement;
  double kappa = 2.0;  ///< of the lower confidence bound, >= 0
  Belief belief = Belief::kriging;
  Repeats repeats = Repeats::avoid;
  /// Largest coordinate difference, of the range, below which two points are the same.
  double minimum_distance = 1e-3;
  int candidates = 2000;         ///< quasi-random points tried first
  int polished = 5;              ///< of them climbed from
  int polish_evaluations = 200;  ///< for each
  int draws = 256;               ///< of the quantities
  std::uint64_t seed = 1;
  unsigned threads = 1;  ///< the result does not depend on it
};

struct Proposal {
  Matrix points;                    ///< q x d
  std::vector<Gaussian> predicted;  ///< objective at each, when it was chosen
  /// What each promised when it was chosen: log expected improvement, or minus the lower confidence
  /// bound; -infinity where no allowed point promised anything.
  std::vector<double> merit;
  std::vector<bool> repeat;  ///< deliberately, of a visited point
};

/// q points of `set` that promise to lower one modelled quantity. The surrogate takes coordinates
/// of the set. Many candidates are judged, the best climbed from, by gradient where the surrogate
/// has one. Throws InputError on q < 1, matrices without d columns, an acquisition that the
/// surrogate is not fit for, and constraints that next to no point of the box obeys.
Proposal propose_batch(const Surrogate& objective, const FeasibleSet& set, int q,
                       const ProposeOptions& options);

/// The same for the weighted error of several quantities, kpis[j] predicting what targets[j] wants:
/// improvement of the known function of them [Astudillo2019], believing at the level of the
/// quantities.
Proposal propose_batch(std::span<const Surrogate> kpis, std::span<const Target> targets,
                       const FeasibleSet& set, int q, const ProposeOptions& options);

}  // namespace repose::opt

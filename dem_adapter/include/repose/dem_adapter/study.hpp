// A study: what is to be calibrated against what, and how much may be spent on it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/dem_adapter/campaign.hpp"
#include "repose/dem_adapter/compute_plan.hpp"
#include "repose/dem_adapter/engine_choice.hpp"
#include "repose/dem_adapter/scenario.hpp"
#include "repose/doe/screening.hpp"
#include "repose/opt/composite.hpp"
#include "repose/opt/genetic.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::dem_adapter {

struct ScreeningPlan {
  int repetitions = 3;   ///< of the whole design, each with its own seeds
  int fake_factors = 2;  ///< extra columns of the design, each two degrees of freedom for error
  /// Main effects by backward elimination: in these designs they are free of second-order effects,
  /// and a forward search from the empty model stops before its first step where several effects
  /// are strong.
  doe::ScreeningOptions analysis{.candidates = doe::CandidateTerms::main_effects,
                                 .direction = doe::StepDirection::backward};
};

struct SamplingPlan {
  int points_per_parameter = 10;   ///< of the Latin hypercube [Loeppky2009]
  int repetitions = 2;             ///< runs at each point
  bool use_screening_runs = true;  ///< to train the surrogates too
};

struct AdaptivePlan {
  int batch = 4;        ///< points added at once
  int max_batches = 4;  ///< the budget
  double r2 = 0.95;     ///< all surrogates at least this good: enough [Hadi2026, section 5.3.4]
};

struct VerificationPlan {
  int repetitions = 5;  ///< runs at the calibrated point, with seeds not used before
};

/// A target with the 95 % confidence half-width of its measurement (0: unknown).
struct MeasuredTarget {
  opt::Target target;
  double ci95 = 0.0;
};

struct Study {
  std::string title;
  Scenario scenario;
  std::uint64_t seed = 1;
  Seeds seeds = Seeds::own;
  ParameterSpace space;
  std::vector<MeasuredTarget> targets;
  ScreeningPlan screening;
  SamplingPlan sampling;
  AdaptivePlan adaptive;
  surrogate::GaussianProcessOptions surrogate;
  opt::GeneticOptions genetic;
  VerificationPlan verification;
  EngineChoice engine;
  ComputePlan compute;
  FailurePolicy failures;

  std::vector<opt::Target> plain_targets() const;
};

/// Reads a study file; its keys are documented in docs/how-to/study.md. `scenario` is a file named
/// relative to the study, or a table. Throws InputError with file, line, key, value and remedy.
Study read_study(const std::filesystem::path& path);

/// How many runs each phase takes; sampling and adaptive ones are upper bounds, as the number of
/// parameters that matter is not known before.
struct RunCounts {
  int screening = 0;
  int sampling = 0;
  int adaptive = 0;
  int verification = 0;
  int total() const { return screening + sampling + adaptive + verification; }
};
RunCounts planned_runs(const Study& study);

}  // namespace repose::dem_adapter

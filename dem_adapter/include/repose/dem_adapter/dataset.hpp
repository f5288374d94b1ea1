// The points of a study and the runs made at them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/campaign.hpp"
#include "repose/dem_adapter/study.hpp"
#include "repose/table/table.hpp"

namespace repose::dem_adapter {

enum class Phase { screening, sampling, adaptive, verification, baseline };
const char* to_string(Phase phase);

/// A point in unit coordinates of the study's whole space.
struct Point {
  Phase phase = Phase::sampling;
  int batch = 0;  ///< of adaptive sampling, from 1
  Vector unit;
};

struct Observation {
  std::size_t point = 0;  ///< index into Dataset::points
  int repetition = 0;
  std::uint64_t seed = 0;  ///< of the attempt that counts
  RunOutcome outcome;
  /// The KPI's value, that of a penalty for a failed run; empty if it has none.
  std::optional<double> kpi(const std::string& name) const { return outcome.measurement.kpi(name); }
};

struct Dataset {
  std::vector<Point> points;
  std::vector<Observation> observations;

  /// Runs without any KPI.
  std::size_t failed() const;
  /// One row a run: phase, point, repetition, free parameters, seed, KPIs (NaN where there is
  /// none), outcome, failure, run, times and memory.
  table::Table table(const Study& study) const;
};

/// Seed of one run. Verification and baseline runs depend on the repetition alone, so that two
/// points are compared with the same packings; no other phase uses those seeds.
std::uint64_t run_seed(const Study& study, Phase phase, int batch, std::size_t index,
                       int repetition);

/// Adds points of one phase and the runs at them. Order and seeds do not depend on the number of
/// workers.
void simulate(Dataset& data, const Study& study, const Campaign& campaign, Phase phase, int batch,
              const Matrix& unit_points, int repetitions, const ProgressCallback& progress);

}  // namespace repose::dem_adapter

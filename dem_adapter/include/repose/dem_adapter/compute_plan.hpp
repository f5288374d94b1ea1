// What a campaign may use of the machine, and what becomes of runs that fail.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "repose/base/toml.hpp"
#include "repose/dem_adapter/executor.hpp"
#include "repose/dem_adapter/outcome.hpp"
#include "repose/dem_adapter/slurm.hpp"

namespace repose::dem_adapter {

/// Whether runs with the same first stages share their simulation; their results do not change.
enum class Beginnings { shared, own };

struct ComputePlan {
  unsigned workers = 0;            ///< runs at once; 0: as many as cores and memory hold
  int cores = 0;                   ///< for all runs together; 0: all of the machine
  int ranks = 1;                   ///< processes of one run
  double memory_gb = 0.0;          ///< for all runs together; 0: not looked at
  double memory_per_run_gb = 0.0;  ///< what one run needs
  double time_limit_s = 1800.0;    ///< for one run; 0: none
  Beginnings beginnings = Beginnings::shared;
  std::filesystem::path store = {};  ///< where finished runs are; empty: in the study's own folder
  std::optional<SlurmOptions> slurm = {};  ///< runs go to its queue; none: to this machine
};

/// How many runs fit at once, or stand in the queue, at least one. Throws InputError for ranks that
/// exceed the cores, a run that exceeds the memory, a limit of memory without the need of a run,
/// and limits of this machine for runs that go to a queue.
unsigned runs_at_once(const ComputePlan& plan);

/// What runs the programs of a campaign in this directory. `warn` is told of trouble that may pass,
/// from any thread. Throws StorageError if SLURM is wanted and is not installed.
Executor executor_of(const ComputePlan& plan, const std::filesystem::path& directory,
                     std::function<void(std::string)> warn = {});

struct FailurePolicy {
  int retries = 0;  ///< with new seeds, of a run that failed by one of `retry_on`
  std::vector<Outcome> retry_on = {Outcome::particles_lost, Outcome::non_finite,
                                   Outcome::unphysical, Outcome::crash, Outcome::engine_failed};
  /// The campaign stops when a larger share of its runs has failed, once there are 10; 1: never.
  double stop_above = 1.0;
  /// A failed run's value of a KPI, so that what learns from it keeps away; KPIs without one are
  /// missing.
  std::map<std::string, double> penalty = {};
};

/// Reads [compute], [slurm] and [failures], all optional; a relative store is relative to `folder`.
/// Penalties are for KPIs of `kpis`. Throws InputError with file and line.
ComputePlan read_compute_plan(const TomlTable& root, const std::filesystem::path& folder);
FailurePolicy read_failure_policy(const TomlTable& root, const std::vector<std::string>& kpis);

}  // namespace repose::dem_adapter

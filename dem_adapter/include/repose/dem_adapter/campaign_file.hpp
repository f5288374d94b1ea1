// campaign.toml: a scenario simulated at the points of a table, and the table that comes of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/dem_adapter/campaign.hpp"
#include "repose/dem_adapter/compute_plan.hpp"
#include "repose/dem_adapter/engine_choice.hpp"
#include "repose/dem_adapter/run_plan.hpp"
#include "repose/dem_adapter/scenario.hpp"
#include "repose/table/table.hpp"

namespace repose::dem_adapter {

/// What DIR/campaign.toml asks for; its keys are documented in docs/how-to/campaign.md.
struct CampaignFile {
  std::string title;
  Scenario scenario;
  std::uint64_t seed = 1;
  int repetitions = 1;  ///< runs at each point, with different seeds
  Seeds seeds = Seeds::own;
  table::Table points;  ///< one row a point, one column a parameter, natural units; none: one point
  ParameterValues fixed;
  std::vector<Tie> ties;
  EngineChoice engine;
  ComputePlan compute;
  FailurePolicy failures;

  /// Runs wanted, those of a point beside each other.
  std::size_t runs() const;
  std::size_t point_of(std::size_t run) const {
    return run / static_cast<std::size_t>(repetitions);
  }
  int repetition_of(std::size_t run) const {
    return static_cast<int>(run % static_cast<std::size_t>(repetitions));
  }
  /// Throws InputError naming the point if its values cannot be simulated.
  RunInput make_input(std::size_t run, int attempt = 0) const;
  WantedRuns wanted_runs() const;  ///< while this lives
};

/// Throws StorageError if there is none, InputError with file and line.
CampaignFile read_campaign(const std::filesystem::path& directory);

/// Writes one row a wanted run that has an outcome: point, repetition, parameters, seed, KPIs (NaN
/// where there is none, the penalty of a failed run), outcome, failure, run, times, memory. Returns
/// their number. A table of any length takes the memory of a thousand rows.
std::size_t write_campaign_table(const std::filesystem::path& file, const CampaignFile& campaign,
                                 const RunPlan& plan, const RunStore& store,
                                 const std::string& command_line);

}  // namespace repose::dem_adapter

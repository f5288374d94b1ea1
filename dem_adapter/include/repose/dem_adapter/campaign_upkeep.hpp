// Looking after a campaign's directory: how far it is, what to do again, what to throw away.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "repose/dem_adapter/outcome.hpp"

namespace repose::dem_adapter {

/// Of a campaign or a calibration; for one without plan.json, of all runs of its store.
struct CampaignStatus {
  std::filesystem::path store;
  std::size_t wanted = 0;                    ///< runs of the plan
  std::size_t settled = 0;                   ///< of these have an outcome that stands
  std::map<Outcome, std::size_t> counts;     ///< of the settled ones
  std::map<Outcome, std::string> examples;   ///< "RUN: why", the first of each failure
  std::size_t under_way = 0;                 ///< somebody works on them now, or a queue has them
  std::size_t pending = 0, running = 0;      ///< of these and of states that they share, in a queue
  std::vector<std::string> pending_because;  ///< in the words of the queue
  std::string queue_silence;                 ///< why the queue could not be asked, if so
  std::size_t stopped = 0;                   ///< begun, but nobody works on them
  std::size_t recorded = 0;                  ///< in the store, also for other plans
  double wall_time_s = 0.0, cpu_time_s = 0.0;  ///< sums over the settled ones
  std::int64_t peak_memory_bytes = 0;          ///< largest of a run
  std::string owner;                           ///< who works in the directory, if anybody
  std::size_t failed() const;
};

/// Changes nothing; may be asked while the campaign runs. Throws StorageError if the directory
/// holds none.
CampaignStatus campaign_status(const std::filesystem::path& directory);

/// Makes those runs of the plan unfinished that ended in one of `outcomes`, so that the next call
/// of the campaign does them again. Returns their keys. Throws StorageError while somebody works in
/// the directory.
std::vector<std::string> retry_runs(const std::filesystem::path& directory,
                                    const std::vector<Outcome>& outcomes);

enum class CleanOutputs { keep, remove };
enum class CleanUnplanned { keep, remove };
struct CleanOptions {
  /// Of finished runs the engine's output: KPIs stay, but can no longer be measured anew.
  CleanOutputs outputs = CleanOutputs::keep;
  /// Runs that the plan does not name: of an earlier plan or build of the engine.
  CleanUnplanned unplanned = CleanUnplanned::keep;
};
struct Cleaned {
  std::size_t stopped = 0, outputs = 0, unplanned = 0;  ///< removed
  std::size_t beginnings = 0;                           ///< states that runs shared, removed
  std::uintmax_t bytes = 0;
};
/// Removes folders of runs that were stopped, with their checkpoints, states that runs shared, and
/// what the options say, and rewrites the index. Runs that the plans of other studies want, which
/// use the directory as their store, stay, and so do those in a queue, or in one that does not
/// answer. Throws StorageError while somebody works in the directory, InputError for unplanned runs
/// of a store that is elsewhere.
Cleaned clean_campaign(const std::filesystem::path& directory, const CleanOptions& options = {});

}  // namespace repose::dem_adapter

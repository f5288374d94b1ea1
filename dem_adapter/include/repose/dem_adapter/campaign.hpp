// Many runs in one directory: several at once, each named by its content, none done twice, none
// lost.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "repose/base/progress.hpp"
#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/scene/case.hpp"

namespace repose::dem_adapter {

/// One run as recorded in its outcome.json.
struct RunOutcome {
  std::string key;  ///< folder under runs/
  Measurement measurement;
  double wall_time_s = 0.0;
  double exceeded_limit_s = 0.0;  ///< the time limit that ended it; 0: it ended by itself
  bool usable() const { return measurement.failure.empty(); }
};

/// KPIs of a finished run, from its output folder.
using Measure = std::function<Measurement(const std::filesystem::path& output)>;

struct CampaignOptions {
  unsigned workers = 0;          ///< runs at once; 0: one for each processor
  double time_limit_s = 3600.0;  ///< for one run
  /// Becomes true when the user wants to stop: runs in flight are given up and Interrupted is
  /// thrown.
  const std::atomic<bool>* cancelled = nullptr;
};

/// Thrown when the user stopped a campaign; whatever finished is kept.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "stopped by the user"; }
};

/// A directory of runs. Layout: runs/KEY/{case.toml, engine.log, output/, outcome.json};
/// outcome.json is written last and atomically, so a folder without it is a run that did not finish
/// and is done again. A failed run has an outcome too, with its reason, and is not repeated, unless
/// it ran out of time and the limit is higher now.
class Campaign {
 public:
  /// Takes the directory's lock. Throws StorageError if it cannot be made or another process has
  /// it.
  Campaign(std::filesystem::path directory, Engine engine, Measure measure,
           CampaignOptions options);
  ~Campaign();
  Campaign(const Campaign&) = delete;
  Campaign& operator=(const Campaign&) = delete;

  /// One outcome for each case, in their order, whatever the number of workers. Equal cases are run
  /// once. Progress counts runs; the note names failures.
  std::vector<RunOutcome> run(const std::vector<scene::Case>& cases,
                              const ProgressCallback& progress = {}) const;

  const std::filesystem::path& directory() const { return directory_; }
  unsigned workers() const { return options_.workers; }

 private:
  std::string key_of(const std::string& case_text) const;
  /// A recorded outcome that still stands.
  std::optional<RunOutcome> recorded(const std::string& key, const std::string& case_text) const;
  RunOutcome run_one(const std::string& key, const std::string& case_text,
                     const std::atomic<bool>& given_up) const;
  Measurement measured(const std::filesystem::path& output) const;

  std::filesystem::path directory_;
  Engine engine_;
  Measure measure_;
  CampaignOptions options_;
  int lock_ = -1;
};

/// Mean wall time of the usable runs that a campaign's directory holds, s; 0 if there are none.
double mean_wall_time_s(const std::filesystem::path& directory);

}  // namespace repose::dem_adapter

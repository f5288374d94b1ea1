// How far a campaign has come: counts, rate, and when too much has failed.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>

#include "repose/base/progress.hpp"
#include "repose/dem_adapter/run_store.hpp"

namespace repose::dem_adapter {

/// Thread-safe.
class Tally {
 public:
  Tally(std::size_t wanted, double stop_above, ProgressCallback progress);
  /// A run that was there before.
  void found(const RunOutcome& outcome);
  /// From now on runs are new. Throws SimulationError if too many have failed.
  void begin();
  /// A new run. Throws SimulationError if too many have failed.
  void finished(const RunOutcome& outcome);

 private:
  void report() const;
  void check() const;
  std::string note() const;

  std::mutex mutex_;
  std::size_t wanted_, done_ = 0, failed_ = 0, new_ = 0;
  double stop_above_;
  ProgressCallback progress_;
  std::map<Outcome, std::size_t> counts_;
  std::string example_;  // of a failure
  std::chrono::steady_clock::time_point began_;
};

/// "8 jammed-outlet, 4 crash", commonest first, without finished runs.
std::string counts_text(const std::map<Outcome, std::size_t>& counts);

}  // namespace repose::dem_adapter

// Many runs of an engine: several at once, none done twice, none lost, failures kept as results.
#pragma once

#include <atomic>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "repose/base/progress.hpp"
#include "repose/dem_adapter/compute_plan.hpp"
#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/run_plan.hpp"
#include "repose/dem_adapter/run_store.hpp"
#include "repose/dem_adapter/scenario.hpp"

namespace repose::dem_adapter {

/// KPIs of a finished run from its output folder. A record of another `name` is measured again,
/// without a new run, as long as its output is there.
struct Measure {
  std::string name;
  std::function<Measurement(const std::filesystem::path& output)> of;
};
Measure measure_of(const Scenario& scenario);

/// What the user wants of a campaign under way.
enum class Stop {
  no,
  when_runs_end,  ///< begin no more runs
  now             ///< end those under way, by a checkpoint if the engine has them
};
static_assert(std::atomic<Stop>::is_always_lock_free, "set inside a signal handler");

struct CampaignOptions {
  ComputePlan compute = {};
  FailurePolicy failures = {};
  const std::atomic<Stop>* stop = nullptr;  ///< Interrupted is thrown then
};

/// Thrown when the user stopped a campaign; whatever finished is kept.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "stopped by the user"; }
};

/// The runs that a campaign wants, made when they are needed.
struct WantedRuns {
  std::size_t count = 0;
  /// The same input for the same number, whenever asked; from several threads at once. Attempts
  /// after the first, 0, of a run that failed want another attempt_seed().
  std::function<RunInput(std::size_t run, int attempt)> make_input;
};
/// Whether each point has seeds of its own, or repetition r the same seed at every point: the same
/// packing, where parameters do not change it.
enum class Seeds { own, common };
/// Reads `seeds = "own" | "common"`, own if absent. Throws InputError.
Seeds read_seeds(const TomlTable& root);

/// The seed of an attempt at a run; that of attempt 0 is `seed` itself.
std::uint64_t attempt_seed(std::uint64_t seed, int attempt);

/// DIR/{.lock, plan.json} and a store, by default in the same directory. A failed run has an
/// outcome too and is not repeated, unless it ran out of time and the limit is higher now.
class Campaign {
 public:
  /// Takes the directory's lock. Throws StorageError if it cannot be made or another process has
  /// it, InputError for a plan that fits nothing.
  Campaign(std::filesystem::path directory, Engine engine, Measure measure,
           CampaignOptions options);
  ~Campaign();
  Campaign(const Campaign&) = delete;
  Campaign& operator=(const Campaign&) = delete;

  /// Sees to it that every run wanted has an outcome, whatever the number of workers. Equal inputs
  /// are run once. Progress counts runs; its note names rate and failures. Throws Interrupted,
  /// SimulationError if too many fail, and what concerns every run: a full disk, a missing engine.
  /// Memory does not hold the inputs, only some keys: below 1 kB a run.
  void run(const WantedRuns& wanted, const ProgressCallback& progress = {}) const;
  /// The same, with the outcomes in order of the runs.
  std::vector<RunOutcome> outcomes(const WantedRuns& wanted,
                                   const ProgressCallback& progress = {}) const;

  const std::filesystem::path& directory() const { return directory_; }
  const RunStore& store() const { return *store_; }
  const FailurePolicy& failures() const { return options_.failures; }
  unsigned workers() const { return workers_; }

 private:
  /// A run with the first seed or a new one, and what it is called.
  struct Attempt {
    RunInput input;
    std::string key;
  };
  Attempt attempt_of(const WantedRuns& wanted, std::size_t run, int attempt) const;
  /// What is recorded if it still stands, measured as we do.
  std::optional<RunOutcome> standing(const Attempt& attempt,
                                     const std::optional<RunOutcome>& recorded) const;
  /// The same, but measured anew if only that is needed.
  std::optional<RunOutcome> settled_by(const Attempt& attempt,
                                       const std::optional<RunOutcome>& recorded) const;
  RunOutcome measured_anew(RunOutcome outcome) const;
  RunOutcome brought_about(const WantedRuns& wanted, std::size_t run,
                           const std::atomic<bool>& given_up) const;
  RunOutcome run_one(const Attempt& attempt, const std::atomic<bool>& given_up) const;
  EngineExit run_engine(const std::filesystem::path& folder,
                        const std::function<bool()>& cancelled) const;
  RunOutcome outcome_of(const Attempt& attempt, const EngineExit& exit) const;
  Measurement measured(const std::filesystem::path& output) const;
  double remaining_time_s(const Resources& used) const;
  bool wants_retry(const RunOutcome& outcome) const;
  /// On all workers; what a task throws ends all, but an Interrupted that follows from that.
  void do_all(
      std::size_t count,
      const std::function<void(std::size_t, const std::atomic<bool>& given_up)>& task) const;
  void make_beginnings(const WantedRuns& wanted, const std::vector<std::size_t>& open) const;
  Stop stop() const { return options_.stop != nullptr ? options_.stop->load() : Stop::no; }

  std::filesystem::path directory_;
  Engine engine_;
  Measure measure_;
  CampaignOptions options_;
  unsigned workers_;
  std::unique_ptr<class DirectoryLock> lock_;
  std::unique_ptr<RunStore> store_;
  mutable RunPlan plan_;
  mutable std::unique_ptr<class SharedBeginnings> beginnings_;
};

/// Mean wall time of the finished runs that a campaign's directory holds, s; 0 if there are none.
double mean_wall_time_s(const std::filesystem::path& directory);

}  // namespace repose::dem_adapter

#include "repose/dem_adapter/campaign_upkeep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "directory_lock.hpp"
#include "repose/base/error.hpp"
#include "repose/dem_adapter/run_plan.hpp"
#include "repose/dem_adapter/run_store.hpp"
#include "repose/dem_adapter/submission.hpp"
#include "run_folder.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

/// The plan, or where there is none yet every run that the directory holds, unless they are
/// others'.
RunPlan plan_of(const fs::path& directory) {
  if (auto plan = read_plan(directory)) return *plan;
  RunPlan plan{.store = fs::absolute(directory), .retry_on = {}, .runs = {}};
  if (wanted_by_users(directory)) return plan;
  for (const auto& key : RunStore(directory, StoreAccess::read).keys()) plan.runs.push_back({key});
  return plan;
}

bool has_own_store(const fs::path& directory, const RunPlan& plan) {
  return fs::equivalent(directory, plan.store);
}

std::uintmax_t size_of(const fs::path& place) {
  std::uintmax_t sum = 0;
  std::error_code code;
  for (const auto& entry : fs::recursive_directory_iterator(place, code))
    if (entry.is_regular_file(code)) sum += entry.file_size(code);
  return sum;
}

std::uintmax_t removed(const fs::path& place) {
  const auto bytes = size_of(place);
  remove_whole(place);
  return bytes;
}

std::vector<fs::path> folders_in(const fs::path& place) {
  std::vector<fs::path> folders;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(place, code)) folders.push_back(entry.path());
  return folders;
}

std::vector<fs::path> joined(std::vector<fs::path> some, const std::vector<fs::path>& others) {
  some.insert(some.end(), others.begin(), others.end());
  return some;
}

/// Those of the runs that a queue has, or may have.
std::set<fs::path> queued(const std::vector<fs::path>& homes, const QueueState& state) {
  std::set<fs::path> there(state.pending.begin(), state.pending.end());
  there.insert(state.running.begin(), state.running.end());
  if (!state.silence.empty())
    for (const auto& home : homes)
      if (submission_of(home)) there.insert(home);
  return there;
}

std::set<fs::path> queued(const std::vector<fs::path>& homes) {
  return queued(homes, queue_state(homes));
}

void add(CampaignStatus& status, const RunOutcome& outcome) {
  ++status.settled;
  const auto name = outcome.measurement.outcome;
  if (++status.counts[name] == 1 && name != Outcome::finished)
    status.examples[name] = outcome.key + ": " + outcome.measurement.failure;
  status.wall_time_s += outcome.resources.wall_time_s;
  status.cpu_time_s += outcome.resources.cpu_time_s;
  status.peak_memory_bytes =
      std::max(status.peak_memory_bytes, outcome.resources.peak_memory_bytes);
}

}  // namespace

std::size_t CampaignStatus::failed() const {
  std::size_t sum = 0;
  for (const auto& [outcome, count] : counts) sum += is_failure(outcome) ? count : 0;
  return sum;
}

CampaignStatus campaign_status(const fs::path& directory) {
  const auto plan = plan_of(directory);
  const RunStore store(plan.store, StoreAccess::read);
  CampaignStatus status{.store = plan.store, .wanted = plan.runs.size(), .recorded = store.size()};
  status.owner = DirectoryLock::owner(directory).value_or("");
  const auto find = [&](const std::string& key) { return store.find(key); };
  for (const auto& attempts : plan.runs)
    if (const auto outcome = settled(attempts, plan.retry_on, find)) add(status, *outcome);
  const auto wanted = keys_of(plan);
  const bool own = has_own_store(directory, plan);
  std::vector<fs::path> homes;
  for (const auto& key : store.unfinished())
    if (own || wanted.count(key) > 0) homes.push_back(store.folder(key));
  const auto beginnings = own ? folders_in(plan.store / "beginnings") : std::vector<fs::path>{};
  const auto queue = queue_state(joined(homes, beginnings));
  status.pending = queue.pending.size();
  status.running = queue.running.size();
  status.pending_because = queue.reasons;
  status.queue_silence = queue.silence;
  const auto in_queue = queued(homes, queue);
  for (const auto& home : homes)
    ++(in_queue.count(home) > 0 || RunClaim::is_taken(home) ? status.under_way : status.stopped);
  return status;
}

std::vector<std::string> retry_runs(const fs::path& directory,
                                    const std::vector<Outcome>& outcomes) {
  const auto plan = plan_of(directory);
  const DirectoryLock lock(directory);
  const RunStore store(plan.store, StoreAccess::write);
  std::vector<std::string> forgotten;
  const auto is_meant = [&](const RunOutcome& outcome) {
    return std::find(outcomes.begin(), outcomes.end(), outcome.measurement.outcome) !=
           outcomes.end();
  };
  const auto find = [&](const std::string& key) { return store.find(key); };
  for (const auto& attempts : plan.runs) {
    const auto outcome = settled(attempts, plan.retry_on, find);
    if (!outcome || !is_meant(*outcome)) continue;
    for (const auto& key : attempts) {
      if (!store.find(key)) continue;
      store.forget(key);
      forgotten.push_back(key);
      if (key == outcome->key) break;
    }
  }
  return forgotten;
}

Cleaned clean_campaign(const fs::path& directory, const CleanOptions& options) {
  const auto plan = plan_of(directory);
  const bool own = has_own_store(directory, plan);
  if (options.unplanned == CleanUnplanned::remove && !own)
    throw InputError(fmt::format(
        "the runs are in '{}', which other studies may share, so those that this plan does not "
        "name are not removed; clean that directory itself",
        plan.store.string()));
  const DirectoryLock lock(directory);
  const RunStore store(plan.store, StoreAccess::write);
  const auto wanted = keys_of(plan);
  const auto by_others =
      own ? wanted_by_users(plan.store).value_or(std::set<std::string>{}) : std::set<std::string>{};
  const auto is_ours = [&](const std::string& key) {
    return wanted.count(key) > 0 || (own && by_others.count(key) == 0);
  };
  Cleaned cleaned;
  std::vector<fs::path> stopped, beginnings = folders_in(plan.store / "beginnings");
  if (!own) beginnings.clear();
  for (const auto& key : store.unfinished())
    if (is_ours(key)) stopped.push_back(store.folder(key));
  const auto in_queue = queued(joined(stopped, beginnings));
  const auto remove_unless_taken = [&](const fs::path& folder, const fs::path& part) {
    if (in_queue.count(folder) > 0) return false;
    const auto claim = RunClaim::try_take(folder);
    if (!claim) return false;
    forget_submission(folder);
    cleaned.bytes += removed(part);
    return true;
  };
  for (const auto& folder : stopped)
    if (remove_unless_taken(folder, folder)) ++cleaned.stopped;
  for (const auto& key : store.keys()) {
    const auto folder = store.folder(key);
    const bool is_wanted = wanted.count(key) > 0;
    if (!is_wanted && is_ours(key) && options.unplanned == CleanUnplanned::remove) {
      store.forget(key);
      if (remove_unless_taken(folder, folder)) ++cleaned.unplanned;
    } else if (is_wanted && options.outputs == CleanOutputs::remove &&
               fs::exists(folder / "output") && remove_unless_taken(folder, folder / "output")) {
      ++cleaned.outputs;
    }
  }
  for (const auto& folder : beginnings)
    if (remove_unless_taken(folder, folder)) ++cleaned.beginnings;
  store.compact_index();
  return cleaned;
}

}  // namespace repose::dem_adapter

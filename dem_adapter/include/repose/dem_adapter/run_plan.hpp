// Which runs a campaign wants, so that its state can be told without its study.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "repose/dem_adapter/compute_plan.hpp"
#include "repose/dem_adapter/run_store.hpp"

namespace repose::dem_adapter {

/// DIR/plan.json.
struct RunPlan {
  std::filesystem::path store;  ///< absolute
  std::vector<Outcome> retry_on;
  /// For each run wanted the keys of its attempts: the first, then those with new seeds.
  std::vector<std::vector<std::string>> runs;
};

/// Empty if the directory has none. Throws StorageError if it is damaged.
std::optional<RunPlan> read_plan(const std::filesystem::path& directory);
void write_plan(const std::filesystem::path& directory, const RunPlan& plan);

/// Notes in STORE/users that this directory's plan wants runs of the store. Throws StorageError.
void note_user(const std::filesystem::path& store, const std::filesystem::path& directory);
/// Keys that the plans of others want which use the directory as their store, as far as they are
/// still there; empty optional: nobody does.
std::optional<std::set<std::string>> wanted_by_users(const std::filesystem::path& store);
/// All keys of a plan.
std::set<std::string> keys_of(const RunPlan& plan);

/// What a wanted run has come to: the first attempt that is not to be repeated, else the last;
/// empty while an attempt is missing. `find` gives the outcome of a key.
std::optional<RunOutcome> settled(
    const std::vector<std::string>& attempts, const std::vector<Outcome>& retry_on,
    const std::function<std::optional<RunOutcome>(const std::string& key)>& find);

}  // namespace repose::dem_adapter

#include "repose/dem_adapter/run_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

std::filesystem::path plan_file(const std::filesystem::path& directory) {
  return directory / "plan.json";
}

}  // namespace

std::optional<RunPlan> read_plan(const std::filesystem::path& directory) {
  const auto file = plan_file(directory);
  if (!std::filesystem::exists(file)) return std::nullopt;
  std::string reason;
  try {
    const auto json = nlohmann::json::parse(read_file(file));
    RunPlan plan;
    plan.store = json.at("store").get<std::string>();
    // A campaign that was moved has its own runs still beside it.
    if (json.at("store_is_here").get<bool>()) plan.store = std::filesystem::absolute(directory);
    for (const auto& name : json.at("retry_on"))
      plan.retry_on.push_back(outcome_named(name.get<std::string>()));
    plan.runs = json.at("runs").get<std::vector<std::vector<std::string>>>();
    return plan;
  } catch (const nlohmann::json::exception& error) {
    reason = error.what();
  } catch (const InputError& error) {
    reason = error.what();
  }
  throw StorageError(
      fmt::format("'{}' is damaged ({}); remove it, the next run of the campaign writes it anew",
                  file.string(), reason));
}

void write_plan(const std::filesystem::path& directory, const RunPlan& plan) {
  nlohmann::ordered_json json{{"store", plan.store.string()},
                              {"store_is_here", std::filesystem::equivalent(plan.store, directory)},
                              {"retry_on", nlohmann::json::array()},
                              {"runs", plan.runs}};
  for (const Outcome outcome : plan.retry_on) json["retry_on"].push_back(to_string(outcome));
  write_file_atomically(plan_file(directory), json.dump() + "\n");
}

void note_user(const std::filesystem::path& store, const std::filesystem::path& directory) {
  const auto user = std::filesystem::canonical(directory).string();
  const auto note = store / "users" / fmt::format("{:016x}", content_hash(user));
  if (std::filesystem::exists(note)) return;
  make_directory(note.parent_path());
  write_file_atomically(note, user);
}

std::optional<std::set<std::string>> wanted_by_users(const std::filesystem::path& store) {
  if (!std::filesystem::is_directory(store / "users")) return std::nullopt;
  std::optional<std::set<std::string>> keys;
  for (const auto& note : std::filesystem::directory_iterator(store / "users")) {
    const std::filesystem::path user = read_file(note.path());
    if (!std::filesystem::is_directory(user)) continue;
    if (!keys) keys.emplace();
    if (const auto plan = read_plan(user)) keys->merge(keys_of(*plan));
  }
  return keys;
}

std::set<std::string> keys_of(const RunPlan& plan) {
  std::set<std::string> keys;
  for (const auto& attempts : plan.runs) keys.insert(attempts.begin(), attempts.end());
  return keys;
}

std::optional<RunOutcome> settled(
    const std::vector<std::string>& attempts, const std::vector<Outcome>& retry_on,
    const std::function<std::optional<RunOutcome>(const std::string& key)>& find) {
  std::optional<RunOutcome> last;
  for (const auto& key : attempts) {
    last = find(key);
    if (!last) return std::nullopt;
    if (std::find(retry_on.begin(), retry_on.end(), last->measurement.outcome) == retry_on.end())
      return last;
  }
  return last;
}

}  // namespace repose::dem_adapter

#include "shared_beginnings.hpp"

#include <algorithm>
#include <limits>

#include "outcome_json.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem_adapter/submission.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/run_output.hpp"
#include "run_folder.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

constexpr char kInput[] = "input of a run";  // in messages

/// Names the state after each stage but the last.
std::vector<std::string> keys_of(const std::string& engine, const scene::Case& scene) {
  std::vector<std::string> keys;
  for (std::size_t stages = 1; stages < scene.stages.size(); ++stages)
    keys.push_back(run_key(engine, scene::case_text(scene::beginning_of(scene, stages))));
  return keys;
}

fs::path made_file(const fs::path& folder) {
  return folder / "made.json";
}

}  // namespace

SharedBeginnings::SharedBeginnings(fs::path folder, const Engine& engine, std::size_t count,
                                   const std::function<std::string(std::size_t)>& text_of)
    : folder_(std::move(folder)), engine_(engine) {
  if (!engine_.waits_after_stages() || count < 2) return;
  struct Seen {  // small: there may be as many as runs
    std::size_t run = 0, stages = 0;
    std::string goes_on_as;  // a longer beginning, or a whole input
    bool is_shared = false;
  };
  std::map<std::string, Seen> seen;
  for (std::size_t i = 0; i < count; ++i) {
    const auto text = text_of(i);
    const auto keys = keys_of(engine_.name(), scene::parse_case(text, kInput));
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const auto next = k + 1 < keys.size() ? keys[k + 1] : run_key(engine_.name(), text);
      auto& here = seen.try_emplace(keys[k], Seen{i, k + 1, next, false}).first->second;
      here.is_shared = here.is_shared || here.goes_on_as != next;
    }
  }
  for (const auto& [key, what] : seen)
    if (what.is_shared) {
      const auto text = text_of(what.run);
      const auto scene = scene::parse_case(text, kInput);
      states_.push_back({key, text, what.stages, scene.stages[what.stages - 1].name});
    }
  std::stable_sort(states_.begin(), states_.end(),
                   [](const State& a, const State& b) { return a.stages < b.stages; });
  for (std::size_t s = 0; s < states_.size(); ++s) by_key_[states_[s].key] = s;
}

std::vector<std::pair<std::size_t, std::size_t>> SharedBeginnings::generations() const {
  std::vector<std::pair<std::size_t, std::size_t>> result;
  for (std::size_t s = 0; s < states_.size(); ++s) {
    if (s == 0 || states_[s].stages != states_[s - 1].stages) result.emplace_back(s, s);
    result.back().second = s + 1;
  }
  return result;
}

bool SharedBeginnings::is_made(const State& state) const {
  return fs::exists(made_file(folder_ / state.key));
}

const SharedBeginnings::State* SharedBeginnings::latest_of(const std::string& text,
                                                           std::size_t below) const {
  if (states_.empty()) return nullptr;
  const State* latest = nullptr;
  for (const auto& key : keys_of(engine_.name(), scene::parse_case(text, kInput)))
    if (const auto it = by_key_.find(key); it != by_key_.end()) {
      const auto& state = states_[it->second];
      if (state.stages < below && is_made(state)) latest = &state;
    }
  return latest;
}

void SharedBeginnings::make(std::size_t number, const ComputePlan& compute,
                            const std::function<bool()>& cancelled) const {
  const auto& state = states_[number];
  const auto folder = folder_ / state.key;
  const auto claim = RunClaim::take(folder, cancelled);
  if (!claim) throw Interrupted();
  if (is_made(state)) return;
  const bool in_queue = submission_of(folder).has_value();
  if (!in_queue) prepare_folder(folder, state.text);
  if (const auto* earlier = latest_of(state.text, state.stages);
      earlier != nullptr && !in_queue && !fs::exists(scene::checkpoint_file(folder / "output")))
    copy_output(folder_ / earlier->key, folder);
  const auto exit = engine_.run({.directory = folder,
                                 .ranks = compute.ranks,
                                 .time_limit_s = compute.time_limit_s,
                                 .cancelled = cancelled,
                                 .until = state.last_stage});
  if (exit.status == EngineStatus::finished)
    write_file_atomically(made_file(folder), resources_text(exit.resources));
  forget_submission(folder);
  if (exit.status == EngineStatus::cancelled || cancelled()) throw Interrupted();
}

void SharedBeginnings::hand_to(const fs::path& run_folder, const std::string& text) const {
  if (fs::exists(scene::checkpoint_file(run_folder / "output"))) return;  // it is further
  if (const auto* state = latest_of(text, std::numeric_limits<std::size_t>::max()))
    copy_output(folder_ / state->key, run_folder);
}

}  // namespace repose::dem_adapter

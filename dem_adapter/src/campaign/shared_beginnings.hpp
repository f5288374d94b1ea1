// States that several runs of a campaign come through alike, such as the settled filling of rigs
// that differ in how fast they are lifted: simulated once, in STORE/beginnings/KEY, then copied.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "repose/dem_adapter/campaign.hpp"
#include "repose/dem_adapter/engine.hpp"

namespace repose::dem_adapter {

/// The bits of a run are the same with and without it. Nothing is ever shared of an engine that
/// cannot wait after a stage, or of a scenario whose runs have a single stage.
class SharedBeginnings {
 public:
  /// `folder` is that of the beginnings; `text_of(i)` the input of run i of `count`, all different.
  SharedBeginnings(std::filesystem::path folder, const Engine& engine, std::size_t count,
                   const std::function<std::string(std::size_t)>& text_of);

  /// How many there are, a longer one after those it begins with.
  std::size_t size() const { return states_.size(); }
  /// Those with the same number of stages, which do not need each other, as [first, last).
  std::vector<std::pair<std::size_t, std::size_t>> generations() const;
  /// Sees to it that a state is there, if its simulation can be brought that far; if not, its runs
  /// do it themselves and find out why. Throws Interrupted, and what concerns every run.
  void make(std::size_t state, const ComputePlan& compute,
            const std::function<bool()>& cancelled) const;
  /// Puts the latest state that the run shares into its folder, which has no output.
  void hand_to(const std::filesystem::path& run_folder, const std::string& text) const;

 private:
  struct State {
    std::string key, text;  ///< an input that comes through it
    std::size_t stages = 0;
    std::string last_stage;
  };
  const State* latest_of(const std::string& text, std::size_t below) const;
  bool is_made(const State& state) const;

  std::filesystem::path folder_;
  Engine engine_;
  std::vector<State> states_;
  std::map<std::string, std::size_t> by_key_;
};

}  // namespace repose::dem_adapter

// Runs whose first stages are alike simulate these once, and give what they give without.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <mutex>

#include "repose/base/file.hpp"
#include "repose/dem_adapter/campaign.hpp"
#include "repose/scene/run_output.hpp"
#include "synthetic_scenario.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

/// A stage is a line in output/state.txt, and the checkpoint says how many there are; KPIs are sums
/// over lines. Counts the stages that it simulates. Stands beside repose-dem.
struct StagedEngine {
  static constexpr bool kWaitsAfterStages = true;
  std::shared_ptr<std::map<std::string, int>> simulated =
      std::make_shared<std::map<std::string, int>>();
  std::shared_ptr<std::mutex> mutex = std::make_shared<std::mutex>();
  std::string fails_in{};

  std::string name() const { return "staged"; }
  EngineExit run(const EngineJob& job) const {
    const auto c = scene::read_case(job.directory / "case.toml");
    const auto output = job.directory / "output";
    std::filesystem::create_directories(output);
    std::size_t done = 0;
    if (std::filesystem::exists(scene::checkpoint_file(output)))
      std::ifstream(scene::checkpoint_file(output)) >> done;
    std::ofstream state(output / "state.txt", std::ios::app);
    for (; done < c.stages.size(); ++done) {
      const auto& stage = c.stages[done];
      if (stage.name == fails_in) return {.failure = Outcome::unphysical, .message = "too soft"};
      state << c.seed + static_cast<std::uint64_t>(1000 * stage.duration_s) << '\n';
      {
        const std::lock_guard lock(*mutex);
        ++(*simulated)[stage.name];
      }
      if (stage.name == job.until) {
        std::ofstream(scene::checkpoint_file(output)) << done + 1;
        return {.status = EngineStatus::finished};
      }
    }
    std::filesystem::remove(scene::checkpoint_file(output));
    return {.status = EngineStatus::finished};
  }
  static Measure measure() {
    return {"staged", [](const std::filesystem::path& output) {
              Measurement m;
              std::ifstream in(output / "state.txt");
              double sum = 0.0;
              for (double line = 0.0; in >> line;) m.kpis["sum"] = sum = 3.0 * sum + line;
              return m;
            }};
  }
};

/// Runs i = 0 ... 5: fill, then two ways to lift, then three ways to rest. Two seeds for each.
WantedRuns lifted(std::size_t count = 12) {
  const auto input = [](std::size_t run, int attempt) {
    const auto way = run / 2;
    auto c = test::SyntheticScenario().make_case(
        {{"a", 0.5}, {"b", 0.5}, {"c", 0}, {"d", 0}, {"e", 0}}, attempt_seed(run % 2, attempt));
    c.stages = {{.name = "fill", .duration_s = 1.0},
                {.name = "lift", .duration_s = way < 3 ? 2.0 : 3.0},
                {.name = "rest", .duration_s = 4.0 + static_cast<double>(way % 3)}};
    return input_of(c);
  };
  return {.count = count, .make_input = input};
}

std::vector<double> sums(const std::vector<RunOutcome>& outcomes) {
  std::vector<double> result;
  for (const auto& outcome : outcomes) result.push_back(outcome.measurement.kpis.at("sum"));
  return result;
}

TEST(SharedBeginnings, AreSimulatedOnceAndChangeNothing) {
  const test::TemporaryDirectory apart, together;
  const StagedEngine straight, sharing;
  const auto expected = sums(Campaign(apart.path(), straight, StagedEngine::measure(),
                                      {.compute = {.workers = 2, .beginnings = Beginnings::own}})
                                 .outcomes(lifted()));
  EXPECT_EQ(*straight.simulated,
            (std::map<std::string, int>{{"fill", 12}, {"lift", 12}, {"rest", 12}}));
  const Campaign campaign(together.path(), sharing, StagedEngine::measure(),
                          {.compute = {.workers = 2}});
  EXPECT_EQ(sums(campaign.outcomes(lifted())), expected);
  EXPECT_EQ(*sharing.simulated,
            (std::map<std::string, int>{{"fill", 2}, {"lift", 4}, {"rest", 12}}));
  // Another call with more runs takes the states that are there.
  const auto more = [](std::size_t run, int attempt) {
    auto c = scene::parse_case(lifted().make_input(run % 2, attempt).text, "more");
    c.stages[2].duration_s = 20.0 + static_cast<double>(run);
    return input_of(c);
  };
  campaign.outcomes({.count = 6, .make_input = more});
  EXPECT_EQ((*sharing.simulated)["lift"], 4);
}

TEST(SharedBeginnings, AreNotMadeForASingleRunOfEach) {
  const test::TemporaryDirectory directory;
  const StagedEngine engine;
  Campaign(directory.path(), engine, StagedEngine::measure(), {.compute = {.workers = 1}})
      .outcomes(lifted(2));
  EXPECT_FALSE(std::filesystem::exists(directory / "beginnings"));
}

TEST(SharedBeginnings, ThatFailLeaveTheFailureToTheRuns) {
  const test::TemporaryDirectory directory;
  const StagedEngine engine{.fails_in = "lift"};
  const Campaign campaign(directory.path(), engine, StagedEngine::measure(),
                          {.compute = {.workers = 2}});
  for (const auto& outcome : campaign.outcomes(lifted()))
    EXPECT_EQ(outcome.measurement.failure, "too soft");
  EXPECT_EQ((*engine.simulated)["fill"], 2);
}

TEST(SharedBeginnings, AreLeftAloneWithAnEngineThatCannotWait) {
  const test::TemporaryDirectory directory;
  const Campaign campaign(directory.path(), test::SyntheticEngine(0.1),
                          test::SyntheticEngine::measure(), {.compute = {.workers = 1}});
  for (const auto& outcome : campaign.outcomes(lifted())) EXPECT_FALSE(outcome.failed());
  EXPECT_FALSE(std::filesystem::exists(directory / "beginnings"));
}

}  // namespace
}  // namespace repose::dem_adapter

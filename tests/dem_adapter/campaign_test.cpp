// Campaigns: no run twice, none lost, failures recorded, one process at a time.
#include "repose/dem_adapter/campaign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "repose/base/error.hpp"
#include "repose/scene/run_output.hpp"
#include "synthetic_scenario.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

std::vector<scene::Case> cases(int n) {
  std::vector<scene::Case> result;
  for (int i = 0; i < n; ++i)
    result.push_back(test::SyntheticScenario().make_case(
        {{"a", 0.1 * i}, {"b", 0.5}, {"c", 0}, {"d", 0}, {"e", 0}}, static_cast<std::uint64_t>(i)));
  return result;
}

TEST(Campaign, GivesTheSameOutcomesForAnyNumberOfWorkers) {
  std::vector<std::vector<RunOutcome>> all;
  for (const unsigned workers : {1U, 2U, 8U}) {
    const test::TemporaryDirectory directory;
    const Campaign campaign(directory.path(), test::SyntheticEngine(0.1),
                            test::SyntheticEngine::measure, {.workers = workers});
    all.push_back(campaign.run(cases(9)));
  }
  for (const auto& outcomes : all)
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      EXPECT_EQ(outcomes[i].key, all[0][i].key);
      EXPECT_EQ(outcomes[i].measurement.kpis, all[0][i].measurement.kpis);
    }
}

TEST(Campaign, RunsEachCaseOnceEvenInALaterProcess) {
  const test::TemporaryDirectory directory;
  const test::SyntheticEngine engine(0.1);
  std::vector<RunOutcome> first;
  {
    const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure,
                            {.workers = 2});
    auto with_repeat = cases(5);
    with_repeat.push_back(with_repeat.front());
    first = campaign.run(with_repeat);
    EXPECT_EQ(engine.runs(), 5);
    EXPECT_EQ(first.front().measurement.kpis, first.back().measurement.kpis);
  }
  const Campaign again(directory.path(), engine, test::SyntheticEngine::measure, {.workers = 2});
  const auto second = again.run(cases(7));
  EXPECT_EQ(engine.runs(), 7);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(second[i].measurement.kpis, first[i].measurement.kpis);
}

TEST(Campaign, DoesARunAgainThatDidNotFinish) {
  const test::TemporaryDirectory directory;
  const test::SyntheticEngine engine(0.1);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure, {.workers = 1});
  const auto outcome = campaign.run(cases(1)).front();
  const auto folder = directory.path() / "runs" / outcome.key;
  std::filesystem::remove(folder / "outcome.json");  // as if killed just before the end
  std::ofstream(folder / "output" / "half a file") << "x";
  EXPECT_EQ(campaign.run(cases(1)).front().measurement.kpis, outcome.measurement.kpis);
  EXPECT_EQ(engine.runs(), 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "output" / "half a file"));
}

/// Is stopped at its first run, in the middle of its output; needs that to finish the second.
class StoppedOnce {
 public:
  std::string name() const { return "stopped once"; }
  EngineExit run(const EngineJob& job) const {
    const auto output = job.directory / "output";
    if (std::filesystem::exists(scene::checkpoint_file(output))) {
      std::filesystem::rename(output / "half.txt", output / "kpis.txt");
      return {.status = EngineStatus::finished};
    }
    std::filesystem::create_directories(output);
    std::ofstream(output / "half.txt") << "1 2 3";
    std::ofstream(scene::checkpoint_file(output)) << "state";
    return {.status = EngineStatus::cancelled};
  }
};

TEST(Campaign, LetsARunGoOnThatLeftACheckpoint) {
  const test::TemporaryDirectory directory;
  const Campaign campaign(directory.path(), StoppedOnce(), test::SyntheticEngine::measure,
                          {.workers = 1});
  EXPECT_THROW(campaign.run(cases(1)), Interrupted);
  EXPECT_EQ(campaign.run(cases(1)).front().measurement.kpis.at("third"), 3.0);
}

TEST(Campaign, RecordsFailuresWithTheirReasonAndDoesNotRepeatThem) {
  const test::TemporaryDirectory directory;
  test::SyntheticEngine engine(0.0);
  engine.failing_above(0.25);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure, {.workers = 2});
  const auto outcomes = campaign.run(cases(5));
  EXPECT_TRUE(outcomes[2].usable());
  EXPECT_FALSE(outcomes[3].usable());
  EXPECT_EQ(outcomes[4].measurement.failure, "it jammed");
  EXPECT_EQ(campaign.run(cases(5))[4].measurement.failure, "it jammed");
  EXPECT_EQ(engine.runs(), 5);
}

TEST(Campaign, RefusesASecondProcessInItsDirectory) {
  const test::TemporaryDirectory directory;
  const Campaign first(directory.path(), test::SyntheticEngine(0), test::SyntheticEngine::measure,
                       {});
  EXPECT_THROW(
      Campaign(directory.path(), test::SyntheticEngine(0), test::SyntheticEngine::measure, {}),
      StorageError);
}

TEST(Campaign, StopsWhenToldAndKeepsWhatIsDone) {
  const test::TemporaryDirectory directory;
  std::atomic<bool> cancelled{false};
  const test::SyntheticEngine engine(0.1);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure,
                          {.workers = 1, .cancelled = &cancelled});
  EXPECT_THROW(campaign.run(cases(6),
                            [&](double done, double, std::string_view) {
                              if (done >= 3.0) cancelled = true;
                            }),
               Interrupted);
  EXPECT_EQ(engine.runs(), 3);
  cancelled = false;
  campaign.run(cases(6));
  EXPECT_EQ(engine.runs(), 6);
}

TEST(Campaign, StopsAtOnceWhenNoRunCanSucceedAndRecordsNothing) {
  const test::TemporaryDirectory directory;
  struct FullDisk {
    std::string name() const { return "full disk"; }
    EngineExit run(const EngineJob&) const { throw StorageError("no space left on device"); }
  };
  const Campaign campaign(directory.path(), FullDisk(), test::SyntheticEngine::measure,
                          {.workers = 2});
  EXPECT_THROW(campaign.run(cases(5)), StorageError);
  for (const auto& entry : std::filesystem::directory_iterator(directory.path() / "runs"))
    EXPECT_FALSE(std::filesystem::exists(entry.path() / "outcome.json"));
}

TEST(Campaign, DoesATimedOutRunAgainOnlyWithMoreTime) {
  struct Slow {
    std::shared_ptr<std::atomic<int>> runs = std::make_shared<std::atomic<int>>(0);
    std::string name() const { return "slow"; }
    EngineExit run(const EngineJob&) const {
      ++*runs;
      return {.status = EngineStatus::timed_out,
              .message = "it exceeded the time limit",
              .wall_time_s = 1.0};
    }
  };
  const test::TemporaryDirectory directory;
  const Slow slow;
  for (const auto& [limit, runs] :
       {std::pair{10.0, 1}, std::pair{10.0, 1}, std::pair{5.0, 1}, std::pair{20.0, 2}}) {
    const Campaign campaign(directory.path(), slow, test::SyntheticEngine::measure,
                            {.workers = 1, .time_limit_s = limit});
    EXPECT_FALSE(campaign.run(cases(1)).front().usable());
    EXPECT_EQ(*slow.runs, runs) << limit;
  }
}

TEST(Campaign, CallsANonFiniteKpiAFailure) {
  const test::TemporaryDirectory directory;
  const auto measure = [](const std::filesystem::path&) {
    Measurement m;
    m.kpis = {{"angle_deg", std::nan("")}};
    return m;
  };
  for (int call = 0; call < 2; ++call) {  // computed, then read back
    const Campaign campaign(directory.path(), test::SyntheticEngine(0), measure, {.workers = 1});
    const auto outcome = campaign.run(cases(1)).front();
    EXPECT_NE(outcome.measurement.failure.find("angle_deg is nan"), std::string::npos);
    EXPECT_TRUE(outcome.measurement.kpis.empty());
  }
}

TEST(Campaign, NamesADamagedOutcome) {
  const test::TemporaryDirectory directory;
  const Campaign campaign(directory.path(), test::SyntheticEngine(0),
                          test::SyntheticEngine::measure, {});
  const auto key = campaign.run(cases(1)).front().key;
  std::ofstream(directory.path() / "runs" / key / "outcome.json") << "{\"status\":";
  try {
    campaign.run(cases(1));
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("outcome.json' is damaged"), std::string::npos);
  }
}

}  // namespace
}  // namespace repose::dem_adapter

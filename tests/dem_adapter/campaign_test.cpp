// Campaigns: no run twice, none lost, failures recorded, one process at a time.
#include "repose/dem_adapter/campaign.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/scene/run_output.hpp"
#include "synthetic_scenario.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

CampaignOptions workers(unsigned n) {
  return {.compute = {.workers = n}};
}

/// Run i has the seed i; from the distinct-th on they repeat.
WantedRuns cases(std::size_t n, std::size_t distinct = 1000) {
  const auto input = [distinct](std::size_t run, int attempt) {
    const auto i = run % distinct;
    return input_of(test::SyntheticScenario().make_case(
        {{"a", 0.1 * static_cast<double>(i)}, {"b", 0.5}, {"c", 0}, {"d", 0}, {"e", 0}},
        attempt_seed(i, attempt)));
  };
  return {.count = n, .make_input = input};
}

TEST(Campaign, GivesTheSameOutcomesForAnyNumberOfWorkers) {
  std::vector<std::vector<RunOutcome>> all;
  for (const unsigned count : {1U, 2U, 8U}) {
    const test::TemporaryDirectory directory;
    const Campaign campaign(directory.path(), test::SyntheticEngine(0.1),
                            test::SyntheticEngine::measure(), workers(count));
    all.push_back(campaign.outcomes(cases(9)));
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
    const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), workers(2));
    first = campaign.outcomes(cases(6, 5));
    EXPECT_EQ(engine.runs(), 5);
    EXPECT_EQ(first.front().measurement.kpis, first.back().measurement.kpis);
  }
  const Campaign again(directory.path(), engine, test::SyntheticEngine::measure(), workers(2));
  const auto second = again.outcomes(cases(7));
  EXPECT_EQ(engine.runs(), 7);
  for (std::size_t i = 0; i < 5; ++i)
    EXPECT_EQ(second[i].measurement.kpis, first[i].measurement.kpis);
}

TEST(Campaign, DoesARunAgainThatDidNotFinish) {
  const test::TemporaryDirectory directory;
  const test::SyntheticEngine engine(0.1);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), workers(1));
  const auto outcome = campaign.outcomes(cases(1)).front();
  const auto folder = directory.path() / "runs" / outcome.key;
  campaign.store().forget(outcome.key);
  std::ofstream(folder / "output" / "half a file") << "x";
  EXPECT_EQ(campaign.outcomes(cases(1)).front().measurement.kpis, outcome.measurement.kpis);
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
  const Campaign campaign(directory.path(), StoppedOnce(), test::SyntheticEngine::measure(),
                          workers(1));
  EXPECT_THROW(campaign.outcomes(cases(1)), Interrupted);
  EXPECT_EQ(campaign.outcomes(cases(1)).front().measurement.kpis.at("third"), 3.0);
}

TEST(Campaign, RecordsFailuresWithTheirReasonAndDoesNotRepeatThem) {
  const test::TemporaryDirectory directory;
  test::SyntheticEngine engine(0.0);
  engine.failing_above(0.25);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), workers(2));
  const auto outcomes = campaign.outcomes(cases(5));
  EXPECT_FALSE(outcomes[2].failed());
  EXPECT_TRUE(outcomes[3].failed());
  const auto again = campaign.outcomes(cases(5))[4];
  for (const auto& outcome : {outcomes[4], again}) {
    EXPECT_EQ(outcome.measurement.outcome, Outcome::crash);
    EXPECT_EQ(outcome.measurement.failure, "it broke");
  }
  EXPECT_EQ(engine.runs(), 5);
}

TEST(Campaign, RefusesASecondProcessInItsDirectory) {
  const test::TemporaryDirectory directory;
  const Campaign first(directory.path(), test::SyntheticEngine(0), test::SyntheticEngine::measure(),
                       {});
  try {
    Campaign(directory.path(), test::SyntheticEngine(0), test::SyntheticEngine::measure(), {});
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find(fmt::format("process {} on ", ::getpid())),
              std::string::npos)
        << error.what();
  }
}

TEST(Campaign, StopsWhenToldAndKeepsWhatIsDone) {
  const test::TemporaryDirectory directory;
  std::atomic<Stop> stop{Stop::no};
  const test::SyntheticEngine engine(0.1);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(),
                          {.compute = {.workers = 1}, .stop = &stop});
  EXPECT_THROW(campaign.outcomes(cases(6),
                                 [&](double done, double, std::string_view) {
                                   if (done >= 3.0) stop = Stop::when_runs_end;
                                 }),
               Interrupted);
  EXPECT_EQ(engine.runs(), 3);
  stop = Stop::no;
  campaign.outcomes(cases(6));
  EXPECT_EQ(engine.runs(), 6);
}

TEST(Campaign, StopsAtOnceWhenNoRunCanSucceedAndRecordsNothing) {
  const test::TemporaryDirectory directory;
  struct FullDisk {
    std::string name() const { return "full disk"; }
    EngineExit run(const EngineJob&) const { throw StorageError("no space left on device"); }
  };
  const Campaign campaign(directory.path(), FullDisk(), test::SyntheticEngine::measure(),
                          workers(2));
  EXPECT_THROW(campaign.outcomes(cases(5)), StorageError);
  EXPECT_EQ(campaign.store().size(), 0U);
}

TEST(Campaign, DoesATimedOutRunAgainOnlyWithMoreTime) {
  struct Slow {
    std::shared_ptr<std::atomic<int>> runs = std::make_shared<std::atomic<int>>(0);
    std::string name() const { return "slow"; }
    EngineExit run(const EngineJob&) const {
      ++*runs;
      return {.status = EngineStatus::timed_out,
              .message = "it exceeded the time limit",
              .resources = {.wall_time_s = 1.0}};
    }
  };
  const test::TemporaryDirectory directory;
  const Slow slow;
  for (const auto& [limit, runs] :
       {std::pair{10.0, 1}, std::pair{10.0, 1}, std::pair{5.0, 1}, std::pair{20.0, 2}}) {
    const Campaign campaign(directory.path(), slow, test::SyntheticEngine::measure(),
                            {.compute = {.workers = 1, .time_limit_s = limit}});
    EXPECT_EQ(campaign.outcomes(cases(1)).front().measurement.outcome, Outcome::time_limit);
    EXPECT_EQ(*slow.runs, runs) << limit;
  }
}

TEST(Campaign, CallsARunWithoutAnyFiniteKpiAFailure) {
  const test::TemporaryDirectory directory;
  const Measure measure{"none", [](const std::filesystem::path&) {
                          Measurement m;
                          m.kpis = {{"angle_deg", std::nan("")}};
                          return m;
                        }};
  for (int call = 0; call < 2; ++call) {  // computed, then read back
    const Campaign campaign(directory.path(), test::SyntheticEngine(0), measure, workers(1));
    const auto outcome = campaign.outcomes(cases(1)).front();
    EXPECT_EQ(outcome.measurement.outcome, Outcome::non_finite);
    EXPECT_NE(outcome.measurement.failure.find("angle_deg is undefined"), std::string::npos);
    EXPECT_TRUE(outcome.measurement.kpis.empty());
  }
}

TEST(Campaign, KeepsTheKpisThatAreDefined) {
  const test::TemporaryDirectory directory;
  const Measure measure{"some", [](const std::filesystem::path&) {
                          Measurement m;
                          m.kpis = {{"angle_deg", std::nan("")}, {"mass_kg", 2.5}};
                          return m;
                        }};
  for (int call = 0; call < 2; ++call) {
    const Campaign campaign(directory.path(), test::SyntheticEngine(0), measure, workers(1));
    const auto outcome = campaign.outcomes(cases(1)).front();
    EXPECT_EQ(outcome.measurement.outcome, Outcome::kpi_undefined);
    EXPECT_FALSE(outcome.failed());
    EXPECT_EQ(outcome.measurement.kpi("mass_kg"), 2.5);
    EXPECT_EQ(outcome.measurement.kpi("angle_deg"), std::nullopt);
  }
}

TEST(Campaign, MeasuresAFinishedRunAgainForOtherKpisWithoutRunningIt) {
  const test::TemporaryDirectory directory;
  const test::SyntheticEngine engine(0.1);
  const auto kpis = Campaign(directory.path(), engine, test::SyntheticEngine::measure(), workers(1))
                        .outcomes(cases(3))[2]
                        .measurement.kpis;
  Measure other = test::SyntheticEngine::measure();
  other.name = "with a sum";
  other.of = [of = other.of](const std::filesystem::path& output) {
    auto m = of(output);
    m.kpis["sum"] = m.kpis["first"] + m.kpis["second"];
    return m;
  };
  for (int call = 0; call < 2; ++call) {
    const auto outcome =
        Campaign(directory.path(), engine, other, workers(1)).outcomes(cases(3))[2];
    EXPECT_EQ(outcome.measurement.kpi("sum"), kpis.at("first") + kpis.at("second"));
    EXPECT_EQ(outcome.measured_by, "with a sum");
  }
  EXPECT_EQ(engine.runs(), 3);
}

TEST(Campaign, SharesFinishedRunsThroughAStore) {
  const test::TemporaryDirectory one, two, store;
  const test::SyntheticEngine engine(0.1);
  const CampaignOptions options{.compute = {.workers = 2, .store = store.path()}};
  const Campaign first(one.path(), engine, test::SyntheticEngine::measure(), options);
  const auto of_first = first.outcomes(cases(4));
  // Two campaigns may be at work at once, each in its own directory.
  const Campaign second(two.path(), engine, test::SyntheticEngine::measure(), options);
  const auto of_second = second.outcomes(cases(6));
  EXPECT_EQ(engine.runs(), 6);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(of_second[i].key, of_first[i].key);
  EXPECT_EQ(first.outcomes(cases(6))[5].measurement.kpis, of_second[5].measurement.kpis);
  EXPECT_EQ(engine.runs(), 6);
}

/// Fails for seeds below a bound, as an unlucky packing does.
struct Unlucky {
  std::uint64_t bound;
  std::shared_ptr<std::atomic<int>> runs = std::make_shared<std::atomic<int>>(0);
  std::string name() const { return "unlucky"; }
  EngineExit run(const EngineJob& job) const {
    ++*runs;
    const auto seed = scene::read_case(job.directory / "case.toml").seed;
    if (seed < bound)
      return {.failure = Outcome::particles_lost, .message = "sphere 7 left the domain"};
    std::filesystem::create_directories(job.directory / "output");
    std::ofstream(job.directory / "output" / "kpis.txt") << "1 2 3";
    return {.status = EngineStatus::finished};
  }
};

TEST(Campaign, RetriesAFailedRunWithANewSeed) {
  const test::TemporaryDirectory directory;
  const Unlucky engine{.bound = 1000};  // the seeds of cases() are below, derived ones hardly ever
  const CampaignOptions options{.compute = {.workers = 2}, .failures = {.retries = 2}};
  std::vector<RunOutcome> first;
  for (int call = 0; call < 2; ++call) {
    const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), options);
    const auto outcomes = campaign.outcomes(cases(5));
    for (const auto& outcome : outcomes) {
      EXPECT_EQ(outcome.measurement.outcome, Outcome::finished);
      EXPECT_GE(outcome.seed, 1000U);
    }
    if (call == 0) first = outcomes;
    for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(outcomes[i].key, first[i].key);
    EXPECT_EQ(*engine.runs, 10);  // each failed once
  }
}

TEST(Campaign, GivesUpRetryingAfterTheLastAttempt) {
  const test::TemporaryDirectory directory;
  const Unlucky engine{.bound = ~std::uint64_t{0}};
  const CampaignOptions options{.compute = {.workers = 1}, .failures = {.retries = 2}};
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), options);
  EXPECT_EQ(campaign.outcomes(cases(1)).front().measurement.outcome, Outcome::particles_lost);
  EXPECT_EQ(*engine.runs, 3);
}

TEST(Campaign, StopsWhenTooLargeAShareFailsAndKeepsWhatItHas) {
  const test::TemporaryDirectory directory;
  test::SyntheticEngine engine(0.0);
  engine.failing_above(0.55);  // the 6th and all after
  const CampaignOptions options{.compute = {.workers = 1}, .failures = {.stop_above = 0.5}};
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), options);
  try {
    campaign.outcomes(cases(30));
    FAIL();
  } catch (const SimulationError& error) {  // at 6 + 7 of 13
    EXPECT_NE(std::string(error.what()).find("7 of 13 runs failed (7 crash), more than the share"),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(campaign.store().size(), 13U);
}

TEST(Campaign, SumsWhatAllPartsOfARunHaveUsed) {
  struct Stopping {
    std::shared_ptr<std::atomic<int>> parts = std::make_shared<std::atomic<int>>(0);
    std::string name() const { return "stopping"; }
    EngineExit run(const EngineJob& job) const {
      const int part = ++*parts;
      std::filesystem::create_directories(job.directory / "output");
      std::ofstream(scene::checkpoint_file(job.directory / "output")) << "state";
      std::ofstream(job.directory / "output" / "kpis.txt") << "1 2 3";
      return {.status = part < 3 ? EngineStatus::cancelled : EngineStatus::finished,
              .message = "",
              .resources = {.wall_time_s = 1.0 * part,
                            .cpu_time_s = 10.0 * part,
                            .peak_memory_bytes = part == 2 ? 5000 : 1000}};
    }
  };
  const test::TemporaryDirectory directory;
  const Campaign campaign(directory.path(), Stopping(), test::SyntheticEngine::measure(),
                          workers(1));
  EXPECT_THROW(campaign.outcomes(cases(1)), Interrupted);
  EXPECT_THROW(campaign.outcomes(cases(1)), Interrupted);
  const auto used = campaign.outcomes(cases(1)).front().resources;
  EXPECT_EQ(used.wall_time_s, 6.0);
  EXPECT_EQ(used.cpu_time_s, 60.0);
  EXPECT_EQ(used.peak_memory_bytes, 5000);
  EXPECT_EQ(used.parts, 3);
}

TEST(Campaign, BelievesThatARunIsTooMuchForTheMachineWhenItWasKilledThreeTimes) {
  struct Killed {
    int times;
    std::shared_ptr<std::atomic<int>> runs = std::make_shared<std::atomic<int>>(0);
    std::string name() const { return fmt::format("killed {} times", times); }
    EngineExit run(const EngineJob& job) const {
      if (++*runs <= times) return {.status = EngineStatus::killed, .message = "by signal 9"};
      std::filesystem::create_directories(job.directory / "output");
      std::ofstream(job.directory / "output" / "kpis.txt") << "1 2 3";
      return {.status = EngineStatus::finished};
    }
  };
  for (const auto& [times, outcome] :
       {std::pair{2, Outcome::finished}, std::pair{3, Outcome::killed}}) {
    const test::TemporaryDirectory directory;
    const Killed engine{.times = times};
    const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), workers(1));
    EXPECT_EQ(campaign.outcomes(cases(1)).front().measurement.outcome, outcome);
    EXPECT_EQ(*engine.runs, 3);
  }
}

rlimit file_size_limit() {
  rlimit limit{};
  ::getrlimit(RLIMIT_FSIZE, &limit);
  return limit;
}

/// Fills the disk in its fourth run.
struct Filling {
  test::SyntheticEngine engine{0.1};
  std::string name() const { return "filling"; }
  EngineExit run(const EngineJob& job) const {
    const auto exit = engine.run(job);
    const rlimit full{.rlim_cur = 10, .rlim_max = file_size_limit().rlim_max};
    if (engine.runs() == 4) ::setrlimit(RLIMIT_FSIZE, &full);
    return exit;
  }
};

TEST(Campaign, GoesOnAfterAFullDisk) {
  const test::TemporaryDirectory directory;
  const Filling filling;
  const auto unlimited = file_size_limit();
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  {
    const Campaign campaign(directory.path(), filling, test::SyntheticEngine::measure(),
                            workers(1));
    EXPECT_THROW(campaign.outcomes(cases(6)), StorageError);
    EXPECT_THROW(campaign.outcomes(cases(6)), StorageError);  // it is still full
  }
  ::setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, previous);
  const Campaign campaign(directory.path(), filling, test::SyntheticEngine::measure(), workers(1));
  EXPECT_EQ(campaign.store().size(), 3U);
  for (const auto& outcome : campaign.outcomes(cases(6)))
    EXPECT_EQ(outcome.measurement.outcome, Outcome::finished);
  EXPECT_EQ(filling.engine.runs(), 7);  // that the fourth had finished could not be noted
}

TEST(Campaign, DoesNotRepeatARunThatAnotherOneIsDoing) {
  struct Slow {
    test::SyntheticEngine engine{0.1};
    std::string name() const { return "slow"; }
    EngineExit run(const EngineJob& job) const {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      return engine.run(job);
    }
  };
  const test::TemporaryDirectory store;
  const Slow engine;
  std::vector<std::thread> studies;
  for (int s = 0; s < 3; ++s)
    studies.emplace_back([&] {
      const test::TemporaryDirectory directory;
      const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(),
                              {.compute = {.workers = 2, .store = store.path()}});
      for (const auto& outcome : campaign.outcomes(cases(6)))
        EXPECT_EQ(outcome.measurement.outcome, Outcome::finished);
    });
  for (auto& study : studies) study.join();
  EXPECT_EQ(engine.engine.runs(), 6);
}

TEST(Campaign, TakesWhatAnotherOneDidWithMoreTimeWhileItWaited) {
  struct Once {
    std::shared_ptr<std::atomic<int>> runs = std::make_shared<std::atomic<int>>(0);
    std::string name() const { return "once"; }
    EngineExit run(const EngineJob& job) const {
      ++*runs;
      if (job.time_limit_s < 15.0) return {.status = EngineStatus::timed_out};
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      std::filesystem::create_directories(job.directory / "output");
      std::ofstream(job.directory / "output" / "kpis.txt") << "1 2 3";
      return {.status = EngineStatus::finished};
    }
  };
  const test::TemporaryDirectory store, before;
  const Once engine;
  const auto options = [&](double limit) {
    return CampaignOptions{.compute = {.workers = 1, .time_limit_s = limit, .store = store.path()}};
  };
  Campaign(before.path(), engine, test::SyntheticEngine::measure(), options(10)).run(cases(1));
  std::vector<std::thread> studies;
  for (int s = 0; s < 2; ++s)
    studies.emplace_back([&] {
      const test::TemporaryDirectory directory;
      const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(),
                              options(20));
      EXPECT_FALSE(campaign.outcomes(cases(1)).front().failed());
    });
  for (auto& study : studies) study.join();
  EXPECT_EQ(*engine.runs, 2);
}

TEST(Campaign, LimitsTheTimeOfAllPartsOfARunTogether) {
  struct Stopping {
    std::shared_ptr<std::vector<double>> limits = std::make_shared<std::vector<double>>();
    std::string name() const { return "stopping"; }
    EngineExit run(const EngineJob& job) const {
      limits->push_back(job.time_limit_s);
      std::filesystem::create_directories(job.directory / "output");
      std::ofstream(scene::checkpoint_file(job.directory / "output")) << "state";
      return {.status = EngineStatus::cancelled, .resources = {.wall_time_s = 40.0}};
    }
  };
  const test::TemporaryDirectory directory;
  const Stopping engine;
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(),
                          {.compute = {.workers = 1, .time_limit_s = 100.0}});
  for (int part = 0; part < 4; ++part) EXPECT_THROW(campaign.outcomes(cases(1)), Interrupted);
  EXPECT_EQ((*engine.limits)[0], 100.0);
  EXPECT_EQ((*engine.limits)[1], 60.0);
  EXPECT_EQ((*engine.limits)[2], 20.0);
  EXPECT_LT((*engine.limits)[3], 0.1);
  EXPECT_GT((*engine.limits)[3], 0.0);  // 0 would be without a limit
}

TEST(Campaign, OnlyMeasuresARunThatFinishedBeforeItWasKilled) {
  const test::TemporaryDirectory directory;
  const test::SyntheticEngine engine(0.1);
  const Measure killed{"synthetic", [](const std::filesystem::path&) -> Measurement {
                         throw Error(ErrorKind::internal, "killed here");
                       }};
  EXPECT_THROW(Campaign(directory.path(), engine, killed, workers(1)).run(cases(2)), Error);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), workers(1));
  const auto outcomes = campaign.outcomes(cases(2));
  EXPECT_EQ(engine.runs(), 2);
  EXPECT_EQ(outcomes[0].resources.wall_time_s, 0.01);
}

TEST(Campaign, ReadsAnOutputAgainThatCouldNotBeReadOnce) {
  const test::TemporaryDirectory directory;
  const test::SyntheticEngine engine(0.1);
  const Measure unlucky{"synthetic", [](const std::filesystem::path&) -> Measurement {
                          throw StorageError("too many open files");
                        }};
  EXPECT_EQ(Campaign(directory.path(), engine, unlucky, workers(1))
                .outcomes(cases(1))[0]
                .measurement.outcome,
            Outcome::output_unreadable);
  const Campaign campaign(directory.path(), engine, test::SyntheticEngine::measure(), workers(1));
  EXPECT_EQ(campaign.outcomes(cases(1))[0].measurement.outcome, Outcome::finished);
  EXPECT_EQ(engine.runs(), 1);
}

TEST(Campaign, SaysWhereItCannotWrite) {
  const test::TemporaryDirectory directory;
  std::ofstream(directory / "file") << "x";
  for (const auto& place : {directory / "file", directory / "file/below"})
    EXPECT_THROW(
        Campaign(place, test::SyntheticEngine(0), test::SyntheticEngine::measure(), workers(1)),
        StorageError)
        << place;
  EXPECT_THROW(
      Campaign(directory / "new", test::SyntheticEngine(0), test::SyntheticEngine::measure(),
               {.compute = {.store = directory / "file/store"}}),
      StorageError);
}

}  // namespace
}  // namespace repose::dem_adapter

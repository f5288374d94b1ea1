// campaign.toml, the table of its runs, and looking after its directory.
#include "repose/dem_adapter/campaign_file.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "repose/base/error.hpp"
#include "repose/dem_adapter/campaign_upkeep.hpp"
#include "repose/table/io.hpp"
#include "synthetic_scenario.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

const std::string kScenario = "scenario = { scenario = \"drawdown\", preset = \"quick\" }\n";

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file) << text;
}

TEST(CampaignFile, MakesACaseForEachPointAndRepetition) {
  const test::TemporaryDirectory directory;
  write(directory / "points.csv", "mu_s,mu_r_pp\n0.3,0.1\n0.5,0.2\n");
  write(directory / "campaign.toml", kScenario + R"(points = "points.csv"
seed = 4
repetitions = 3
[ties]
mu_s_pp = ["mu_s"]
mu_s_ss = ["mu_s"]
[fixed]
c_r_pp = 0.6
)");
  const auto file = read_campaign(directory.path());
  ASSERT_EQ(file.runs(), 6U);
  std::set<std::uint64_t> seeds;
  for (std::size_t i = 0; i < 6; ++i) {
    const auto scene = scene::parse_case(file.make_input(i).text, "input");
    EXPECT_EQ(scene.pairs[0].mu_s, i < 3 ? 0.3 : 0.5);
    EXPECT_EQ(scene.pairs[0].mu_r, i < 3 ? 0.1 : 0.2);
    EXPECT_EQ(scene.pairs[0].restitution, 0.6);
    seeds.insert(scene.seed);
  }
  EXPECT_EQ(seeds.size(), 6U);
}

TEST(CampaignFile, WithoutPointsRepeatsTheScenario) {
  const test::TemporaryDirectory directory;
  write(directory / "campaign.toml", kScenario + "repetitions = 5\n");
  EXPECT_EQ(read_campaign(directory.path()).runs(), 5U);
}

TEST(CampaignFile, NamesWhatIsWrong) {
  const auto refused = [](const std::string& points, const std::string& more,
                          const std::string& part) {
    const test::TemporaryDirectory directory;
    write(directory / "points.csv", points);
    write(directory / "campaign.toml", kScenario + "points = \"points.csv\"\n" + more);
    try {
      read_campaign(directory.path());
      FAIL() << part;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  refused("mu_s_pq\n0.3\n", "", "did you mean mu_s_p");
  refused("mu_s_pp\n", "", "no rows");
  refused("name\nx\n", "", "no parameters");
  refused("mu_s_pp\n0.3\n", "repetition = 2\n", "repetition");
  refused("outlet_m\n9\n", "", "point 1 of the campaign cannot be simulated");
  refused("mass_flow_kg_s\n9\n", "", "taken by a column");
  const test::TemporaryDirectory empty;
  EXPECT_THROW(read_campaign(empty.path()), StorageError);
}

/// A campaign of five points, the last two of which fail.
struct Small {
  CampaignFile file{.title = "small", .scenario = test::SyntheticScenario(), .repetitions = 2};
  test::SyntheticEngine engine{0.1};
  Small() {
    for (const char* name : {"a", "b", "c", "d", "e"})
      file.points.add({.name = name,
                       .role = table::Role::factor,
                       .values = std::vector<double>{0.1, 0.2, 0.3, 0.8, 0.9}});
    file.compute.workers = 1;
    engine.failing_above(0.5);
  }
  void run(const std::filesystem::path& directory) const {
    const Campaign campaign(directory, engine, test::SyntheticEngine::measure(),
                            {.compute = file.compute, .failures = file.failures});
    campaign.run(file.wanted_runs());
  }
  table::Table table(const std::filesystem::path& directory) const {
    const auto plan = read_plan(directory);
    write_campaign_table(directory / "runs.h5", file, *plan,
                         RunStore(plan->store, StoreAccess::read), "typed");
    return table::read_table({directory / "runs.h5", ""}, table::Missing::allow);
  }
};

TEST(CampaignTable, HasARowForEachRunWithItsOutcome) {
  const test::TemporaryDirectory directory;
  const Small small;
  small.run(directory.path());
  const auto table = small.table(directory.path());
  ASSERT_EQ(table.rows(), 10U);
  EXPECT_EQ(table.integers("point"), (std::vector<std::int64_t>{1, 1, 2, 2, 3, 3, 4, 4, 5, 5}));
  EXPECT_EQ(table.numbers("a")[4], 0.3);
  EXPECT_EQ(table.names_with_role(table::Role::factor).size(), 5U);
  EXPECT_EQ(table.texts("outcome")[5], "finished");
  EXPECT_EQ(table.texts("outcome")[6], "crash");
  EXPECT_EQ(table.texts("failure")[6], "it broke");
  EXPECT_TRUE(std::isnan(table.numbers("first")[6]));
  EXPECT_TRUE(std::isfinite(table.numbers("first")[5]));
}

TEST(CampaignTable, GivesFailedRunsTheirPenalty) {
  const test::TemporaryDirectory directory;
  Small small;
  small.file.failures.penalty = {{"first", 90.0}};
  small.run(directory.path());
  const auto table = small.table(directory.path());
  EXPECT_EQ(table.numbers("first")[6], 90.0);
  EXPECT_TRUE(std::isnan(table.numbers("second")[6]));
  EXPECT_NE(table.numbers("first")[5], 90.0);
}

TEST(CampaignTable, HoldsWhatIsThereSoFar) {
  const test::TemporaryDirectory directory;
  const Small small;
  small.run(directory.path());
  const auto plan = *read_plan(directory.path());
  RunStore(directory.path(), StoreAccess::write).forget(plan.runs[2].front());
  EXPECT_EQ(small.table(directory.path()).rows(), 9U);
}

TEST(CampaignStatus, CountsOutcomesAndWhatIsMissing) {
  const test::TemporaryDirectory directory;
  const Small small;
  small.run(directory.path());
  const auto plan = *read_plan(directory.path());
  {
    const RunStore store(directory.path(), StoreAccess::write);
    store.forget(plan.runs[2].front());
    store.forget(plan.runs[3].front());
  }
  const auto claim =
      RunClaim::take(directory.path() / "runs" / plan.runs[3].front(), [] { return false; });
  const auto status = campaign_status(directory.path());
  EXPECT_EQ(status.wanted, 10U);
  EXPECT_EQ(status.settled, 8U);
  EXPECT_EQ(status.failed(), 4U);
  EXPECT_EQ(status.counts.at(Outcome::crash), 4U);
  EXPECT_EQ(status.under_way, 1U);
  EXPECT_EQ(status.stopped, 1U);
  EXPECT_NE(status.examples.at(Outcome::crash).find("it broke"), std::string::npos);
  const test::TemporaryDirectory empty;
  EXPECT_THROW(campaign_status(empty.path()), StorageError);
  EXPECT_THROW(campaign_status(empty / "nowhere"), StorageError);
}

TEST(CampaignRetry, HasOnlyTheRunsOfTheseOutcomesDoneAgain) {
  const test::TemporaryDirectory directory;
  const Small small;
  small.run(directory.path());
  EXPECT_EQ(small.engine.runs(), 10);
  EXPECT_TRUE(retry_runs(directory.path(), {Outcome::time_limit}).empty());
  EXPECT_EQ(retry_runs(directory.path(), {Outcome::crash, Outcome::killed}).size(), 4U);
  EXPECT_EQ(campaign_status(directory.path()).settled, 6U);
  small.run(directory.path());
  EXPECT_EQ(small.engine.runs(), 14);
}

TEST(CampaignRetry, LeavesRunsAloneThatANewSeedHasSaved) {
  const test::TemporaryDirectory directory;
  struct Unlucky {  // the first seed of every run fails
    std::shared_ptr<std::set<std::string>> seen = std::make_shared<std::set<std::string>>();
    std::string name() const { return "unlucky"; }
    EngineExit run(const EngineJob& job) const {
      const auto c = scene::read_case(job.directory / "case.toml");
      if (seen->insert(fmt::format("{}", c.pairs[0].mu_s)).second)
        return {.failure = Outcome::particles_lost, .message = "lost"};
      std::filesystem::create_directories(job.directory / "output");
      write(job.directory / "output" / "kpis.txt", "1 2 3");
      return {.status = EngineStatus::finished};
    }
  };
  Small small;
  small.file.repetitions = 1;
  small.file.failures.retries = 1;
  {
    const Campaign campaign(directory.path(), Unlucky(), test::SyntheticEngine::measure(),
                            {.compute = small.file.compute, .failures = small.file.failures});
    campaign.run(small.file.wanted_runs());
  }
  EXPECT_EQ(campaign_status(directory.path()).failed(), 0U);
  EXPECT_TRUE(retry_runs(directory.path(), {Outcome::particles_lost}).empty());
  EXPECT_EQ(retry_runs(directory.path(), {Outcome::finished}).size(), 10U);  // both attempts of 5
}

TEST(CampaignTable, IsRefusedWhereThePointsAreOthersNow) {
  const test::TemporaryDirectory directory;
  Small small;
  small.run(directory.path());
  small.file.repetitions = 1;
  try {
    small.table(directory.path());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("run 2 is another one now"), std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(directory / "runs.h5"));
}

TEST(CampaignFile, GivesEveryPointTheSameSeedsIfTold) {
  const test::TemporaryDirectory directory;
  write(directory / "points.csv", "mu_s_pp\n0.3\n0.5\n");
  write(directory / "campaign.toml",
        "points = \"points.csv\"\nrepetitions = 2\nseeds = \"common\"\n" + kScenario);
  const auto file = read_campaign(directory.path());
  EXPECT_EQ(file.make_input(0).seed, file.make_input(2).seed);
  EXPECT_EQ(file.make_input(1).seed, file.make_input(3).seed);
  EXPECT_NE(file.make_input(0).seed, file.make_input(1).seed);
  EXPECT_NE(file.make_input(0).text, file.make_input(2).text);
}

TEST(CampaignUpkeep, IsRefusedWhileTheCampaignRuns) {
  const test::TemporaryDirectory directory;
  const Small small;
  small.run(directory.path());
  const Campaign campaign(directory.path(), small.engine, test::SyntheticEngine::measure(), {});
  EXPECT_THROW(retry_runs(directory.path(), {Outcome::crash}), StorageError);
  EXPECT_THROW(clean_campaign(directory.path()), StorageError);
  EXPECT_NE(campaign_status(directory.path()).owner, "");
}

TEST(CampaignClean, RemovesStoppedRunsAndKeepsKpisWithoutTheirOutputs) {
  const test::TemporaryDirectory directory;
  const Small small;
  small.run(directory.path());
  const auto key = read_plan(directory.path())->runs[2].front();
  RunStore(directory.path(), StoreAccess::write).forget(key);
  const auto cleaned = clean_campaign(directory.path(), {.outputs = CleanOutputs::remove});
  EXPECT_EQ(cleaned.stopped, 1U);
  EXPECT_EQ(cleaned.outputs, 5U);
  EXPECT_GT(cleaned.bytes, 0U);
  EXPECT_FALSE(std::filesystem::exists(directory.path() / "runs" / key));
  small.run(directory.path());
  EXPECT_EQ(small.engine.runs(), 11);  // the one that had been forgotten
  EXPECT_TRUE(std::isfinite(small.table(directory.path()).numbers("first")[0]));
}

TEST(CampaignClean, RemovesRunsOfNoPlanButNotFromASharedStore) {
  const test::TemporaryDirectory directory, sharing;
  Small small;
  small.run(directory.path());
  small.file.repetitions = 1;
  small.run(directory.path());
  EXPECT_EQ(clean_campaign(directory.path(), {.unplanned = CleanUnplanned::remove}).unplanned, 5U);
  EXPECT_EQ(campaign_status(directory.path()).recorded, 5U);
  small.file.compute.store = directory.path();
  small.run(sharing.path());
  EXPECT_EQ(small.engine.runs(), 10);
  EXPECT_EQ(campaign_status(sharing.path()).settled, 5U);
  EXPECT_THROW(clean_campaign(sharing.path(), {.unplanned = CleanUnplanned::remove}), InputError);
}

TEST(CampaignClean, KeepsRunsThatOtherStudiesWant) {
  const test::TemporaryDirectory store, sharing;
  Small small;
  small.file.compute.store = store.path();
  small.run(sharing.path());
  const auto stopped = read_plan(sharing.path())->runs[2].front();
  RunStore(store.path(), StoreAccess::write).forget(stopped);
  std::filesystem::create_directories(store.path() / "runs/nobody");
  // The store has no plan of its own; somebody else's runs are not without a plan.
  const auto cleaned = clean_campaign(store.path(), {.unplanned = CleanUnplanned::remove});
  EXPECT_EQ(cleaned.unplanned, 0U);
  EXPECT_EQ(cleaned.stopped, 1U);  // "nobody"
  EXPECT_TRUE(std::filesystem::exists(store.path() / "runs" / stopped));
  EXPECT_EQ(campaign_status(sharing.path()).settled, 9U);
  // A study that is gone wants nothing.
  std::filesystem::remove_all(sharing.path());
  EXPECT_EQ(clean_campaign(store.path(), {.unplanned = CleanUnplanned::remove}).unplanned, 0U);
}

}  // namespace
}  // namespace repose::dem_adapter

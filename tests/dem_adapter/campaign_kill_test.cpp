// A campaign of 200 runs that is killed at 50 random instants ends as one that nobody disturbed.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <map>
#include <thread>

#include "repose/base/random.hpp"
#include "repose/dem_adapter/campaign_file.hpp"
#include "repose/dem_adapter/campaign_upkeep.hpp"
#include "repose/table/io.hpp"
#include "repose/table/operations.hpp"
#include "synthetic_scenario.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

using Clock = std::chrono::steady_clock;

/// Stands beside repose-dem: its KPIs are digits of its case's checksum. One case in seven loses a
/// particle, one in eleven is killed the first time.
constexpr auto kFakeEngine = R"sh(#!/bin/sh
sum=$(cksum < "$1"); sum=${sum%% *}
folder=${1%/*}
if [ $((sum % 11)) = 0 ] && [ ! -e "$folder/was_killed" ]; then : > "$folder/was_killed"; kill -9 $$; fi
if [ $((sum % 7)) = 0 ]; then echo "sphere 1 left the domain" >&2; exit 5; fi
mkdir -p "$3"
echo "$((sum % 1000)) " > "$3/half.txt"
echo "$((sum % 1000)) $((sum % 97)) $((sum % 13))" > "$3/kpis.txt"
)sh";

CampaignFile campaign_file() {
  CampaignFile file{.title = "fake", .scenario = test::SyntheticScenario(), .repetitions = 4};
  RandomStream random(5);
  for (const char* name : {"a", "b", "c", "d", "e"}) {
    std::vector<double> values;
    for (int i = 0; i < 50; ++i) values.push_back(random.uniform());
    file.points.add({.name = name, .role = table::Role::factor, .values = values});
  }
  file.failures.retries = 1;
  file.compute.workers = 2;
  return file;
}

void run(const std::filesystem::path& directory, const std::filesystem::path& engine) {
  const auto file = campaign_file();
  const Campaign campaign(directory, BundledEngine(engine), test::SyntheticEngine::measure(),
                          {.compute = file.compute, .failures = file.failures});
  campaign.run(file.wanted_runs());
}

/// The campaign in a process of its own, until it ends or `seconds` are over.
int run_and_kill(const std::filesystem::path& directory, const std::filesystem::path& engine,
                 double seconds) {
  const pid_t child = ::fork();
  if (child == 0) {
    try {
      run(directory, engine);
      ::_exit(0);
    } catch (const std::exception& error) {
      std::fputs(error.what(), stderr);
      ::_exit(1);
    }
  }
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (Clock::now() > end) ::kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
  return status;
}

/// All of the table that does not depend on clock and machine.
std::string table_text(const std::filesystem::path& directory) {
  const auto file = campaign_file();
  const auto plan = read_plan(directory);
  const RunStore store(plan->store, StoreAccess::read);
  const auto rows = write_campaign_table(directory / "runs.h5", file, *plan, store, "");
  EXPECT_EQ(rows, file.runs());
  auto table = table::read_table({directory / "runs.h5", ""}, table::Missing::allow);
  auto names = table.names();
  std::erase_if(names, [](const std::string& name) {
    return name == "wall_time_s" || name == "cpu_time_s" || name == "peak_memory_bytes";
  });
  return table::csv_text(table::selected_columns(table, names));
}

/// The file that holds each outcome; a run that is done again writes a new one.
std::map<std::string, ino_t> outcome_files(const std::filesystem::path& directory) {
  std::map<std::string, ino_t> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "runs")) {
    struct stat status {};
    if (::stat((entry.path() / "outcome.json").c_str(), &status) == 0)
      files[entry.path().filename()] = status.st_ino;
  }
  return files;
}

TEST(KilledCampaign, EndsWithTheTableOfAnUndisturbedOne) {
  const test::TemporaryDirectory straight, killed, programs;
  const auto engine = programs / "fake-dem";
  std::ofstream(engine) << kFakeEngine;
  ::chmod(engine.c_str(), 0755);
  const auto began = Clock::now();
  run(straight.path(), engine);
  const double straight_s = std::chrono::duration<double>(Clock::now() - began).count();

  constexpr int kKills = 50;
  RandomStream random(17);
  int kills = 0;
  std::map<std::string, ino_t> before;
  for (int i = 0; i < kKills; ++i) {
    // Some before the campaign has begun, most while it runs.
    const int status =
        run_and_kill(killed.path(), engine, random.uniform() * 2.0 * straight_s / kKills);
    kills += WIFSIGNALED(status) ? 1 : 0;
    if (!std::filesystem::exists(killed / "runs")) continue;
    const auto now = outcome_files(killed.path());
    for (const auto& [key, file] : before) {
      ASSERT_TRUE(now.count(key)) << key << " was lost";
      ASSERT_EQ(now.at(key), file) << key << " was done twice";
    }
    before = now;
    const auto state = campaign_status(killed.path());
    EXPECT_EQ(state.recorded, now.size());
    EXPECT_EQ(state.owner, "");
  }
  EXPECT_GE(kills, kKills / 2) << "it was finished before it was killed often enough";
  EXPECT_FALSE(before.empty());
  const int last = run_and_kill(killed.path(), engine, 1e6);
  ASSERT_TRUE(WIFEXITED(last));
  ASSERT_EQ(WEXITSTATUS(last), 0);
  EXPECT_EQ(table_text(killed.path()), table_text(straight.path()));

  const auto status = campaign_status(killed.path());
  EXPECT_EQ(status.settled, 200U);
  EXPECT_GT(status.counts.at(Outcome::finished), 150U);  // 1/49 of the runs fail twice
  EXPECT_EQ(status.counts.count(Outcome::killed), 0U);   // once is not believed
}

}  // namespace
}  // namespace repose::dem_adapter

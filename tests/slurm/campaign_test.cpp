// Campaigns of repose-dem through a real SLURM of one node, killed, cancelled and out of time, end
// as they do without it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "../integration/program.hpp"
#include "repose/table/io.hpp"
#include "repose/table/operations.hpp"

namespace repose {
namespace {

namespace fs = std::filesystem;
using test::Workbench;

// About 280 spheres: some tenths of a second a run.
const std::string kCampaign = R"(repetitions = 2
points = "points.csv"
[scenario]
scenario = "drawdown"
preset = "quick"
width_m = 0.16
outlet_m = 0.058
drop_m = 0.16
lower_width_m = 0.40
mass_per_thickness_kg_m = 15
settle_s = 0.1
discharge_s = 0.5
)";
const std::string kSlurm = R"([slurm]
ask_every_s = 1
)";

/// Notes each start in its run's folder.
const std::string kCounted = "echo start >> \"${1%/*}/starts\"\n";
const std::string kReposeDem = kCounted + "exec '" REPOSE_BIN "/repose-dem' \"$@\"\n";

class SlurmCampaign : public ::testing::Test {
 protected:
  void SetUp() override {
    const fs::path node = REPOSE_SLURM_NODE;
    if (fs::exists(node / "unavailable")) GTEST_SKIP() << test::text_of(node / "unavailable");
    if (!fs::exists(node / "slurm.conf"))
      GTEST_SKIP() << "no SLURM here: tests/slurm/one_node start " << node;
    ::setenv("SLURM_CONF", (node / "slurm.conf").c_str(), 1);
  }
  void TearDown() override {
    if (campaign_ > 0) ::kill(campaign_, SIGKILL);
  }

  void set_up(const std::string& folder, const std::string& compute, const std::string& engine,
              int points = 2) const {
    fs::create_directory(bench_ / folder);
    bench_.write(folder + "/campaign.toml", kCampaign + compute);
    std::string table = "mu_s_pp\n";
    for (int i = 0; i < points; ++i) table += std::to_string(0.3 + 0.05 * i) + "\n";
    bench_.write(folder + "/points.csv", table);
    bench_.write("engine", "#!/bin/sh\n" + engine);
    ::chmod((bench_ / "engine").c_str(), 0755);
  }
  void let_settle_long() const {
    auto text = test::text_of(bench_ / "c/campaign.toml");
    text.replace(text.find("settle_s = 0.1"), 14, "settle_s = 999");
    bench_.write("c/campaign.toml", text);
  }

  /// `repose campaign run` that goes on while the test does.
  void begin(const std::string& folder) {
    campaign_ = ::fork();
    if (campaign_ != 0) return;
    const int said = ::open((bench_ / "said").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    ::dup2(::open("/dev/null", O_RDONLY), 0);
    ::dup2(said, 1);
    ::dup2(said, 2);
    if (::chdir((bench_ / "").c_str()) == 0)
      ::execl(REPOSE_BIN "/repose", "repose", "campaign", "run", folder.c_str(), "--engine",
              "./engine", nullptr);
    ::_exit(127);
  }
  int end_of_campaign() {
    int status = 0;
    ::waitpid(campaign_, &status, 0);
    campaign_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string said() const { return test::text_of(bench_ / "said"); }
  nlohmann::json status() const {
    const auto said = bench_.run("repose", "campaign status c --json");
    return said.code == 0 ? nlohmann::json::parse(said.out) : nlohmann::json::object();
  }
  std::size_t count(const std::string& key) const {
    const auto s = status();
    return s.contains(key) ? s.at(key).get<std::size_t>() : 0;
  }
  /// For what must come; the test's time limit ends it otherwise.
  template <class Condition>
  static void wait_for(const Condition& condition) {
    while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  std::vector<fs::path> runs() const {
    std::vector<fs::path> folders;
    for (const auto& entry : fs::directory_iterator(bench_ / "c/runs"))
      folders.push_back(entry.path());
    return folders;
  }
  static long starts(const fs::path& run) {
    const auto text = test::text_of(run / "starts");
    return std::count(text.begin(), text.end(), '\n');
  }
  /// All of the table that does not depend on clock and machine.
  std::string table_text(const std::string& folder) const {
    auto table = table::read_table({bench_ / (folder + "/runs.h5"), ""}, table::Missing::allow);
    auto names = table.names();
    std::erase_if(names, [](const std::string& name) {
      return name == "wall_time_s" || name == "cpu_time_s" || name == "peak_memory_bytes";
    });
    return table::csv_text(table::selected_columns(table, names));
  }
  static bool is_queue_empty() { return std::system("test -z \"$(squeue -h -u $(id -u))\"") == 0; }

  const std::string to_slurm_ = "[compute]\nexecutor = \"slurm\"\n";
  Workbench bench_;
  pid_t campaign_ = 0;
};

TEST_F(SlurmCampaign, EndsWithTheTableOfALocalOneAlsoWhenItIsKilled) {
  constexpr int kPoints = 8;  // two runs each
  set_up("local", "", kReposeDem, kPoints);
  const auto local = bench_.run("repose", "campaign run local --engine ./engine");
  ASSERT_EQ(local.code, 0) << local.err;

  set_up("c", to_slurm_ + kSlurm, kReposeDem, kPoints);
  // Killed with all runs in the queue, then at the first and the fourth outcome; two run at once.
  for (const std::size_t outcomes : {0, 1, 4}) {
    begin("c");
    wait_for([&] {
      const auto s = status();
      return s.contains("settled") && s.at("settled") >= outcomes &&
             s.at("pending").get<int>() + s.at("running").get<int>() > 0;
    });
    ::kill(campaign_, SIGKILL);
    EXPECT_EQ(end_of_campaign(), 128 + SIGKILL);
    EXPECT_EQ(status().at("owner"), "");
  }
  begin("c");
  ASSERT_EQ(end_of_campaign(), 0) << said();
  EXPECT_EQ(table_text("c"), table_text("local"));
  for (const auto& run : runs()) EXPECT_EQ(starts(run), 1) << run;
  const auto table = table::read_table({bench_ / "c/runs.h5", ""}, table::Missing::allow);
  for (const double s : table.numbers("cpu_time_s")) EXPECT_GT(s, 0.0);  // measured on the node
  EXPECT_TRUE(fs::is_empty(bench_ / "c/slurm"));
}

TEST_F(SlurmCampaign, EndsRunsAtTheirTimeLimit) {
  set_up("c", to_slurm_ + "time_limit_s = 1.5\n" + kSlurm, kReposeDem, 1);
  let_settle_long();
  begin("c");
  ASSERT_EQ(end_of_campaign(), 0) << said();
  EXPECT_EQ(status().at("outcomes").at("time-limit"), 2);
  wait_for(is_queue_empty);
}

TEST_F(SlurmCampaign, DoesAgainWhatSomebodyElseCancelled) {
  set_up("c", to_slurm_ + kSlurm,
         kCounted + "[ $(wc -l < \"${1%/*}/starts\") -ge 2 ] && exit 5\nexec sleep 60\n", 1);
  begin("c");
  wait_for([&] { return count("running") == 2; });
  wait_for([&] {
    const auto all = runs();
    return std::all_of(all.begin(), all.end(), [](const auto& run) { return starts(run) == 1; });
  });
  ASSERT_EQ(std::system("scancel -u $(id -u)"), 0);
  ASSERT_EQ(end_of_campaign(), 0) << said();
  EXPECT_EQ(status().at("outcomes").at("engine-failed"), 2);
  for (const auto& run : runs()) EXPECT_EQ(starts(run), 2);
}

TEST_F(SlurmCampaign, EndsRunsWithACheckpointAtTheSecondCtrlC) {
  set_up("c", to_slurm_ + kSlurm, kReposeDem, 3);
  let_settle_long();
  begin("c");
  wait_for([&] { return count("running") > 0; });
  EXPECT_EQ(status().at("wanted"), 6);
  wait_for([&] {
    const auto all = runs();
    return std::any_of(all.begin(), all.end(), [](const auto& run) { return starts(run) == 1; });
  });
  std::this_thread::sleep_for(std::chrono::seconds(1));  // it has filled its box
  ::kill(campaign_, SIGINT);
  wait_for([&] { return said().find("no more runs are begun") != std::string::npos; });
  EXPECT_FALSE(is_queue_empty());
  ::kill(campaign_, SIGINT);
  EXPECT_EQ(end_of_campaign(), 130);
  wait_for(is_queue_empty);
  EXPECT_EQ(status().at("under_way"), 0);
  std::size_t checkpoints = 0;
  for (const auto& run : runs()) checkpoints += fs::exists(run / "output/checkpoint.h5") ? 1 : 0;
  EXPECT_GT(checkpoints, 0U);
}

TEST_F(SlurmCampaign, LeavesTheQueueAloneWhenItsTerminalCloses) {
  set_up("c", to_slurm_ + kSlurm, kCounted + "sleep 3\nexit 5\n", 1);
  begin("c");
  wait_for([&] { return count("running") == 2; });
  ::kill(campaign_, SIGHUP);
  EXPECT_EQ(end_of_campaign(), 128 + SIGHUP);
  EXPECT_EQ(count("running"), 2U);
  EXPECT_EQ(bench_.run("repose", "campaign clean c").code, 0);  // keeps what is in the queue
  const auto on_this_machine = test::text_of(bench_ / "c/campaign.toml");
  bench_.write("c/campaign.toml", kCampaign);
  const auto refused = bench_.run("repose", "campaign run c --engine ./engine");
  EXPECT_EQ(refused.code, 6) << refused.err;
  EXPECT_NE(refused.err.find("stands in the queue"), std::string::npos) << refused.err;
  bench_.write("c/campaign.toml", on_this_machine);
  wait_for(is_queue_empty);
  begin("c");
  EXPECT_EQ(end_of_campaign(), 0) << said();
  EXPECT_EQ(status().at("outcomes").at("engine-failed"), 2);
  for (const auto& run : runs()) EXPECT_EQ(starts(run), 1);
}

TEST_F(SlurmCampaign, GivesARunAsManyProcessesAsItHasRanks) {
  set_up("c", to_slurm_ + "ranks = 2\n" + kSlurm, kReposeDem, 1);
  begin("c");
  ASSERT_EQ(end_of_campaign(), 0) << said();
  EXPECT_EQ(status().at("outcomes").at("finished"), 2);
}

TEST_F(SlurmCampaign, PassesOnTheWordsOfAnSbatchThatRefuses) {
  set_up("c", to_slurm_ + kSlurm + "partition = \"long\"\n", kReposeDem, 1);
  const auto refused = bench_.run("repose", "campaign run c --engine ./engine");
  EXPECT_EQ(refused.code, 3) << refused.err;
  EXPECT_NE(refused.err.find("invalid partition specified: long"), std::string::npos)
      << refused.err;
}

}  // namespace
}  // namespace repose

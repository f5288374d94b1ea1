// repose campaign as a user calls it: around repose-dem, and around engines that misbehave.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "program.hpp"
#include "repose/table/io.hpp"
#include "repose/table/operations.hpp"

namespace repose {
namespace {

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

void set_up(const Workbench& bench, const std::string& more = "") {
  std::filesystem::create_directory(bench / "c");
  bench.write("c/campaign.toml", kCampaign + more);
  bench.write("c/points.csv", "mu_s_pp\n0.3\n0.5\n");
}

void write_engine(const Workbench& bench, const std::string& body) {
  bench.write("engine", "#!/bin/sh\n" + body + "\n");
  ::chmod((bench / "engine").c_str(), 0755);
}

nlohmann::json json_of(const Workbench& bench, const std::string& arguments) {
  const auto said = bench.run("repose", arguments + " --json");
  EXPECT_EQ(said.code, 0) << said.err;
  return nlohmann::json::parse(said.out);
}

/// `repose campaign run c --engine engine` that runs while the test goes on.
class Background {
 public:
  explicit Background(const Workbench& bench) : errors_(bench / "errors.txt") {
    child_ = ::fork();
    if (child_ != 0) return;
    const int nothing = ::open("/dev/null", O_RDWR);
    const int errors = ::open(errors_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    ::dup2(nothing, 0);
    ::dup2(nothing, 1);
    ::dup2(errors, 2);
    if (::chdir((bench / "").c_str()) == 0)
      ::execl(REPOSE_BIN "/repose", "repose", "campaign", "run", "c", "--workers", "1", "--engine",
              (bench / "engine").c_str(), nullptr);
    ::_exit(127);
  }
  ~Background() {
    if (child_ > 0) ::kill(child_, SIGKILL);
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  void signal(int number) const { ::kill(child_, number); }
  int exit_code() {
    int status = 0;
    ::waitpid(child_, &status, 0);
    child_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string errors() const { return test::text_of(errors_); }

 private:
  std::filesystem::path errors_;
  pid_t child_ = 0;
};

/// Waits for what must come; the test's time limit ends it otherwise.
template <class Condition>
void wait_for(const Condition& condition) {
  while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

TEST(CampaignCommand, RunsWhatIsMissingAndGivesATable) {
  const Workbench bench;
  set_up(bench);
  const auto status = json_of(bench, "campaign run c");
  EXPECT_EQ(status.at("wanted"), 4);
  EXPECT_EQ(status.at("settled"), 4);
  EXPECT_EQ(status.at("owner"), "");
  const auto table = table::read_table({bench / "c/runs.h5", ""}, table::Missing::allow);
  ASSERT_EQ(table.rows(), 4U);
  EXPECT_EQ(table.names_with_role(table::Role::factor), std::vector<std::string>{"mu_s_pp"});
  for (const double seconds : table.numbers("cpu_time_s")) EXPECT_GT(seconds, 0.0);
  EXPECT_EQ(table.texts("outcome")[0], "finished");

  EXPECT_EQ(json_of(bench, "campaign status c"), [&] {
    auto same = status;
    same.erase("table");
    return same;
  }());
  // Nothing is done twice: the same seconds stand there.
  EXPECT_EQ(json_of(bench, "campaign run c").at("wall_time_s"), status.at("wall_time_s"));
  EXPECT_EQ(json_of(bench, "campaign table c -o t.csv").at("rows"), 4);
  EXPECT_EQ(table::read_table({bench / "t.csv", ""}, table::Missing::allow).rows(), 4U);

  const auto key = table.texts("run")[0];
  ASSERT_EQ(json_of(bench, "campaign retry c --outcome finished").at("runs").size(), 4U);
  EXPECT_EQ(json_of(bench, "campaign status c").at("stopped"), 4);
  json_of(bench, "campaign run c");
  const auto again = table::read_table({bench / "c/runs.h5", ""}, table::Missing::allow);
  EXPECT_EQ(again.numbers("shear_angle_deg"), table.numbers("shear_angle_deg"));
  EXPECT_EQ(json_of(bench, "campaign clean c --outputs").at("outputs"), 4);
  EXPECT_FALSE(std::filesystem::exists(bench / "c/runs" / key / "output"));
  EXPECT_EQ(json_of(bench, "campaign status c").at("settled"), 4);
}

TEST(CampaignCommand, SettlesAFillingOnceThatRunsShare) {
  const Workbench bench;
  std::vector<std::string> kpis;
  for (const char* share : {"false", "true"}) {
    std::filesystem::remove_all(bench / "c");
    set_up(bench,
           "settle_coefficients = {restitution = 0.4, mu_s = 0.3, mu_r = 0.1}\n[compute]\n"
           "share_beginnings = " +
               std::string(share) + "\n");
    bench.write("c/campaign.toml",
                "seeds = \"common\"\n" + test::text_of(bench / "c/campaign.toml"));
    json_of(bench, "campaign run c");
    const auto table = table::read_table({bench / "c/runs.h5", ""}, table::Missing::allow);
    EXPECT_EQ(table.texts("outcome"), std::vector<std::string>(4, "finished"));
    EXPECT_NE(table.numbers("shear_angle_deg")[0], table.numbers("shear_angle_deg")[2]);
    kpis.push_back(table::csv_text(
        table::selected_columns(table, {"run", "seed", "shear_angle_deg", "angle_of_repose_deg"})));
  }
  EXPECT_EQ(kpis[0], kpis[1]);
  EXPECT_EQ(json_of(bench, "campaign clean c").at("beginnings"), 2);  // one a repetition
}

TEST(CampaignCommand, SaysWhatIsWrong) {
  const Workbench bench;
  set_up(bench);
  const auto refused = [&](const std::string& arguments, int code, const std::string& part) {
    const auto said = bench.run("repose", "campaign " + arguments);
    EXPECT_EQ(said.code, code) << said.err;
    EXPECT_NE(said.err.find(part), std::string::npos) << said.err;
  };
  refused("run c --engine /nowhere/repose-dem", 6, "cannot be run; check the path");
  refused("run nowhere", 6, "there is no 'nowhere/campaign.toml'");
  refused("status c", 6, "holds no runs");
  refused("table c", 6, "call repose campaign run first");
  refused("retry c --outcome jam", 3, "is no outcome of a run");
  bench.write("file", "x");
  bench.write("c/campaign.toml", kCampaign + "[compute]\nstore = \"../file/store\"\n");
  refused("run c", 6, "file/store");
  bench.write("c/campaign.toml", kCampaign + "[compute]\ncores = 2\nranks = 4\n");
  refused("run c", 3, "campaign.toml:");
}

TEST(CampaignCommand, TellsASecondOneWhoIsAtWork) {
  const Workbench bench;
  set_up(bench);
  write_engine(bench, "exec sleep 60");
  const Background first(bench);
  wait_for([&] {
    const auto said = bench.run("repose", "campaign status c --json");
    return said.code == 0 && nlohmann::json::parse(said.out).at("under_way") == 1;
  });
  const auto second = bench.run("repose", "campaign run c");
  EXPECT_EQ(second.code, 6);
  EXPECT_NE(second.err.find("is working in 'c'"), std::string::npos) << second.err;
  EXPECT_NE(json_of(bench, "campaign status c").at("owner"), "");
  first.signal(SIGKILL);  // a dead owner does not block
  write_engine(bench, "echo broken >&2; exit 5");
  const auto third = bench.run("repose", "campaign run c --engine ./engine --json");
  EXPECT_EQ(third.code, 0) << third.err;
  EXPECT_EQ(nlohmann::json::parse(third.out).at("outcomes").at("engine-failed"), 4);
}

TEST(CampaignCommand, LetsTheRunUnderWayEndAtTheFirstCtrlC) {
  const Workbench bench;
  set_up(bench);
  write_engine(bench, "touch \"$3.began\"; while [ ! -e go ]; do sleep 0.02; done; exit 5");
  Background campaign(bench);
  const auto began = [&] {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(bench / "c"))
      if (entry.path().filename() == "output.began") return true;
    return false;
  };
  wait_for(began);
  campaign.signal(SIGINT);
  wait_for([&] { return campaign.errors().find("no more runs are begun") != std::string::npos; });
  bench.write("go", "");
  EXPECT_EQ(campaign.exit_code(), 130);
  EXPECT_EQ(json_of(bench, "campaign status c").at("settled"), 1);
}

TEST(CampaignCommand, EndsTheRunUnderWayAtTheSecondCtrlC) {
  const Workbench bench;
  set_up(bench);
  write_engine(bench, "touch \"$3.began\"; sleep 60");
  Background campaign(bench);
  wait_for([&] {
    const auto said = bench.run("repose", "campaign status c --json");
    return said.code == 0 && nlohmann::json::parse(said.out).at("under_way") == 1;
  });
  campaign.signal(SIGINT);
  wait_for([&] { return campaign.errors().find("no more runs are begun") != std::string::npos; });
  campaign.signal(SIGINT);
  EXPECT_EQ(campaign.exit_code(), 130);
  const auto status = json_of(bench, "campaign status c");
  EXPECT_EQ(status.at("settled"), 0);
  EXPECT_EQ(status.at("stopped"), 1);
}

bool is_running(const std::string& words) {
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", code)) {
    const auto command = test::text_of(entry.path() / "cmdline");
    if (command.find("repose-dem") != std::string::npos && command.find(words) != std::string::npos)
      return true;
  }
  return false;
}

TEST(CampaignCommand, EndsAllProcessesOfARunAtItsTimeLimit) {
  const Workbench bench;
  set_up(bench, "[compute]\ncores = 2\nranks = 2\ntime_limit_s = 1.5\n");
  auto text = test::text_of(bench / "c/campaign.toml");
  text.replace(text.find("settle_s = 0.1"), 14, "settle_s = 999");
  bench.write("c/campaign.toml", text);
  const auto status = json_of(bench, "campaign run c");
  EXPECT_EQ(status.at("outcomes").at("time-limit"), 4);
  // mpirun gives its processes a second.
  wait_for([&] { return !is_running((bench / "c").string()); });
}

}  // namespace
}  // namespace repose

// The smaller twin of the demo: targets made at hidden coefficients, killed half-way, and the proof
// that the calibrated point beats the best screening point on the same fresh seeds.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "program.hpp"
#include "repose/base/toml.hpp"

namespace repose {
namespace {

using test::Workbench;

// About 560 spheres, a second a run. Stiffness and time step are those of the demo's family.
const std::string kRig = R"(scenario = "drawdown"
preset = "quick"
width_m = 0.16
outlet_m = 0.058
drop_m = 0.16
lower_width_m = 0.40
mass_per_thickness_kg_m = 30
settle_s = 0.25
discharge_s = 1.2
)";

constexpr auto kStudy = R"(title = "twin"
seed = 11
scenario = "scenario.toml"
[parameters]
mu_s = { lower = 0.2, upper = 0.9 }
mu_r = { lower = 0.02, upper = 0.32 }
c_r = { lower = 0.3, upper = 0.8 }
[ties]
mu_s_pp = ["mu_s"]
mu_s_ss = ["mu_s"]
mu_s_pg = ["mu_s"]
mu_s_sg = ["mu_s"]
mu_r_pp = ["mu_r"]
mu_r_ss = ["mu_r"]
mu_r_pg = ["mu_r"]
mu_r_sg = ["mu_r"]
c_r_pp = ["c_r"]
c_r_ss = ["c_r"]
[screening]
repetitions = 2
[sampling]
points_per_parameter = 6
[adaptive]
batch = 3
max_batches = 2
[verification]
repetitions = 4
[targets]
)";

/// Mean KPIs at the hidden coefficients, over seeds that the study does not use.
std::map<std::string, double> hidden_targets(const Workbench& bench) {
  std::map<std::string, double> means;
  std::string settings;
  for (const char* pair : {"pp", "ss", "pg", "sg"})
    settings += std::string(" --set mu_s_") + pair + "=0.40 --set mu_r_" + pair + "=0.09";
  settings += " --set c_r_pp=0.5 --set c_r_ss=0.5";
  constexpr int kSeeds = 4;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto said =
        bench.run("repose", "simulate scenario.toml --json --seed " + std::to_string(seed) +
                                settings + " -o hidden" + std::to_string(seed));
    EXPECT_EQ(said.code, 0) << said.err;
    const auto json = nlohmann::json::parse(said.out);
    for (const auto& [name, value] : json.at("kpis").items())
      means[name] += value.get<double>() / kSeeds;
  }
  return means;
}

int finished_runs(const std::filesystem::path& directory) {
  int count = 0;
  std::error_code code;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "runs", code))
    count += std::filesystem::exists(entry.path() / "outcome.json") ? 1 : 0;
  return count;
}

/// When the outcome of each finished run was written.
std::map<std::string, std::filesystem::file_time_type> outcome_times(
    const std::filesystem::path& directory) {
  std::map<std::string, std::filesystem::file_time_type> times;
  for (const auto& entry : std::filesystem::directory_iterator(directory / "runs"))
    if (std::filesystem::exists(entry.path() / "outcome.json"))
      times[entry.path().filename()] =
          std::filesystem::last_write_time(entry.path() / "outcome.json");
  return times;
}

/// Starts the calibration and kills it with SIGKILL once `runs` runs are finished.
void kill_after(const Workbench& bench, int runs) {
  const pid_t child = ::fork();
  if (child == 0) {
    if (::chdir((bench / "").c_str()) != 0) ::_exit(126);
    const int nothing = ::open("/dev/null", O_WRONLY);
    ::dup2(nothing, 2);
    ::execl(REPOSE_BIN "/repose", "repose", "calibrate", "study.toml", "-o", "out", "--quiet",
            nullptr);
    ::_exit(127);
  }
  while (finished_runs(bench / "out") < runs && ::waitpid(child, nullptr, WNOHANG) == 0)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

TEST(CalibrationTwin, BeatsTheBestScreeningPointAndSurvivesBeingKilled) {
  const Workbench bench;
  bench.write("scenario.toml", kRig);
  const auto targets = hidden_targets(bench);
  std::ostringstream study;
  study.precision(17);
  study << kStudy;
  for (const char* kpi : {"shear_angle_deg", "angle_of_repose_deg", "discharged_fraction"})
    study << kpi << " = { value = " << targets.at(kpi) << " }\n";
  bench.write("study.toml", study.str());

  kill_after(bench, 9);
  const int before = finished_runs(bench / "out");
  ASSERT_GE(before, 9);
  EXPECT_FALSE(std::filesystem::exists(bench / "out/result.toml"));
  const auto written = outcome_times(bench / "out");
  kill_after(bench, 30);

  const auto said = bench.run("repose", "calibrate study.toml -o out --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const auto json = nlohmann::json::parse(said.out);
  std::cout << json.dump(1) << '\n';
  EXPECT_EQ(finished_runs(bench / "out"), json.at("runs").get<int>());
  const auto now = outcome_times(bench / "out");
  for (const auto& [key, time] : written) EXPECT_EQ(now.at(key), time) << key << " was done twice";

  const auto result = TomlTable::read_file(bench / "out/result.toml");
  const double verified = result.number("verified_weighted_error");
  const double baseline = result.number("best_screening_point_weighted_error");
  EXPECT_LT(verified, baseline);
  for (const auto& kpi : result.tables("kpi")) EXPECT_EQ(kpi.integer("verified_runs"), 4);

  // Called once more it computes nothing and says the same.
  const auto again = bench.run("repose", "calibrate study.toml -o out --json --quiet");
  EXPECT_EQ(again.out, said.out);
}

}  // namespace
}  // namespace repose

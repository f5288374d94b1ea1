// The recipes of docs/how-to/own_engine.md, run as they stand there.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem_adapter/campaign_file.hpp"
#include "repose/dem_adapter/engine_choice.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

/// A folder with each block of the page that follows a line beginning with its file's name.
class Bench {
 public:
  Bench() {
    std::istringstream page(read_file(REPOSE_SOURCE_DIR "/docs/how-to/own_engine.md"));
    std::string name;
    for (std::string line; std::getline(page, line);) {
      if (line.starts_with("```") && !name.empty()) {
        std::string block;
        while (std::getline(page, line) && line != "```") block += line + '\n';
        write(name, block);
        name.clear();
      } else if (line.starts_with("`") && line.find("`", 1) != std::string::npos) {
        name = line.substr(1, line.find("`", 1) - 1);
      }
    }
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  fs::path operator/(const std::string& name) const { return folder_ / name; }
  const fs::path& path() const { return folder_.path(); }

  /// One run in RUNS/N, measured.
  Measurement simulated(const std::string& scenario_file, const ParameterValues& values,
                        std::uint64_t seed = 1) {
    const auto scenario = read_scenario_file(folder_ / scenario_file);
    run_ = folder_ / ("run" + std::to_string(++runs_));
    fs::create_directories(run_);
    write_file_atomically(run_ / "case.toml", scenario.make_input(values, seed).text);
    const auto exit = make_engine(scenario, {}).run({.directory = run_});
    EXPECT_EQ(exit.status, EngineStatus::finished) << exit.message;
    auto m = scenario.measure(run_ / "output");
    EXPECT_EQ(m.outcome, Outcome::finished) << m.failure;
    return m;
  }
  const fs::path& run() const { return run_; }

 private:
  test::TemporaryDirectory folder_;
  fs::path run_;
  int runs_ = 0;
};

TEST(OwnEngine, ScriptGivesTheAngleThatItComputes) {
  Bench bench;
  const auto steep = bench.simulated("heap.toml", {{"mu_s", 0.9}}).kpis;
  const auto in_file = read_file(bench.run() / "output" / "result.json");
  EXPECT_NE(in_file.find("\"mu_s\": 0.9"), std::string::npos) << in_file;
  const double angle = steep.at("angle_of_repose_deg");
  EXPECT_GT(angle, bench.simulated("heap.toml", {{"mu_s", 0.3}}).kpis.at("angle_of_repose_deg"));
  EXPECT_EQ(bench.simulated("heap.toml", {{"mu_s", 0.9}}).kpis, steep);
  EXPECT_NE(bench.simulated("heap.toml", {{"mu_s", 0.9}}, 2).kpis, steep);
}

/// Outcomes of the campaign in the folder, and how many runs its store has then.
std::pair<std::vector<RunOutcome>, std::size_t> campaigned(const Bench& bench) {
  const auto file = read_campaign(bench.path());
  const Campaign campaign(bench.path(), make_engine(file.scenario, file.engine),
                          measure_of(file.scenario), {.compute = file.compute});
  return {campaign.outcomes(file.wanted_runs()), campaign.store().size()};
}

TEST(OwnEngine, RunsAreMeasuredAnewWhenAKpiChangesAndRepeatedWhenTheScriptDoes) {
  const Bench bench;
  bench.write("campaign.toml",
              "scenario = \"heap.toml\"\npoints = \"points.csv\"\nrepetitions = 2\n");
  bench.write("points.csv", "mu_s\n0.3\n0.6\n");
  const auto [first, recorded] = campaigned(bench);
  ASSERT_EQ(first.size(), 4u);
  EXPECT_EQ(recorded, 4u);
  for (const auto& outcome : first)
    EXPECT_EQ(outcome.measurement.outcome, Outcome::finished) << outcome.measurement.failure;
  EXPECT_NE(first[0].measurement.kpis, first[1].measurement.kpis);  // seeds

  auto scenario = read_file(bench / "heap.toml");
  scenario.replace(scenario.find("/angle_deg"), 10, "/used/mu_s");
  bench.write("heap.toml", scenario);
  const auto [other_kpi, recorded_then] = campaigned(bench);
  EXPECT_EQ(recorded_then, 4u);
  EXPECT_EQ(other_kpi[0].measurement.kpis.at("angle_of_repose_deg"), 0.3);
  EXPECT_EQ(other_kpi[3].measurement.kpis.at("angle_of_repose_deg"), 0.6);

  bench.write("heap.py", read_file(bench / "heap.py") + "\n");
  EXPECT_EQ(campaigned(bench).second, 8u);
}

TEST(OwnEngine, IsNotToBeChosenBesideAnotherEngine) {
  const Bench bench;
  const auto scenario = read_scenario_file(bench / "heap.toml");
  EXPECT_THROW(make_engine(scenario, {.name = "bundled"}), InputError);
}

TEST(OwnEngine, LammpsHeapsUpAColumn) {
  if (std::system("command -v lmp >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "lmp is not installed (Debian package lammps)";
  Bench bench;
  const auto angle = [&](double mu_s, double mu_r) {
    const auto m = bench.simulated("column.toml", {{"mu_s", mu_s}, {"mu_r", mu_r}});
    const auto found = m.kpi("angle_of_repose_deg");
    EXPECT_TRUE(found.has_value());
    return found.value_or(0.0);
  };
  const double flat = angle(0.1, 0.01), steep = angle(0.8, 0.3);
  // Between a liquid and the steepest slopes of spheres without cohesion, and apart by far more
  // than the some 3 degrees that a heap of 400 spheres scatters.
  EXPECT_GT(flat, 0.0);
  EXPECT_LT(steep, 45.0);
  EXPECT_GT(steep, flat + 6.0);
}

}  // namespace
}  // namespace repose::dem_adapter

// The command line as a user meets it: results, exit codes, and what bad input gets.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "repose/table/io.hpp"

namespace repose {
namespace {

using test::Said;
using test::Workbench;

constexpr auto kFactors = R"([parameters]
mu_s = { lower = 0.3, upper = 0.9 }
mu_r = { lower = 0.05, upper = 0.35 }
c_r = { lower = 0.3, upper = 0.9 }
stiffness = { lower = 1e6, upper = 1e8, scale = "log", unit = "Pa" }
)";

constexpr auto kStudy = R"([scenario]
scenario = "drawdown"
[parameters]
mu_s_pp = { lower = 0.3, upper = 0.9 }
mu_r_pp = { lower = 0.05, upper = 0.35 }
c_r_pp = { lower = 0.3, upper = 0.8 }
[targets]
shear_angle_deg = { value = 42.5 }
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(CommandLine, EveryCommandHasHelpWithAnExample) {
  const Workbench bench;
  for (const char* command : {"", "calibrate", "simulate", "measure", "design dsd", "design lhs",
                              "design check", "screen", "variance", "fit", "predict", "compare",
                              "cv", "sensitivity", "sample", "optimise", "table show"}) {
    const auto said = bench.run("repose", std::string(command) + " --help");
    EXPECT_EQ(said.code, 0) << command;
    EXPECT_NE(said.out.find("Example: repose"), std::string::npos) << command;
    std::istringstream lines(said.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
  }
  const auto engine = bench.run("repose-dem", "--help");
  EXPECT_EQ(engine.code, 0);
  EXPECT_NE(engine.out.find("time_step_rayleigh_fraction"), std::string::npos);
}

TEST(CommandLine, AWrongCallIsCodeTwo) {
  const Workbench bench;
  for (const char* arguments :
       {"", "nonsense", "calibrate", "calibrate a.toml -o b --colour", "fit t.h5 -o m.h5",
        "fit t.h5 --response y --kernel cubic -o m.h5"}) {
    const auto said = bench.run("repose", arguments);
    EXPECT_EQ(said.code, 2) << arguments;
    EXPECT_FALSE(said.err.empty()) << arguments;
  }
}

TEST(CommandLine, ADesignIsATableWithRangesThatFitAndPredictUnderstand) {
  const Workbench bench;
  bench.write("factors.toml", kFactors);
  const auto dsd = bench.run("repose", "design dsd --factors factors.toml --seed 3 -o d.h5");
  ASSERT_EQ(dsd.code, 0) << dsd.err;
  const auto design = table::read_table({bench / "d.h5", ""});
  EXPECT_EQ(design.rows(), 13U);  // four factors and two fake ones: conference order 6
  EXPECT_EQ(design.names_with_role(table::Role::factor),
            (std::vector<std::string>{"mu_s", "mu_r", "c_r", "stiffness"}));
  EXPECT_EQ(design.column("stiffness").range->scale, Scale::log);
  for (const double s : design.numbers("stiffness"))  // three levels, the middle one geometric
    EXPECT_TRUE(std::abs(s / 1e6 - 1) < 1e-9 || std::abs(s / 1e7 - 1) < 1e-9 ||
                std::abs(s / 1e8 - 1) < 1e-9)
        << s;
  const auto again = bench.run("repose", "design dsd --factors factors.toml --seed 3 -o d.csv");
  ASSERT_EQ(again.code, 0);
  EXPECT_EQ(table::read_table({bench / "d.csv", ""}).numbers("mu_r"), design.numbers("mu_r"));

  const auto lhs =
      bench.run("repose", "design lhs --factors factors.toml --points 30 -o l.h5 --json");
  ASSERT_EQ(lhs.code, 0) << lhs.err;
  EXPECT_EQ(nlohmann::json::parse(lhs.out).at("runs"), 30);
  auto points = table::read_table({bench / "l.h5", ""});
  std::vector<double> y;
  const auto mu_s = points.numbers("mu_s"), mu_r = points.numbers("mu_r");
  for (std::size_t i = 0; i < points.rows(); ++i)
    y.push_back(20.0 + 30.0 * mu_s[i] + 50.0 * mu_r[i] * mu_r[i]);
  y[4] = std::nan("");  // a run that failed
  points.add({.name = "angle_deg",
              .unit = "deg",
              .role = table::Role::response,
              .range = {},
              .values = y});
  table::write_table({bench / "runs.h5", ""}, points);
  const auto fit =
      bench.run("repose", "fit runs.h5 --response angle_deg --input mu_s,mu_r -o m.h5 --json");
  ASSERT_EQ(fit.code, 0) << fit.err;
  EXPECT_EQ(nlohmann::json::parse(fit.out).at("rows"), 29);
  EXPECT_GT(nlohmann::json::parse(fit.out).at("loo_q2"), 0.99);
  const auto predict = bench.run("repose", "predict m.h5 runs.h5 -o p.csv");
  ASSERT_EQ(predict.code, 0) << predict.err;
  const auto predicted = table::read_table({bench / "p.csv", ""}, table::Missing::allow)
                             .numbers("angle_deg_predicted");
  EXPECT_NEAR(predicted[4], 20.0 + 30.0 * mu_s[4] + 50.0 * mu_r[4] * mu_r[4],
              0.2);  // 1 % of the range
}

TEST(CommandLine, ShowsTablesForPeopleAndMachines) {
  const Workbench bench;
  bench.write("t.csv", "a [kg],b,name\n1,2.5,x\n3,,\"y, z\"\n");
  const auto said = bench.run("repose", "table show t.csv");
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("2 rows, 3 columns"), std::string::npos);
  EXPECT_NE(said.out.find("1 missing"), std::string::npos);
  const auto json = bench.run("repose", "table show t.csv --json");
  EXPECT_EQ(nlohmann::json::parse(json.out).at("columns").at(0).at("unit"), "kg");
}

TEST(CommandLine, BadInputIsOneSentenceWithItsCodeAndLeavesNothing) {
  struct Mistake {
    std::string study, expected;
    int code;
  };
  const std::vector<Mistake> mistakes{
      {"this is not TOML", "study.toml:1: not valid TOML", 3},
      {replaced(kStudy, "[targets]", "colour = 1\n[targets]"), "colour", 3},
      {replaced(kStudy, "lower = 0.3, upper = 0.9", "lower = 0.9, upper = 0.3"),
       "study.toml:4: parameters.mu_s_pp.lower: 0.9 is not below upper = 0.3", 3},
      {replaced(kStudy, "shear_angle_deg", "shear_angl_deg"), "no KPI of this name", 3},
      {replaced(kStudy, "42.5", "inf"), "finite", 3},
      {replaced(kStudy, "drawdown\"", "drawdown\"\ntime_step_rayleigh_fraction = 0.6"), "0.6", 3},
      {replaced(kStudy, "[scenario]\nscenario = \"drawdown\"", "scenario = \"missing.toml\""),
       "missing.toml", 6}};
  for (const auto& mistake : mistakes) {
    const Workbench bench;
    bench.write("study.toml", mistake.study);
    const auto said = bench.run("repose", "calibrate study.toml -o out");
    EXPECT_EQ(said.code, mistake.code) << said.err;
    EXPECT_NE(said.err.find(mistake.expected), std::string::npos) << said.err;
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
    EXPECT_EQ(said.out, "");
    EXPECT_EQ(bench.files(), 1U) << "something was written for " << mistake.expected;
  }
}

TEST(CommandLine, FilesThatAreMissingOrDamagedAreCodeSix) {
  const Workbench bench;
  bench.write("broken.h5", "not HDF5 at all");
  for (const char* arguments :
       {"calibrate none.toml -o out", "table show none.h5", "table show broken.h5",
        "fit broken.h5 --response y -o m.h5", "predict broken.h5 broken.h5 -o p.h5"}) {
    const auto said = bench.run("repose", arguments);
    EXPECT_EQ(said.code, 6) << arguments << said.err;
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
  }
  EXPECT_EQ(bench.files(), 1U);
}

TEST(CommandLine, ADryRunPrintsThePlanAndRunsNothing) {
  const Workbench bench;
  bench.write("study.toml", kStudy);
  const auto said = bench.run("repose", "calibrate study.toml -o out --dry-run");
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("shear_angle_deg = 42.5"), std::string::npos);
  EXPECT_NE(said.out.find("screening"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(bench / "out"));
}

TEST(CommandLine, ASimulationRefusesUnknownSettingsAndFullFolders) {
  const Workbench bench;
  bench.write("scenario.toml", "scenario = \"drawdown\"\n");
  const auto slip = bench.run("repose", "simulate scenario.toml --set mu_s_pq=1 -o run");
  EXPECT_EQ(slip.code, 2);
  EXPECT_NE(slip.err.find("did you mean mu_s_pp?"), std::string::npos) << slip.err;
  const auto full = bench.run("repose", "simulate scenario.toml -o .");
  EXPECT_EQ(full.code, 6);
  EXPECT_NE(full.err.find("not empty"), std::string::npos) << full.err;
}

TEST(CommandLine, ACaseInWhichNothingFlowsIsASimulationFailure) {
  // An outlet of one particle diameter and a few particles: the grains arch over it.
  const Workbench bench;
  bench.write("scenario.toml",
              "scenario = \"drawdown\"\nwidth_m = 0.08\noutlet_m = 0.012\nlower_width_m = 0.2\n"
              "mass_per_thickness_kg_m = 5\nsettle_s = 0.15\ndischarge_s = 0.3\n");
  const auto said = bench.run("repose", "simulate scenario.toml -o run --quiet");
  EXPECT_EQ(said.code, 5) << said.err;
  EXPECT_NE(said.err.find("flowed"), std::string::npos) << said.err;
}

}  // namespace
}  // namespace repose

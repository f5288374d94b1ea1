// repose scenario, and rigs through repose simulate.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.hpp"

namespace repose {
namespace {

using test::Said;
using test::Workbench;

/// Some sixty grains that fall into a bin.
constexpr char kRig[] = R"(scenario = "rig"
[parameters]
mu = 0.4
[domain]
lower_m = [-0.1, -0.1, -0.1]
upper_m = [0.1, 0.1, 0.3]
[[material]]
name = "glass"
density_kg_m3 = 2500
youngs_modulus_pa = 1e7
poissons_ratio = 0.25
[[pair]]
materials = ["glass", "glass"]
restitution = 0.5
mu_s = "= mu"
mu_r = 0.01
[[box]]
name = "bin"
material = "glass"
lower_m = [-0.04, -0.04, 0]
upper_m = [0.04, 0.04, 0.2]
open = ["+z"]
[[region]]
name = "bin"
z_above_m = 0
[fill]
lower_m = [-0.04, -0.04, 0]
upper_m = [0.04, 0.04, 0.2]
solid_fraction = 0.2
[[fill.layer]]
mass_kg = 0.08
material = "glass"
sizes = [{ diameter_m = 0.01 }]
[[stage]]
name = "settle"
duration_s = 1.0
at_rest = {}
[[kpi]]
name = "weight_n"
kind = "wall_force"
wall = "bin.-z"
component = "z"
[[kpi]]
name = "filled_kg"
kind = "mass"
region = "bin"
[[kpi]]
name = "out_kg_s"
kind = "mass_flow"
region = "bin"
)";

TEST(ScenarioCommand, ListsAndShowsWhatIsShipped) {
  const Workbench bench;
  const Said list = bench.run("repose", "scenario list");
  EXPECT_EQ(list.code, 0) << list.err;
  for (const char* name : {"conical_hopper", "drawdown", "hopper", "hopper_chute_bin",
                           "lifted_cylinder", "rotating_drum"})
    EXPECT_NE(list.out.find(name), std::string::npos) << list.out;
  const auto json = nlohmann::json::parse(bench.run("repose", "scenario list --json").out);
  ASSERT_EQ(json.size(), 6u);
  EXPECT_FALSE(json[0]["kpis"].empty());
  const Said show = bench.run("repose", "scenario show hopper");
  EXPECT_EQ(show.code, 0) << show.err;
  EXPECT_EQ(bench.run("repose", "scenario show hopper -o mine.toml").code, 0);
  EXPECT_EQ(test::text_of(bench / "mine.toml"), show.out);
  EXPECT_EQ(bench.run("repose", "scenario show hopper -o mine.toml").code, 6);
  const Said wrong = bench.run("repose", "scenario show hoper");
  EXPECT_EQ(wrong.code, 3);
  EXPECT_NE(wrong.err.find("rotating_drum"), std::string::npos) << wrong.err;
}

TEST(ScenarioCommand, ARigOfTheUsersOwnIsSimulatedAndMeasured) {
  const Workbench bench;
  std::string flowless = kRig;
  flowless.erase(flowless.rfind("[[kpi]]"));
  bench.write("rig.toml", flowless);
  const Said said = bench.run("repose", "simulate rig.toml --set mu=0.3 -o run --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const auto kpis = nlohmann::json::parse(said.out)["kpis"];
  EXPECT_NEAR(kpis["filled_kg"].get<double>(), 0.08, 0.0014);  // half a grain
  EXPECT_LT(kpis["weight_n"].get<double>(), 0.0);
  EXPECT_NE(test::text_of(bench / "run/case.toml").find("[parameters]\nmu = 0.3"),
            std::string::npos);
}

TEST(ScenarioCommand, FailuresOfARigHaveTheirExitCodes) {
  const Workbench bench;
  bench.write("rig.toml", kRig);
  const Said still = bench.run("repose", "simulate rig.toml -o run");
  EXPECT_EQ(still.code, 5);
  EXPECT_NE(still.err.find("out_kg_s: nothing flowed"), std::string::npos) << still.err;
  const Said negative = bench.run("repose", "simulate rig.toml --set mu=-1 -o other");
  EXPECT_EQ(negative.code, 3);
  EXPECT_NE(negative.err.find("rig.toml:15: pair[1].mu_s: \"= mu\" = -1 is not allowed"),
            std::string::npos)
      << negative.err;
  EXPECT_FALSE(std::filesystem::exists(bench / "other"));
}

}  // namespace
}  // namespace repose

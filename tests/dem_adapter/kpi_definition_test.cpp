// Each kind of KPI on a written run whose answer is known.
#include "repose/dem_adapter/kpi_definition.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "repose/base/error.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kDegree = M_PI / 180.0;
constexpr double kGrain_m = 0.004;  // radius

/// Two materials, a region of each kind, a floor and a box.
scene::Case written_case() {
  return scene::parse_case(R"([domain]
lower_m = [-1, -1, -1]
upper_m = [1, 1, 1]
[[material]]
name = "a"
density_kg_m3 = 2000
youngs_modulus_pa = 1e7
poissons_ratio = 0.25
[[material]]
name = "b"
density_kg_m3 = 1000
youngs_modulus_pa = 1e7
poissons_ratio = 0.25
[[pair]]
materials = ["a", "a"]
restitution = 0.5
mu_s = 0.5
mu_r = 0
[[pair]]
materials = ["a", "b"]
restitution = 0.5
mu_s = 0.5
mu_r = 0
[[pair]]
materials = ["b", "b"]
restitution = 0.5
mu_s = 0.5
mu_r = 0
[[box]]
name = "bin"
material = "a"
lower_m = [-0.5, -0.5, 0]
upper_m = [0.5, 0.5, 0.5]
open = ["+z"]
[[region]]
name = "bin"
z_above_m = 0
[[region]]
name = "half"
x_above_m = 0
z_above_m = 0
[[region]]
name = "round"
axis_start_m = [0, 0, 0]
axis_end_m = [0, 0, 1]
radius_m = 0.3
[[region]]
name = "cube"
lower_m = [-0.1, -0.1, -0.1]
upper_m = [0.1, 0.1, 0.1]
[[particle]]
material = "a"
radius_m = 0.004
position_m = [0, 0, 0.1]
[[stage]]
name = "wait"
duration_s = 1
[[stage]]
name = "flow"
duration_s = 2
[output]
snapshot_interval_s = 1
series_interval_s = 0.01
)",
                           "written.toml");
}

void add_grain(scene::Snapshot& s, const scene::Vec3& x, int material = 0, double mass_kg = 1e-3) {
  const auto id = static_cast<std::int64_t>(s.size());
  s.id.push_back(id);
  s.body.push_back(id);
  s.material.push_back(material);
  s.radius_m.push_back(kGrain_m);
  s.mass_kg.push_back(mass_kg);
  s.position.push_back(x);
  s.velocity.push_back(scene::Vec3::Zero());
  s.angular_velocity.push_back(scene::Vec3::Zero());
}

scene::Snapshot snapshot(double time_s, const std::string& stage) {
  return {.time_s = time_s, .stage = stage, .materials = {"a", "b"}};
}

/// Grains whose tops lie on a heap of two slopes, seen along y; along x a slope `across_deg`.
scene::Snapshot heap(double time_s, const std::string& stage, double left_deg, double right_deg) {
  auto s = snapshot(time_s, stage);
  for (int i = -400; i <= 400; ++i) {
    const double x = 0.0005 * i;
    const double deg = x < 0.0 ? left_deg : right_deg;
    const double z = 0.15 - std::abs(x) * std::tan(deg * kDegree);
    // A disc rolled along the slope from below has it for its upper edge.
    if (z > 0.0)
      add_grain(s, {x - std::copysign(std::sin(deg * kDegree), x) * kGrain_m, 0.0,
                    z - std::cos(deg * kDegree) * kGrain_m});
  }
  return s;
}

/// A run of two stages, 0 to 1 s and 1 to 3 s: the bin holds 4 kg of a and 2 kg of b until 1 s,
/// then loses 1 kg/s of a for 1.5 s; the floor bears what is in it.
class WrittenRun {
 public:
  explicit WrittenRun(const std::vector<scene::Snapshot>& snapshots, bool flows = true) {
    const scene::Case scene = written_case();
    scene::RunWriter writer(directory_ / "run", scene);
    const auto columns = scene::region_columns(scene);
    for (int k = 0; k <= 300; ++k) {
      const double t = 0.01 * k, out = flows ? std::clamp(t - 1.0, 0.0, 1.5) : 0.0;
      scene::SeriesRow row{.time_s = t};
      for (const auto& column : columns)
        row.region_mass_kg.push_back(column == "mass_bin_kg"     ? 6.0 - out
                                     : column == "mass_bin_a_kg" ? 4.0 - out
                                     : column == "mass_bin_b_kg" ? 2.0
                                                                 : 0.0);
      writer.add_row(row);
      scene::WallRow loads{.time_s = t};
      for (const auto& wall : scene.walls) {
        const bool is_floor = wall.name == "bin.-z";
        loads.force_n.push_back(is_floor ? scene::Vec3{3.0, 0.0, -(6.0 - out)}
                                         : scene::Vec3{0.0, 0.0, -0.25});
        loads.torque_n_m.push_back(is_floor ? scene::Vec3{0.0, 0.5 * t, 0.0}
                                            : scene::Vec3::Zero().eval());
      }
      writer.add_row(loads);
      scene::ContactRow contacts{.time_s = t};
      for (std::size_t p = 0; p < scene.pairs.size(); ++p)
        contacts.pairs.push_back({.contacts = 10, .mean_normal_force_n = 0.1 * (1.0 + p)});
      writer.add_row(contacts);
    }
    for (const auto& s : snapshots) writer.write_snapshot(s);
    scene::RunSummary summary;
    summary.stages = {{"wait", 1.0, "duration"}, {"flow", 3.0, "duration"}};
    writer.finish(summary);
  }
  scene::Run read() const { return scene::read_run(directory_ / "run"); }

 private:
  test::TemporaryDirectory directory_;
};

std::vector<KpiDefinition> kpis_of(const std::string& text) {
  const auto table = TomlTable::parse(text, "kpis.toml");
  auto kpis = read_kpis(table.tables("kpi"));
  table.refuse_unknown_keys();
  for (const auto& kpi : kpis) check_kpi(kpi, written_case());
  return kpis;
}

Measurement measured(const WrittenRun& run, const std::string& text) {
  return measure_kpis(kpis_of(text), run.read(), {{"two", 2.0}});
}

TEST(KpiDefinition, FlowMassFractionAndDurationAreThoseOfTheCurve) {
  const WrittenRun run({heap(1.0, "wait", 30, 30), heap(3.0, "flow", 30, 30)});
  const auto m = measured(run, R"(
kpi = [
  {name = "flow_kg_s", kind = "mass_flow", region = "bin", stage = "flow", from_s = 0.2, to_s = 1.2},
  {name = "steady_kg_s", kind = "mass_flow", region = "bin"},
  {name = "share_kg_s", kind = "mass_flow", region = "bin", from_share = 0.2, to_share = 0.8},
  {name = "all_kg", kind = "mass", region = "bin"},
  {name = "before_kg", kind = "mass", region = "bin", stage = "wait"},
  {name = "half_way_kg", kind = "mass", region = "bin", material = "a", time_s = 0.5},
  {name = "out", kind = "fraction", region = "bin"},
  {name = "out_a", kind = "fraction", region = "bin", material = "a"},
  {name = "wait_s", kind = "duration", stage = "wait"},
  {name = "flow_s", kind = "duration"},
  {name = "half_out_s", kind = "duration", region = "bin", share = 0.5},
  {name = "rate_of_two", kind = "formula", formula = "= two * flow_kg_s / all_kg"},
]
)");
  EXPECT_EQ(m.outcome, Outcome::finished) << m.failure;
  constexpr double kRounding = 1e-9;
  EXPECT_NEAR(m.kpis.at("flow_kg_s"), 1.0, kRounding);
  EXPECT_NEAR(m.kpis.at("steady_kg_s"), 1.0, 0.02);  // the filter rounds the end off
  EXPECT_NEAR(m.kpis.at("share_kg_s"), 1.0, kRounding);
  EXPECT_NEAR(m.kpis.at("all_kg"), 4.5, kRounding);
  EXPECT_NEAR(m.kpis.at("before_kg"), 6.0, kRounding);
  EXPECT_NEAR(m.kpis.at("half_way_kg"), 3.5, kRounding);
  EXPECT_NEAR(m.kpis.at("out"), 0.25, kRounding);
  EXPECT_NEAR(m.kpis.at("out_a"), 0.375, kRounding);
  EXPECT_NEAR(m.kpis.at("wait_s"), 1.0, kRounding);
  EXPECT_NEAR(m.kpis.at("flow_s"), 2.0, kRounding);
  EXPECT_NEAR(m.kpis.at("half_out_s"), 0.75, 0.01 + kRounding);  // a row of the series
  EXPECT_NEAR(m.kpis.at("rate_of_two"), 2.0 * 1.0 / 4.5, kRounding);
}

TEST(KpiDefinition, LoadsAreMeansOverTheStage) {
  const WrittenRun run({heap(3.0, "flow", 30, 30)});
  const auto m = measured(run, R"(
kpi = [
  {name = "weight_n", kind = "wall_force", wall = "bin.-z", component = "z", stage = "wait"},
  {name = "push_n", kind = "wall_force", wall = "bin.-z", component = "norm", stage = "wait"},
  {name = "box_n", kind = "wall_force", wall = "bin", component = "z", stage = "wait"},
  {name = "turn_n_m", kind = "wall_torque", wall = "bin.-z", component = "y", stage = "flow"},
  {name = "contact_n", kind = "contact_force", materials = ["b", "a"], stage = "flow"},
]
)");
  EXPECT_EQ(m.outcome, Outcome::finished) << m.failure;
  EXPECT_NEAR(m.kpis.at("weight_n"), -6.0, 1e-9);
  EXPECT_NEAR(m.kpis.at("push_n"), std::hypot(3.0, 6.0), 1e-9);
  EXPECT_NEAR(m.kpis.at("box_n"), -6.0 - 4 * 0.25, 1e-9);
  // Rows at 1.01 ... 3.00 s, each the mean of the 0.01 s before it: 0.5 (1.01 + 3) / 2.
  EXPECT_NEAR(m.kpis.at("turn_n_m"), 0.5 * 2.005, 1e-9);
  EXPECT_NEAR(m.kpis.at("contact_n"), 0.2, 1e-12);
}

TEST(KpiDefinition, AnglesAreThoseOfTheSidesSeen) {
  const WrittenRun run(
      {heap(1.0, "wait", 25, 35), heap(2.0, "flow", 20, 30), heap(3.0, "flow", 30, 40)});
  const auto m = measured(run, R"(
kpi = [
  {name = "both_deg", kind = "angle", axis_m = 0, floor_m = 0, stage = "wait"},
  {name = "left_deg", kind = "angle", axis_m = 0, floor_m = 0, stage = "wait", side = "left"},
  {name = "right_deg", kind = "angle", axis_m = 0, floor_m = 0, stage = "wait", side = "right"},
  {name = "slope_deg", kind = "angle", shape = "surface", region = "half", stage = "wait"},
  {name = "mean_deg", kind = "angle", axis_m = 0, floor_m = 0, sampled = "throughout"},
]
)");
  EXPECT_EQ(m.outcome, Outcome::finished) << m.failure;
  // The edge of discs of radius r, 0.5 mm apart, is bumpy by 0.5^2 / 8 r mm over some 0.2 m.
  constexpr double kBumps = 0.1;
  EXPECT_NEAR(m.kpis.at("both_deg"), 30.0, kBumps);
  EXPECT_NEAR(m.kpis.at("left_deg"), 25.0, kBumps);
  EXPECT_NEAR(m.kpis.at("right_deg"), 35.0, kBumps);
  EXPECT_NEAR(m.kpis.at("slope_deg"), 35.0, kBumps);
  EXPECT_NEAR(m.kpis.at("mean_deg"), 30.0, kBumps);
  EXPECT_NEAR(m.details.at("mean_deg.deviation_deg"), 10.0 / std::sqrt(2.0), 2 * kBumps);
}

TEST(KpiDefinition, DensityAndSegregationAreThoseOfALattice) {
  // A cube of 0.2 m filled by a cubic lattice of pitch 0.02 m, a on the left and b on the right.
  auto lattice = snapshot(3.0, "flow");
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j)
      for (int k = 0; k < 10; ++k)
        add_grain(lattice, {0.02 * i - 0.09, 0.02 * j - 0.09, 0.02 * k - 0.09}, i < 5 ? 0 : 1,
                  1e-3);
  auto first = snapshot(1.0, "wait");
  for (int k = 0; k < 4; ++k) add_grain(first, {0, 0, 0.1 * k}, k % 2, 1.0);
  const WrittenRun run({first, lattice});
  const auto m = measured(run, R"(
kpi = [
  {name = "bulk_density_kg_m3", kind = "bulk_density", region = "cube"},
  {name = "rsd_x", kind = "grid_segregation", grid = "x", bin = 0.1, origin_m = [-0.1, 0, 0], material = "a"},
  {name = "rsd_y", kind = "grid_segregation", grid = "y", bin = 0.1, origin_m = [0, -0.1, 0], material = "a"},
  {name = "lacey_x", kind = "grid_segregation", grid = "x", bin = 0.1, origin_m = [-0.1, 0, 0], material = "a", index = "lacey"},
  {name = "si_bin", kind = "segregation_over_time", region = "bin", material = "b"},
]
)");
  EXPECT_EQ(m.outcome, Outcome::finished) << m.failure;
  EXPECT_NEAR(m.kpis.at("bulk_density_kg_m3"), 1000 * 1e-3 / 0.008, 1e-9);
  EXPECT_NEAR(m.kpis.at("rsd_x"), std::sqrt(2.0), 1e-9);  // two pure bins
  EXPECT_NEAR(m.kpis.at("rsd_y"), 0.0, 1e-9);
  EXPECT_LT(m.kpis.at("lacey_x"), 0.0 + 1e-9);
  // chi_0 = 1/2; chi = 2 / (6 - out): |2/6 - 1/2| / (1/2) = 1/3 at first, |2/4.5 - 1/2| * 2 = 1/9
  // at last; out rises over 150 of 301 rows, during which the mean is that of the integral.
  double sum = 0.0;
  for (int k = 0; k <= 300; ++k)
    sum += std::abs(2.0 / (6.0 - std::clamp(0.01 * k - 1.0, 0.0, 1.5)) - 0.5) / 0.5;
  EXPECT_NEAR(m.kpis.at("si_bin"), sum / 301.0, 1e-9);
}

TEST(KpiDefinition, FailuresHaveNames) {
  const WrittenRun still({heap(3.0, "flow", 30, 30)}, false);
  EXPECT_EQ(
      measured(still, R"(kpi = [{name = "f_kg_s", kind = "mass_flow", region = "bin"}])").outcome,
      Outcome::nothing_flowed);
  EXPECT_EQ(measured(still, R"(kpi = [{name = "f", kind = "fraction", region = "bin"}])").outcome,
            Outcome::finished);
  EXPECT_EQ(
      measured(still,
               R"(kpi = [{name = "f", kind = "fraction", region = "bin", jammed_below = 0.5}])")
          .outcome,
      Outcome::nothing_flowed);
  const WrittenRun flowing({heap(3.0, "flow", 30, 30)});
  const auto jammed = measured(
      flowing,
      R"(kpi = [{name = "f_kg_s", kind = "mass_flow", region = "bin", jammed_below = 0.3}])");
  EXPECT_EQ(jammed.outcome, Outcome::jammed_outlet);
  EXPECT_TRUE(jammed.kpis.empty());
  const auto undefined = measured(flowing, R"(
kpi = [
  {name = "all_kg", kind = "mass", region = "bin"},
  {name = "late_kg", kind = "mass", region = "bin", time_s = 5},
  {name = "empty_deg", kind = "angle", region = "cube", fastest_m_s = 0.1, axis_m = 5},
  {name = "infinite", kind = "formula", formula = "= all_kg / (two - 2) "},
])");
  EXPECT_EQ(undefined.outcome, Outcome::kpi_undefined);
  EXPECT_EQ(undefined.kpis.size(), 1u);
  for (const char* name : {"late_kg: ", "empty_deg: ", "infinite: "})
    EXPECT_NE(undefined.failure.find(name), std::string::npos) << undefined.failure;
}

TEST(KpiDefinition, RefusesWhatTheCaseDoesNotHaveAndWhatMeansNothing) {
  EXPECT_NO_THROW(kpis_of(R"(kpi = [{name = "x_kg", kind = "mass", region = "bin"}])"));
  for (
      const char* wrong : {
          R"({name = "x_deg", kind = "angle", shape = "surface", side = "left"})",
          R"({name = "x_deg", kind = "angle", shape = "slopes"})",
          R"({name = "x_deg", kind = "angle", shape = "slopes", outlet_left_m = 1, outlet_right_m = 0})",
          R"({name = "x_deg", kind = "angle", seen_along = ["z"]})",
          R"({name = "x_deg", kind = "angle", seen_along = []})",
          R"({name = "x_deg", kind = "angle", region = "nowhere"})",
          R"({name = "x_kg_s", kind = "mass_flow"})",
          R"({name = "x_kg_s", kind = "mass_flow", region = "bin", from_s = 1, to_s = 2, from_share = 0, to_share = 1})",
          R"({name = "x_kg", kind = "mass", region = "bin", material = "c"})",
          R"({name = "x_kg", kind = "mass", region = "bin", stage = "never"})",
          R"({name = "x_kg_m3", kind = "bulk_density", region = "round"})",
          R"({name = "x_n", kind = "wall_force", wall = "lid", component = "z"})",
          R"({name = "x_n", kind = "wall_force", wall = "bin.-z", component = "w"})",
          R"({name = "x_n", kind = "contact_force", materials = ["a"]})",
          R"({name = "x_n", kind = "contact_force", materials = ["a", "c"]})",
          R"({name = "x_s", kind = "duration", share = 0.5})",
          R"({name = "x", kind = "grid_segregation", grid = "spherical", material = "a"})",
          R"({name = "x", kind = "grid_segregation", grid = "x", index = "best", material = "a"})",
          R"({name = "x_s", kind = "fraction", region = "bin"})",
      })
    EXPECT_THROW(kpis_of("kpi = [" + std::string(wrong) + "]"), InputError) << wrong;
}

}  // namespace
}  // namespace repose::dem_adapter

// The draw-down scenario: its cases, its files, and KPIs of heaps whose answer is known.
#include "repose/dem_adapter/drawdown.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

Drawdown read(const std::string& text) {
  const auto root = TomlTable::parse(text, "s.toml");
  root.choice_or("scenario", "drawdown", {"drawdown"});
  auto rig = Drawdown::read(root);
  root.refuse_unknown_keys();
  return rig;
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(DrawdownScenario, PresetsMakeValidCases) {
  for (const char* name : {"quick", "delft-like"}) {
    const auto c = Drawdown::preset(name).make_case({}, 1);
    EXPECT_NO_THROW(scene::validate(c)) << name;
    double mass = 0.0;
    for (const auto& layer : c.fill->layers) mass += layer.mass_kg;
    const auto rig = Drawdown::preset(name);
    EXPECT_NEAR(mass, rig.mass_per_thickness_kg_m * rig.thickness_m, 1e-12) << name;
  }
  EXPECT_THROW(Drawdown::preset("big"), InputError);
}

TEST(DrawdownScenario, TakesParametersByNameAndMixesPairsThatAreNotGiven) {
  const auto c = Drawdown::preset("quick").make_case({{"mu_s_pp", 0.5},
                                                      {"mu_s_ss", 0.7},
                                                      {"mu_r_sg", 0.11},
                                                      {"drop_m", 0.3},
                                                      {"source_of_a_tie", 1.0}},
                                                     9);
  EXPECT_EQ(c.seed, 9U);
  const auto pair = [&](const char* a, const char* b) {
    return c.pairs[static_cast<std::size_t>(
        scene::pair_index(c, scene::material_index(c, a), scene::material_index(c, b)))];
  };
  EXPECT_DOUBLE_EQ(pair("pellet", "sinter").mu_s, 0.6);
  EXPECT_DOUBLE_EQ(pair("pellet", "pellet").mu_s, 0.5);
  EXPECT_DOUBLE_EQ(pair("sinter", "box").mu_r, 0.11);
  EXPECT_DOUBLE_EQ(pair("pellet", "sinter").restitution, 0.5 * (0.76 + 0.35));
  EXPECT_LT(c.lower_m.z(), -0.3);
}

TEST(DrawdownScenario, ReadsOverridesAndLayering) {
  const auto rig = read(
      "preset = \"quick\"\nwidth_m = 0.25\nlayers = [\"sinter\", \"pellet\", \"sinter\"]\n"
      "mass_shares = { pellet = 0.75, sinter = 0.25 }\n[coefficients]\nmu_s_ps = 0.4\n");
  EXPECT_DOUBLE_EQ(rig.width_m, 0.25);
  const auto c = rig.make_case({}, 1);
  ASSERT_EQ(c.fill->layers.size(), 3U);
  EXPECT_NEAR(c.fill->layers[0].mass_kg, 66 * 0.036 * 0.25 / 2, 1e-12);
  EXPECT_NEAR(c.fill->layers[1].mass_kg, 66 * 0.036 * 0.75, 1e-12);
}

TEST(DrawdownScenario, MakesAMaterialOfClumps) {
  const std::string sinter =
      "preset = \"quick\"\nlayers = [\"sinter\"]\nsolid_fraction = 0.25\n[[material]]\n"
      "name = \"sinter\"\nsymbol = \"s\"\ndensity_kg_m3 = 3449\nmass_share = 1\n"
      "sizes = [{diameter_m = 0.01, mass_fraction = 1}]\n";
  const auto c = read(sinter + "clump = \"sinter_3\"\n").make_case({}, 1);
  EXPECT_EQ(c.fill->layers[0].mixture[0].clump, "sinter_3");
  EXPECT_NO_THROW(scene::validate(c));
  EXPECT_NE(refusal(sinter + "clump = \"cube\"\n").find("sinter_3"), std::string::npos);
}

TEST(DrawdownScenario, NamesWhatCannotBe) {
  EXPECT_NE(refusal("outlet_m = 0.3").find("outlet_m = 0.3: it must be below width_m = 0.2"),
            std::string::npos);
  EXPECT_NE(refusal("width = 1").find("did you mean width_m?"), std::string::npos);
  EXPECT_NE(refusal("[coefficients]\nmu_s_px = 1").find("known are"), std::string::npos);
  EXPECT_NE(refusal("layers = [\"pellet\"]").find("material sinter is in no layer"),
            std::string::npos);
  EXPECT_NE(refusal("mass_shares = { pellet = 0.5, sinter = 0.6 }").find("1.1"), std::string::npos);
  EXPECT_NE(refusal("drop_m = -1").find("above 0"), std::string::npos);
}

/// A run in which spheres of 10 mm hold exact shapes: wedges of `shear_deg` above, a heap of
/// `repose_deg` below, and a discharge at a constant rate between 0.1 and 1.1 s.
class SyntheticRun {
 public:
  SyntheticRun(const std::filesystem::path& directory, const Drawdown& rig, double shear_deg,
               double repose_deg, double base = 0.17)
      : rig_(rig) {
    const auto c = rig.make_case({}, 1);
    snapshot_.time_s = 1.5;
    snapshot_.stage = "discharge";
    snapshot_.materials = {"pellet", "sinter", "box"};
    const double half = 0.5 * rig.width_m, slot = 0.5 * rig.outlet_m;
    const double s = std::tan(shear_deg * std::numbers::pi / 180),
                 r = std::tan(repose_deg * std::numbers::pi / 180);
    for (const double side : {-1.0, 1.0}) {
      for (double d = slot; d < half - kRadius; d += kSpacing)
        add(side * d, kRadius + (d - slot) * s,
            0.0);  // tops of a row along the slope: their edge is parallel to it
      for (double d = 0.0; d < base; d += kSpacing)
        add(side * d, -rig.drop_m + 2 * kRadius + (base - d) * r, 0.0);
    }
    scene::RunWriter writer(directory, c);
    double lower = 0.0, total = 0.0;
    for (std::size_t i = 0; i < snapshot_.size(); ++i) {
      total += snapshot_.mass_kg[i];
      if (snapshot_.position[i].z() < 0) lower += snapshot_.mass_kg[i];
    }
    fraction_ = lower / total;
    rate_ = lower / 1.0;
    const auto columns = scene::region_columns(c);
    for (int i = 0; i <= 300; ++i) {
      const double t = 0.005 * i;
      const double out = lower * std::clamp(t - 0.3 - 0.1, 0.0, 1.0);
      std::vector<double> masses(columns.size(), 0.0);
      masses[0] = total - out;
      writer.add_row({.time_s = t, .region_mass_kg = masses});
    }
    writer.write_snapshot(snapshot_);
    writer.finish({.steps = 1,
                   .time_step_s = 1e-4,
                   .spheres = 1,
                   .bodies = {.inserted = 1, .alive = 1, .inserted_kg = total, .alive_kg = total},
                   .largest_overlap_ratio = 0.05,
                   .engine = "synthetic",
                   .version = "1",
                   .seed = 1,
                   .stages = {{"settle", 0.3, "duration"}, {"discharge", 1.5, "duration"}}});
  }
  double fraction() const { return fraction_; }
  double rate() const { return rate_; }

 private:
  static constexpr double kRadius = 0.005, kSpacing = 0.0005;
  void add(double x, double z, double speed) {
    snapshot_.id.push_back(static_cast<std::int64_t>(snapshot_.size()));
    snapshot_.body.push_back(snapshot_.id.back());
    snapshot_.material.push_back(0);
    snapshot_.radius_m.push_back(kRadius);
    snapshot_.mass_kg.push_back(0.001);
    snapshot_.position.emplace_back(x, 0.01, z);
    snapshot_.velocity.emplace_back(0.0, 0.0, -speed);
    snapshot_.angular_velocity.emplace_back(0.0, 0.0, 0.0);
  }
  Drawdown rig_;
  scene::Snapshot snapshot_;
  double fraction_ = 0.0, rate_ = 0.0;
};

TEST(KpiLabel, ReadsTheUnitFromTheName) {
  EXPECT_EQ(label_of("mass_flow_kg_s").unit, "kg/s");
  EXPECT_EQ(label_of("angle_of_repose_deg").words, "angle of repose");
  EXPECT_EQ(label_of("bulk_density_kg_m3").unit, "kg/m3");
  EXPECT_EQ(label_of("discharged_mass_kg").unit, "kg");
  EXPECT_EQ(label_of("discharged_fraction").unit, "1");
}

TEST(DrawdownKpis, OfKnownSlopesAreTheirAngles) {
  for (const auto& [shear, repose] : {std::pair{42.5, 29.5}, std::pair{25.0, 20.0}}) {
    const test::TemporaryDirectory directory;
    const auto rig = Drawdown::preset("quick");
    const SyntheticRun synthetic(directory / "run", rig, shear, repose);
    const auto m = rig.measure(scene::read_run(directory / "run"));
    ASSERT_EQ(m.failure, "");
    // The envelope of equal discs along a line is a parallel line except within one radius of its
    // ends.
    EXPECT_NEAR(m.kpis.at("shear_angle_deg"), shear, 1.5);
    EXPECT_NEAR(m.kpis.at("angle_of_repose_deg"), repose, 1.0);
    EXPECT_NEAR(m.kpis.at("discharged_fraction"), synthetic.fraction(), 1e-12);
    // Rows of 5 ms in a straight ramp: the fitted slope is the rate to rounding.
    EXPECT_NEAR(m.kpis.at("mass_flow_kg_s"), synthetic.rate(), 1e-9 * synthetic.rate());
    EXPECT_NEAR(m.details.at("time_98_percent_s"), 1.08, 0.006);
    EXPECT_TRUE(m.warnings.empty());
    EXPECT_NEAR(m.details.at("shear_angle_left_deg"), m.details.at("shear_angle_right_deg"), 0.5);
  }
}

TEST(DrawdownKpis, AreMeasuredOnTheRigThatWasRun) {
  // Lengths are parameters: a run of another rig than the scenario's own is measured by its own
  // walls.
  const test::TemporaryDirectory directory;
  auto other = Drawdown::preset("quick");
  other.drop_m = 0.4;
  other.width_m = 0.3;
  other.outlet_m = 0.08;
  const SyntheticRun synthetic(directory / "run", other, 35.0, 25.0, 0.2);
  const auto m = Drawdown::preset("quick").measure(scene::read_run(directory / "run"));
  ASSERT_EQ(m.failure, "");
  EXPECT_NEAR(m.kpis.at("shear_angle_deg"), 35.0, 1.5);
  EXPECT_NEAR(m.kpis.at("angle_of_repose_deg"), 25.0, 1.0);
}

TEST(DrawdownKpis, SayWhenTheOutletJammed) {
  const test::TemporaryDirectory directory;
  const auto rig = Drawdown::preset("quick");
  const SyntheticRun synthetic(directory / "run", rig, 42.5, 29.5, 0.02);  // hardly a heap below
  ASSERT_LT(synthetic.fraction(), 0.5);
  const auto m = rig.measure(scene::read_run(directory / "run"));
  EXPECT_NE(m.failure.find("the outlet jammed"), std::string::npos) << m.failure;
  EXPECT_TRUE(m.kpis.empty());
}

TEST(DrawdownKpis, WarnWhenTheHeapTouchesTheWall) {
  const test::TemporaryDirectory directory;
  auto rig = Drawdown::preset("quick");
  rig.lower_width_m = 0.3;
  const SyntheticRun synthetic(directory / "run", rig, 42.5, 29.5);
  const auto m = rig.measure(scene::read_run(directory / "run"));
  ASSERT_EQ(m.warnings.size(), 1U);
  EXPECT_NE(m.warnings[0].find("reached the wall"), std::string::npos);
}

}  // namespace
}  // namespace repose::dem_adapter

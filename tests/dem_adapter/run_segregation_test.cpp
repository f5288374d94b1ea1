// Segregation under the names and defaults that users meet.
#include "repose/dem_adapter/run_segregation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "drawn_picture.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

/// Spheres in random places of a cylinder of radius and height 1 m; component by `of`.
template <class Rule>
Mixture cylinder(int grains, Rule&& of) {
  Mixture m{.components = {"pellet", "sinter"}};
  RandomStream random(15);
  while (static_cast<int>(m.size()) < grains) {
    const scene::Vec3 x{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform()};
    if (std::hypot(x.x(), x.y()) >= 1.0) continue;
    m.position.push_back(x);
    m.component.push_back(of(x, random));
    m.mass_kg.push_back(1.0);
    m.volume_m3.push_back(M_PI / 6.0 * 1e-3);  // 0.1 m
  }
  return m;
}

TEST(GridSegregation, SeesWhereTheMixtureIsSegregatedAndOnlyThere) {
  const auto core = cylinder(20000, [](const scene::Vec3& x, RandomStream&) {
    return std::hypot(x.x(), x.y()) < std::sqrt(0.5) ? 0 : 1;
  });
  const auto rsd = [&](GridKind kind, double size) {
    const auto result = measure_segregation(
        core, {.kind = kind, .sizes = {size}, .origin = scene::Vec3{0.0, 0.0, 0.0}});
    const std::string name = std::string("rsd_") + to_string(kind) + "_pellet";
    return std::pair(result.measurement.kpis.at(name),
                     result.measurement.details.at("rsd_random_pellet"));
  };
  const auto [radial, radial_chance] = rsd(GridKind::radial, 0.1);
  EXPECT_GT(radial, 0.4);
  EXPECT_GT(radial, 10.0 * radial_chance);
  for (const auto& [kind, size] :
       {std::pair(GridKind::vertical, 0.1), std::pair(GridKind::circumferential, 45.0)}) {
    // Chance alone: a chi of some ten bins lies within half and twice its root mean square.
    const auto [found, chance] = rsd(kind, size);
    EXPECT_GT(found, 0.4 * chance) << to_string(kind);
    EXPECT_LT(found, 2.0 * chance) << to_string(kind);
  }
}

TEST(GridSegregation, OfARandomMixtureFallsWithTheSizeOfBinsAsChanceDoes) {
  const auto mixed = cylinder(20000, [](const scene::Vec3&, RandomStream& random) {
    return static_cast<int>(random.below(2));
  });
  const auto result = measure_segregation(
      mixed, {.kind = GridKind::cubic, .sizes = {0.1, 0.2, 0.4}, .least_fill = 0.5});
  const auto rsd = result.sizes.numbers("rsd_pellet"),
             chance = result.sizes.numbers("rsd_random_pellet");
  const auto bins = result.sizes.numbers("bins");
  ASSERT_EQ(rsd.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i)  // four standard errors of a deviation over so many bins
    EXPECT_NEAR(rsd[i] / chance[i], 1.0, 4.0 / std::sqrt(2.0 * (bins[i] - 1.0)) + 0.02) << bins[i];
  EXPECT_GT(rsd[0], 2.0 * rsd[1]);
}

TEST(GridSegregation, HasTenReferenceDiametersForDefaultAndWritesItsBins) {
  const auto mixture =
      cylinder(3000, [](const scene::Vec3& x, RandomStream&) { return x.z() < 0.5; });
  const auto radial = measure_segregation(mixture, {.kind = GridKind::vertical, .sizes = {0.25}});
  EXPECT_NEAR(radial.measurement.details.at("reference_diameter_m"), 0.1, 1e-12);
  EXPECT_THROW(measure_segregation(mixture, {.kind = GridKind::vertical}), InputError);  // 1 m
  EXPECT_EQ(radial.bins.names(),
            (std::vector<std::string>{"cell", "mass_pellet_kg", "mass_sinter_kg", "nmr_pellet",
                                      "nmr_sinter"}));
  EXPECT_EQ(radial.bins.rows(), 4U);
  EXPECT_EQ(radial.bins.numbers("nmr_pellet")[0], 0.0);
  EXPECT_NEAR(radial.measurement.details.at("li_pellet"), 1.0, 0.02);
  const auto both =
      measure_segregation(mixture, {.kind = GridKind::vertical, .sizes = {0.25, 5.0}});
  EXPECT_EQ(both.sizes.rows(), 1U);
  ASSERT_EQ(both.measurement.warnings.size(), 1U);
  EXPECT_NE(both.measurement.warnings[0].find("bins of 5"), std::string::npos);
}

TEST(GridSegregation, OfAComponentThatLiesInNoBinUsedIsUndefinedByName) {
  // Ten even layers of two components, and a thin one of dust on top that is left out.
  Mixture mixture{.components = {"pellet", "sinter", "dust"}};
  for (int i = 0; i < 1010; ++i) {
    mixture.component.push_back(i < 1000 ? i % 2 : 2);
    mixture.position.push_back({0.0, 0.0, i < 1000 ? (i + 0.5) / 1000.0 : 1.05});
    mixture.mass_kg.push_back(1.0);
    mixture.volume_m3.push_back(1e-6);
  }
  const auto result = measure_segregation(mixture, {.kind = GridKind::vertical,
                                                    .sizes = {0.1},
                                                    .origin = scene::Vec3{0.0, 0.0, 0.0},
                                                    .least_fill = 0.9});
  const auto& m = result.measurement;
  EXPECT_EQ(m.outcome, Outcome::kpi_undefined);
  EXPECT_NE(m.failure.find("rsd_vertical_dust is undefined"), std::string::npos) << m.failure;
  ASSERT_EQ(m.warnings.size(), 1U);
  EXPECT_NE(m.warnings[0].find("no grain of 'dust' lies in the 10 bins used"), std::string::npos);
  EXPECT_NEAR(m.kpis.at("rsd_vertical_pellet"), 0.0, 1e-12);
  EXPECT_EQ(m.kpis.size(), 2U);
  for (const auto& [name, value] : m.details) EXPECT_TRUE(std::isfinite(value)) << name;
  EXPECT_TRUE(std::isnan(result.sizes.numbers("rsd_dust")[0]));
  EXPECT_FALSE(result.bins.has("nmr_dust"));
  EXPECT_TRUE(result.bins.has("nmr_sinter"));
}

TEST(SliceSegregation, OfAPhotographIsThatOfItsColours) {
  // Pellets on the left half: six slices side by side are pure, three above each other half and
  // half.
  constexpr Rgb kSky{40, 90, 160}, kPellet{110, 60, 50}, kSinter{190, 190, 190};
  const auto picture = test::drawn(
      300, 150, kSky, [](double x, double) { return x < 150.0 ? kPellet : kSinter; },
      [](double x, double y) { return x > 30 && x < 270 && y > 30.0; });
  const View view =
      view_of_photograph(picture, {.components = {{"pellet", kPellet}, {"sinter", kSinter}}});
  const auto m = measure_slices(view);
  // Half of six bins pure: sqrt(6 / 5); the border column of the edge may go either way.
  EXPECT_NEAR(m.kpis.at("rsd_image_horizontal_pellet"), std::sqrt(6.0 / 5.0), 0.01);
  EXPECT_NEAR(m.kpis.at("rsd_image_vertical_sinter"), 0.0, 0.01);
  EXPECT_NEAR(m.details.at("pixel_share_pellet"), 0.5, 0.01);
  EXPECT_THROW(measure_slices(view_of_photograph(picture, {})), InputError);
}

/// Grains of 2 kg, so many of each material of the run.
struct Layer {
  double time_s = 0.0;
  std::string stage;
  std::array<int, 3> grains{};
};

/// A run of pellets, sinter and coke in a box of steel, with the region "outlet": between 0.8 and
/// 3.2 s it holds `kg` of each, before and after a hundredth of it.
scene::Run discharge_run(const std::filesystem::path& folder, const std::vector<Layer>& layers,
                         const std::array<double, 3>& kg) {
  const std::vector<std::string> names{"pellet", "sinter", "coke", "box"};
  scene::Case c;
  for (const auto& name : names)
    c.materials.push_back(
        {.name = name, .density_kg_m3 = 4000.0, .youngs_modulus_pa = 1e7, .poissons_ratio = 0.3});
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a; b < 4; ++b)
      c.pairs.push_back(
          {.first = names[a], .second = names[b], .restitution = 0.5, .mu_s = 0.5, .mu_r = 0.1});
  c.lower_m = {-1, -1, -1};
  c.upper_m = {1, 1, 1};
  c.regions = {{"outlet", {-1, -1, -1}, {1, 1, 0}}};
  c.particles.emplace_back();
  c.particles[0].material = "pellet";
  c.particles[0].radius_m = 0.01;
  c.particles[0].position = {0, 0, 0.5};
  for (const auto& layer : layers)
    if (c.stages.empty() || c.stages.back().name != layer.stage)
      c.stages.push_back({.name = layer.stage, .duration_s = 1.0});
  scene::RunWriter writer(folder, c);
  for (int i = 0; i <= 20; ++i) {
    const double part = i < 4 || i > 16 ? 0.01 : 1.0;
    std::vector<double> masses;
    for (const auto& column : scene::region_columns(c)) {
      const auto at = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
        return column.find(name) != std::string::npos;
      });
      const auto k = static_cast<std::size_t>(at - names.begin());
      masses.push_back(part * (k < 3 ? kg[k] : k == 3 ? 0.0 : kg[0] + kg[1] + kg[2]));
    }
    writer.add_row(scene::SeriesRow{.time_s = 0.2 * i, .region_mass_kg = masses});
  }
  for (const auto& layer : layers) {
    scene::Snapshot s{.time_s = layer.time_s, .stage = layer.stage, .materials = names};
    for (std::size_t k = 0; k < 3; ++k)
      for (int i = 0; i < layer.grains[k]; ++i) {
        s.id.push_back(static_cast<std::int64_t>(s.id.size()));
        s.material.push_back(static_cast<std::int64_t>(k));
        s.position.push_back({0.0, 0.0, 0.1 * static_cast<double>(s.id.size())});
      }
    s.body = s.id;
    s.radius_m.assign(s.size(), 0.01);
    s.mass_kg.assign(s.size(), 2.0);
    s.velocity = s.angular_velocity = std::vector<scene::Vec3>(s.size(), scene::Vec3::Zero());
    writer.write_snapshot(s);
  }
  writer.finish({.steps = 1, .time_step_s = 1.0, .engine = "none", .version = "1"});
  return scene::read_run(folder);
}

TEST(DischargeSegregation, OfARunIsThatOfItsRegion) {
  const test::TemporaryDirectory directory;
  const auto run = discharge_run(directory / "run", {{0.0, "flow", {1, 3, 0}}}, {0.5, 0.5, 0.0});
  const auto result = measure_discharge_segregation(run, "outlet");
  EXPECT_EQ(result.measurement.kpis.size(), 2U);  // there is no coke
  EXPECT_NEAR(result.measurement.kpis.at("si_outlet_pellet"), (0.5 - 0.25) / 0.75, 1e-12);
  EXPECT_NEAR(result.measurement.kpis.at("si_outlet_sinter"), 0.25 / 0.25, 1e-12);
  EXPECT_NEAR(result.measurement.details.at("time_min_s"), 0.8, 1e-12);
  EXPECT_NEAR(result.measurement.details.at("time_max_s"), 3.2, 1e-12);
  EXPECT_EQ(result.series.rows(), 13U);
  EXPECT_NEAR(result.series.numbers("nmr_pellet")[7], 2.0, 1e-12);
  EXPECT_THROW(measure_discharge_segregation(run, "inlet"), InputError);
}

TEST(DischargeSegregation, SeesAMaterialThatNeverArrives) {
  const test::TemporaryDirectory directory;
  const auto run = discharge_run(directory / "run", {{0.0, "flow", {5, 5, 5}}}, {0.5, 0.5, 0.0});
  const auto m = measure_discharge_segregation(run, "outlet").measurement;
  EXPECT_NEAR(m.details.at("initial_share_pellet"), 1.0 / 3.0, 1e-12);
  EXPECT_NEAR(m.kpis.at("si_outlet_pellet"), (0.5 - 1.0 / 3.0) / (2.0 / 3.0), 1e-12);
  EXPECT_NEAR(m.kpis.at("si_outlet_coke"), (1.0 / 3.0) / (2.0 / 3.0), 1e-12);
  EXPECT_EQ(m.kpis.size(), 3U);  // none of steel
  const auto pure = discharge_run(directory / "pure", {{0.0, "flow", {5, 5, 5}}}, {1.0, 0.0, 0.0});
  EXPECT_NEAR(measure_discharge_segregation(pure, "outlet").measurement.kpis.at("si_outlet_pellet"),
              1.0, 1e-12);
}

TEST(DischargeSegregation, TakesItsInitialSharesWhenAllIsFilledInOrWhenItIsTold) {
  const test::TemporaryDirectory directory;
  // Filled in layers; later all flows out, pellets first.
  const auto run = discharge_run(directory / "run",
                                 {{1.0, "fill_pellets", {4, 0, 0}},
                                  {2.0, "fill_sinter", {4, 4, 0}},
                                  {3.0, "settle", {4, 4, 0}},
                                  {4.0, "discharge", {1, 4, 0}}},
                                 {0.5, 0.5, 0.0});
  const auto by_default = measure_discharge_segregation(run, "outlet").measurement;
  EXPECT_EQ(by_default.details.at("initial_time_s"), 3.0);
  EXPECT_NEAR(by_default.details.at("initial_share_pellet"), 0.5, 1e-12);
  EXPECT_NEAR(by_default.kpis.at("si_outlet_pellet"), 0.0, 1e-12);
  const auto told = measure_discharge_segregation(run, "outlet", {.initial_snapshot = 3});
  EXPECT_NEAR(told.measurement.details.at("initial_share_pellet"), 0.2, 1e-12);
  try {
    measure_discharge_segregation(run, "outlet", {.initial_snapshot = 0});
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'sinter' comes into region 'outlet'"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace repose::dem_adapter

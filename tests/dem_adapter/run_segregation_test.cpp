// Segregation under the names and defaults that users meet.
#include "repose/dem_adapter/run_segregation.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(DischargeSegregation, OfARunIsThatOfItsRegion) {
  const test::TemporaryDirectory directory;
  scene::Case c;
  c.materials = {
      {"pellet", 4000.0, 1e7, 0.3}, {"sinter", 3000.0, 1e7, 0.3}, {"box", 7800.0, 1e9, 0.3}};
  for (const char* a : {"pellet", "sinter"})
    for (const char* b : {"pellet", "sinter", "box"})
      if (std::string(a) != "sinter" || std::string(b) != "pellet")
        c.pairs.push_back({.first = a, .second = b, .restitution = 0.5, .mu_s = 0.5, .mu_r = 0.1});
  c.lower_m = {-1, -1, -1};
  c.upper_m = {1, 1, 1};
  c.regions = {{"outlet", {-1, -1, -1}, {1, 1, 0}}};
  c.particles.emplace_back();
  c.particles[0].material = "pellet";
  c.particles[0].radius_m = 0.01;
  c.particles[0].position = {0, 0, 0.5};
  c.stages = {{.name = "flow", .duration_s = 1.0}};
  scene::Snapshot s{.stage = "flow", .materials = {"pellet", "sinter", "box"}};
  for (int i = 0; i < 4; ++i) {  // one quarter of the mass is pellets
    s.id.push_back(i);
    s.body.push_back(i);
    s.material.push_back(i == 0 ? 0 : 1);
    s.radius_m.push_back(0.01);
    s.mass_kg.push_back(2.0);
    s.position.push_back({0.0, 0.0, 0.1 * i});
  }
  s.velocity = s.angular_velocity = std::vector<scene::Vec3>(4, scene::Vec3::Zero());
  scene::RunWriter writer(directory / "run", c);
  const auto columns = scene::region_columns(c);
  for (int i = 0; i <= 20; ++i) {
    const double total = i < 4 || i > 16 ? 0.01 : 1.0;
    std::vector<double> masses;
    for (const auto& column : columns)
      masses.push_back(column.find("pellet") != std::string::npos   ? total * 0.5
                       : column.find("sinter") != std::string::npos ? total * 0.5
                       : column.find("box") != std::string::npos    ? 0.0
                                                                    : total);
    writer.add_row(scene::SeriesRow{.time_s = 0.2 * i, .region_mass_kg = masses});
  }
  writer.write_snapshot(s);
  writer.finish({.steps = 1, .time_step_s = 1.0, .engine = "none", .version = "1"});
  const auto run = scene::read_run(directory / "run");
  const auto result = measure_discharge_segregation(run, "outlet");
  EXPECT_NEAR(result.measurement.kpis.at("si_outlet_pellet"), (0.5 - 0.25) / 0.75, 1e-12);
  EXPECT_NEAR(result.measurement.kpis.at("si_outlet_sinter"), 0.25 / 0.25, 1e-12);
  EXPECT_NEAR(result.measurement.details.at("time_min_s"), 0.8, 1e-12);
  EXPECT_NEAR(result.measurement.details.at("time_max_s"), 3.2, 1e-12);
  EXPECT_EQ(result.series.rows(), 13U);
  EXPECT_NEAR(result.series.numbers("nmr_pellet")[7], 2.0, 1e-12);
  EXPECT_THROW(measure_discharge_segregation(run, "inlet"), InputError);
}

}  // namespace
}  // namespace repose::dem_adapter

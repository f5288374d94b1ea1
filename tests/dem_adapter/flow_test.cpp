// Mass flow of curves whose rate is known, densities of lattices, contact forces of a written run.
#include "repose/dem_adapter/flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/dem_adapter/run_bulk.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

/// 10 kg/s between 0.5 and 2.0 s; it rises from 0 before and dies away after, as a discharge does;
/// a load cell's noise.
MassCurve discharge(double noise_kg, double interval_s = 0.005) {
  MassCurve curve;
  RandomStream random(44);
  for (int i = 0; i * interval_s <= 4.0; ++i) {
    const double t = i * interval_s;
    const double out = t < 0.5   ? 10.0 * t * t
                       : t < 2.0 ? 2.5 + 10.0 * (t - 0.5)
                                 : 17.5 + 10.0 * 0.4 * (1.0 - std::exp(-(t - 2.0) / 0.4));
    curve.time_s.push_back(t);
    curve.mass_kg.push_back(40.0 - out + noise_kg * random.normal());
  }
  return curve;
}

TEST(GaussianFilter, KeepsAStraightCurveAndItsSlopeUpToItsEnds) {
  MassCurve curve;
  for (int i = 0; i < 200; ++i) {
    curve.time_s.push_back(0.01 * i + 0.001 * (i % 3));  // unevenly spaced
    curve.mass_kg.push_back(5.0 - 2.0 * curve.time_s.back());
  }
  const auto filtered = gaussian_filtered(curve, 0.05);
  for (std::size_t i = 0; i < 200; ++i) {
    EXPECT_NEAR(filtered.mass_kg[i], curve.mass_kg[i], 1e-12);
    EXPECT_NEAR(filtered.rate_kg_s[i], 2.0, 1e-10);
  }
}

TEST(GaussianFilter, IsTheGaussianMeanFarFromTheEnds) {
  const auto curve = discharge(0.3);
  constexpr double kDeviation = 0.03;
  const auto filtered = gaussian_filtered(curve, kDeviation);
  for (const std::size_t i : {100U, 333U, 600U}) {
    double weights = 0.0, sum = 0.0;
    for (std::size_t j = 0; j < curve.time_s.size(); ++j) {
      const double d = (curve.time_s[j] - curve.time_s[i]) / kDeviation;
      if (std::abs(d) > 4.0 + 1e-9) continue;
      weights += std::exp(-0.5 * d * d);
      sum += std::exp(-0.5 * d * d) * curve.mass_kg[j];
    }
    EXPECT_NEAR(filtered.mass_kg[i], sum / weights, 1e-9);
  }
}

TEST(GaussianFilter, ReducesNoiseAsItsClosedFormSays) {
  // White noise of variance 1, kernel of s samples: variance 1 / (2 s sqrt(pi)).
  MassCurve curve;
  RandomStream random(3);
  for (int i = 0; i < 40000; ++i) {
    curve.time_s.push_back(i);
    curve.mass_kg.push_back(random.normal());
  }
  const auto filtered = gaussian_filtered(curve, 5.0);
  double squares = 0.0;
  for (std::size_t i = 100; i < 39900; ++i) squares += filtered.mass_kg[i] * filtered.mass_kg[i];
  // About 39,800 / (2 sqrt(pi) 5) independent values: four standard errors of a variance.
  const double four = 4.0 * std::sqrt(2.0 * 2.0 * std::sqrt(M_PI) * 5.0 / 39800.0);
  EXPECT_NEAR(squares / 39800.0 * (10.0 * std::sqrt(M_PI)), 1.0, four);
}

TEST(DischargeFlow, FindsTheSteadyWindowAndItsRate) {
  // From where the rate passes 8 kg/s, t = 0.4 s, to where it falls below, 2 + 0.4 ln(10/8) =
  // 2.09 s; a Gaussian of 0.05 s moves these by less than itself. The two ends at lower rates take
  // at most 0.19 of 1.7 s and lower the slope by less than a tenth of their 20 %.
  for (const double noise : {0.0, 0.02}) {
    const auto flow = discharge_flow(discharge(noise));
    EXPECT_NEAR(flow.from_s, 0.40, 0.05) << noise;
    EXPECT_NEAR(flow.to_s, 2.09, 0.05) << noise;
    EXPECT_NEAR(flow.rate_kg_s, 10.0, 0.2) << noise;
    EXPECT_NEAR(flow.discharged_kg, 21.5, 0.1) << noise;
    EXPECT_LT(flow.unsteadiness, 0.15) << noise;
  }
}

TEST(DischargeFlow, IsExactInAWindowThatIsGiven) {
  const auto given = discharge_flow(discharge(0.0), {.window = TimeWindow{0.5, 2.0}});
  EXPECT_NEAR(given.rate_kg_s, 10.0, 1e-9);
  EXPECT_NEAR(given.from_s, 0.5, 1e-9);
  const auto share =
      discharge_flow(discharge(0.0), {.filter_s = 0.0, .window = ShareWindow{0.2, 0.7}});
  EXPECT_NEAR(share.rate_kg_s, 10.0, 1e-9);
  EXPECT_NEAR(share.from_s, 0.5 + (0.2 * share.discharged_kg - 2.5) / 10.0, 0.005);
  // 98 % of 21.5 kg (less what is still to come after 4 s) are out when exp(-(t-2)/0.4) = 0.1 or
  // so.
  EXPECT_NEAR(share.time_98_s, 2.0 + 0.4 * std::log(4.0 / (21.473 * 0.02 + 0.027)), 0.01);
}

TEST(DischargeFlow, DoesNotDependOnTheSamplingInterval) {
  const double fine = discharge_flow(discharge(0.0, 0.002)).rate_kg_s;
  // The window begins and ends within one coarse interval: 2 x 0.02 of 1.7 s at 80 % of the rate.
  EXPECT_NEAR(discharge_flow(discharge(0.0, 0.02)).rate_kg_s, fine, 0.05);
}

TEST(DischargeFlow, IsUndefinedWhereNothingFlows) {
  MassCurve still;
  for (int i = 0; i < 50; ++i) {
    still.time_s.push_back(0.1 * i);
    still.mass_kg.push_back(3.0);
  }
  EXPECT_TRUE(std::isnan(discharge_flow(still).rate_kg_s));
  EXPECT_NE(measure_flow(still).failure.find("nothing flowed"), std::string::npos);
  const auto beyond = measure_flow(discharge(0.0), {.window = TimeWindow{7.0, 8.0}});
  EXPECT_NE(beyond.failure.find("fewer than two points"), std::string::npos);
  EXPECT_TRUE(beyond.kpis.empty());
  EXPECT_TRUE(std::isnan(discharge_flow({}).rate_kg_s));
}

TEST(DischargeFlow, OfTwoPointsIsRefusedInsteadOfDenied) {
  try {
    measure_flow({{0.0, 1.0}, {10.0, 5.0}});
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("has 2 points, at least 3 are needed"),
              std::string::npos)
        << error.what();
  }
  EXPECT_TRUE(std::isnan(discharge_flow({{0.0, 1.0}, {10.0, 5.0}}).discharged_kg));
}

TEST(DischargeFlow, OfALoadCellThatWasSetToZeroHasNoFraction) {
  auto curve = discharge(0.0);
  const double first = curve.mass_kg.front();
  for (double& mass : curve.mass_kg) mass -= first;
  const auto m = measure_flow(curve, {.window = TimeWindow{0.5, 2.0}});
  EXPECT_EQ(m.outcome, Outcome::kpi_undefined);
  EXPECT_NE(m.failure.find("discharged_fraction is undefined"), std::string::npos);
  EXPECT_EQ(m.kpis.count("discharged_fraction"), 0U);
  EXPECT_NEAR(m.kpis.at("mass_flow_kg_s"), 10.0, 1e-9);
}

TEST(DischargeFlow, RefusesCurvesAndOptionsThatMakeNoSense) {
  EXPECT_THROW(discharge_flow({{0.0, 1.0}, {1.0}}), InputError);
  EXPECT_THROW(discharge_flow({{0.0, 1.0, 1.0}, {3.0, 2.0, 1.0}}), InputError);
  EXPECT_THROW(discharge_flow(discharge(0.0), {.filter_s = -1.0}), InputError);
  EXPECT_THROW(discharge_flow(discharge(0.0), {.window = TimeWindow{2.0, 1.0}}), InputError);
  EXPECT_THROW(discharge_flow(discharge(0.0), {.window = ShareWindow{0.5, 0.5}}), InputError);
  EXPECT_THROW(discharge_flow(discharge(0.0), {.window = SteadyWindow{1.0}}), InputError);
}

/// A domain of 1 m with one material of 2000 kg/m3, a second one and a region "box".
scene::Case plain_case() {
  scene::Case c;
  c.materials = {{"sand", 2000.0, 1e7, 0.3}, {"steel", 7800.0, 1e9, 0.3}};
  c.pairs = {{.first = "sand", .second = "sand", .restitution = 0.5, .mu_s = 0.5, .mu_r = 0.1},
             {.first = "sand", .second = "steel", .restitution = 0.5, .mu_s = 0.5, .mu_r = 0.1}};
  c.lower_m = {0.0, 0.0, 0.0};
  c.upper_m = {1.0, 1.0, 1.0};
  c.regions = {{"box", {0, 0, 0}, {1, 1, 1}}, {"bin", {0, 0, 0}, {1, 1, 1}}};
  c.particles.emplace_back();
  c.particles[0].material = "sand";
  c.particles[0].radius_m = 0.01;
  c.particles[0].position = {0.5, 0.5, 0.5};
  c.stages = {{.name = "fill", .duration_s = 1.0}, {.name = "flow", .duration_s = 1.0}};
  return c;
}

/// Spheres of 0.1 m on a simple cubic lattice that fills the domain.
scene::Snapshot lattice() {
  scene::Snapshot s{.stage = "flow", .materials = {"sand", "steel"}};
  for (int i = 0; i < 1000; ++i) {
    s.id.push_back(i);
    s.material.push_back(0);
    s.radius_m.push_back(0.05);
    s.mass_kg.push_back(2000.0 * M_PI / 6.0 * 1e-3);
    s.position.push_back(
        {0.05 + 0.1 * (i % 10), 0.05 + 0.1 * (i / 10 % 10), 0.05 + 0.1 * (i / 100)});
  }
  s.body = s.id;
  s.velocity = s.angular_velocity = std::vector<scene::Vec3>(1000, scene::Vec3::Zero());
  return s;
}

TEST(BulkDensity, OfACubicLatticeIsPiOverSixOfTheSolid) {
  const auto m =
      measure_bulk_density(lattice(), plain_case(), {"", {0.2, 0.1, 0.2}, {0.8, 0.9, 0.6}});
  EXPECT_NEAR(m.kpis.at("solid_fraction"), M_PI / 6.0, 1e-12);
  EXPECT_NEAR(m.kpis.at("bulk_density_kg_m3"), 2000.0 * M_PI / 6.0, 1e-9);
  EXPECT_EQ(m.details.at("grains_sand"), 6.0 * 8.0 * 4.0);
  EXPECT_NEAR(m.details.at("mass_sand_kg"), 192.0 * 2000.0 * M_PI / 6.0 * 1e-3, 1e-9);
  EXPECT_TRUE(m.warnings.empty());
}

TEST(BulkDensity, IsCutOffAtTheDomainAndWarnsOfABoxThatReachesOutOfTheBed) {
  const auto c = plain_case();
  const auto all = measure_bulk_density(lattice(), c, {"", {-9, -9, -9}, {9, 9, 9}});
  EXPECT_NEAR(all.kpis.at("solid_fraction"), M_PI / 6.0, 1e-12);
  auto half = lattice();
  for (auto& x : half.position) x.z() *= 0.5;  // two to a place
  const auto warned = measure_bulk_density(half, c, {"", {0, 0, 0}, {1, 1, 0.9}});
  EXPECT_EQ(warned.warnings.size(), 1U);
  EXPECT_THROW(measure_bulk_density(lattice(), c, {"", {2, 2, 2}, {3, 3, 3}}), InputError);
}

TEST(RunBulk, FlowAndContactsComeFromTheSeriesOfTheRun) {
  const test::TemporaryDirectory directory;
  const auto c = plain_case();
  scene::RunWriter writer(directory / "run", c);
  const auto columns = scene::region_columns(c);
  for (int i = 0; i <= 200; ++i) {  // filled within 0.5 s, rests, flows from 1.0 to 1.5 s at 4 kg/s
    const double t = 0.01 * i;
    const double mass = 2.0 * std::min(t / 0.5, 1.0) - 4.0 * std::clamp(t - 1.0, 0.0, 0.5);
    std::vector<double> masses;
    for (const auto& column : columns)
      masses.push_back(column.find("steel") != std::string::npos ? 0.0
                       : column.find("bin") != std::string::npos ? 5.0  // stays
                                                                 : mass);
    writer.add_row(scene::SeriesRow{.time_s = t, .region_mass_kg = masses});
    const double n = i <= 100 ? 7.0 : i % 2 == 0 ? 10.0 : 30.0;  // of contacts
    writer.add_row(scene::ContactRow{.time_s = t,
                                     .pairs = {{.contacts = static_cast<std::int64_t>(n),
                                                .mean_normal_force_n = 100.0 / n,
                                                .largest_normal_force_n = 50.0,
                                                .mean_overlap_ratio = 0.01,
                                                .sliding_fraction = 0.2},
                                               {}}});
  }
  writer.write_snapshot(lattice());
  writer.finish({.steps = 1,
                 .time_step_s = 1.0,
                 .engine = "none",
                 .version = "1",
                 .stages = {{"fill", 1.0, "duration"}, {"flow", 2.0, "duration"}}});
  const auto run = scene::read_run(directory / "run");
  const auto curve = discharge_curve(run, "box");
  EXPECT_NEAR(curve.time_s.front(), 1.0, 1e-9);
  const auto flow = measure_flow(curve, {.filter_s = 0.0, .window = ShareWindow{}});
  EXPECT_NEAR(flow.kpis.at("mass_flow_kg_s"), 4.0, 1e-9);
  EXPECT_NEAR(flow.kpis.at("discharged_fraction"), 1.0, 1e-12);
  EXPECT_NEAR(measure_flow(curve).kpis.at("mass_flow_kg_s"), 4.0, 0.1);
  EXPECT_THROW(discharge_curve(run, "hopper"), InputError);
  EXPECT_EQ(measure_flow(discharge_curve(run, "bin")).outcome, Outcome::nothing_flowed);
  // 50 rows of 10 contacts and 50 of 30, each with 100 N in all: 10,000 N over 2,000 contacts.
  const auto contacts = measure_contacts(run);
  EXPECT_EQ(contacts.kpis.size(), 1U);
  EXPECT_NEAR(contacts.kpis.at("mean_normal_force_sand_sand_n"), 5.0, 1e-12);
  EXPECT_NEAR(contacts.details.at("contacts_sand_sand"), 20.0, 1e-12);
  EXPECT_NEAR(contacts.details.at("sliding_fraction_sand_sand"), 0.2, 1e-12);
  EXPECT_NEAR(measure_contacts(run, "fill").kpis.at("mean_normal_force_sand_sand_n"), 100.0 / 7.0,
              1e-9);
  EXPECT_THROW(measure_contacts(run, "drain"), InputError);
}

}  // namespace
}  // namespace repose::dem_adapter

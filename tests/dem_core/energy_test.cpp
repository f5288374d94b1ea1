#include <gtest/gtest.h>

#include "small_cases.hpp"

namespace repose::dem {
namespace {

double largest_error(scene::Case c, double fraction, double duration) {
  c.output.energy = true;
  c.time_step_rayleigh_fraction = fraction;
  Simulation sim(c);
  double largest = 0.0;
  while (sim.time_s() < duration) {
    sim.step(20);
    largest = std::max(largest, std::abs(sim.energy().error_j));
  }
  return largest;
}

TEST(EnergyLedger, ClosesForAnElasticSphereToTheSquareOfTheStep) {
  scene::Case c = empty_case({.restitution = 1.0});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor_plane()};
  c.particles = {grain(0.01, {0, 0, 0.03})};
  const double fall = sphere_mass(0.01, 2500.0) * 9.81 * 0.02;
  const double coarse = largest_error(c, 0.2, 0.3);
  const double fine = largest_error(c, 0.1, 0.3);
  EXPECT_LT(coarse, 0.02 * fall);
  EXPECT_LT(fine, 0.35 * coarse);
}

/// Spheres and clumps falling into a bin.
scene::Case splash() {
  scene::Case c = empty_case({.restitution = 0.5, .mu_s = 0.4, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.lower_m.setConstant(-0.5);
  c.upper_m.setConstant(0.5);
  c.walls = scene::box_walls("bin", "wall", {-0.04, -0.04, 0}, {0.04, 0.04, 0.2}, {"+z"});
  const std::vector<scene::SizeClass> sizes{{0.008, 0.012, 1.0}};
  scene::Layer layer{
      0.1,
      {{.material = "grain", .mass_fraction = 0.5, .sizes = sizes},
       {.material = "grain", .clump = "sinter_3", .mass_fraction = 0.5, .sizes = sizes}}};
  c.fill = scene::Fill{{-0.04, -0.04, 0}, {0.04, 0.04, 0.2}, 0.2, {layer}};
  return c;
}

TEST(EnergyLedger, OfASplashClosesToTheOrderOfTheStep) {
  scene::Case c = splash();
  c.output.energy = true;
  double error[2];
  for (int level = 0; level < 2; ++level) {
    c.time_step_rayleigh_fraction = 0.1 / (1 << level);
    Simulation sim(c);
    const double before = sim.energy().gravitational_j;
    while (sim.time_s() < 0.3) sim.step(50);
    const scene::EnergyRow row = sim.energy();
    const double released = before - row.gravitational_j;
    error[level] = row.error_j / released;
    EXPECT_GT(row.dissipated_normal_j, 0.0);
    EXPECT_GT(row.dissipated_sliding_j, 0.0);
    EXPECT_GT(row.dissipated_rolling_j, 0.0);
    EXPECT_LT(std::abs(error[level]), 0.03);
  }
  EXPECT_LT(std::abs(error[1]), 0.7 * std::abs(error[0]) + 0.002);
}

/// Two spheres at rest, one on the other, on a rectangle.
scene::Case stack() {
  scene::Case c = empty_case({.restitution = 0.3, .mu_s = 0.5, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.output.energy = true;
  c.walls = {rectangle("gate", {-0.1, -0.1, 0}, {0.2, 0, 0}, {0, 0.2, 0})};
  const double e_eff = 1e8 / (2.0 * (1.0 - 0.0625));
  const double weight = sphere_mass(0.01, 2500.0) * 9.81;
  const double lower = hertz_overlap(e_eff, 0.01, 2.0 * weight);
  const double upper = hertz_overlap(e_eff, 0.005, weight);
  c.particles = {grain(0.01, {0, 0, 0.01 - lower}), grain(0.01, {0, 0, 0.03 - lower - upper})};
  return c;
}

TEST(EnergyLedger, LosesNothingWhenAGateOpensUnderLoad) {
  Simulation sim(stack());
  sim.step(2000);
  const scene::EnergyRow before = sim.energy();
  const double stored =
      before.elastic_normal_j + before.elastic_tangential_j + before.elastic_rolling_j;
  ASSERT_GT(stored, 0.0);
  sim.open("gate");
  sim.step(200);
  const scene::EnergyRow after = sim.energy();
  EXPECT_GT(after.released_j, 0.3 * stored);  // what the gate had stored is gone
  EXPECT_NEAR(after.error_j, before.error_j, 0.02 * stored);
}

TEST(EnergyLedger, LosesNothingWhenASphereIsTakenOutOfAContact) {
  scene::Case c = stack();
  scene::Region sink;
  sink.name = "drain";
  sink.lower = {-1, -1, 0.02};
  sink.upper = {1, 1, 1};
  sink.removes = true;
  c.regions = {sink};
  Simulation sim(c);
  const double stored = sim.energy().elastic_normal_j;
  sim.step(2000);
  ASSERT_EQ(sim.size(), 1u);
  const scene::EnergyRow row = sim.energy();
  EXPECT_GT(row.released_j, 0.0);
  EXPECT_NEAR(row.error_j, 0.0, 0.02 * stored);
}

TEST(EnergyLedger, DoesNotNoticeAPeriodicSideThatGravityPullsAcross) {
  scene::Case c = empty_case({});
  c.gravity_m_s2 = {5, 0, 0};
  c.lower_m = {0, -1, -1};
  c.upper_m = {0.1, 1, 1};
  c.periodic.x = true;
  c.output.energy = true;
  c.particles = {grain(0.01, {0.05, 0, 0}), grain(0.01, {0.05, 0.5, 0})};
  c.particles[1].clump = "sinter_3";
  Simulation sim(c);
  while (sim.time_s() < 0.4) sim.step(20);
  const scene::EnergyRow row = sim.energy();
  const double gained = row.kinetic_translational_j;
  EXPECT_GT(gained, 0.0);
  EXPECT_NEAR(row.error_j, 0.0, 1e-9 * gained);
}

TEST(EnergyLedger, CountsWhatComesAndGoes) {
  scene::Case c = empty_case({.restitution = 0.5});
  c.gravity_m_s2.z() = -9.81;
  c.output.energy = true;
  scene::Rain rain;
  rain.name = "feed";
  rain.mixture = {{.material = "grain", .sizes = std::vector<scene::SizeClass>{{0.01, 0.01, 1.0}}}};
  rain.mass_kg = 0.05;
  rain.mass_rate_kg_s = 0.5;
  rain.lower = {-0.1, -0.1, 0.3};
  rain.upper = {0.1, 0.1, 0.5};
  rain.velocity = {0.1, 0, -1};
  c.rains = {rain};
  scene::Region sink;
  sink.name = "drain";
  sink.lower = {-9, -9, -9};
  sink.upper = {9, 9, 0.0};
  sink.removes = true;
  c.regions = {sink};
  Simulation sim(c);
  while (sim.time_s() < 0.5) sim.step(50);
  ASSERT_EQ(sim.size(), 0u);
  const scene::EnergyRow row = sim.energy();
  // Free fall: what came in goes out, to the rounding of a leapfrog that is exact for it.
  EXPECT_GT(row.inserted_j, 0.0);
  EXPECT_NEAR(row.removed_j, row.inserted_j, 1e-9 * row.inserted_j);
  EXPECT_NEAR(row.error_j, 0.0, 1e-9 * row.inserted_j);
}

TEST(EnergyLedger, CostsNothingInTheResult) {
  scene::Case c = splash();
  const auto state = [&](bool energy) {
    c.output.energy = energy;
    Simulation sim(c);
    sim.step(3000);
    return sim.spheres();
  };
  const auto with = state(true);
  const auto without = state(false);
  for (std::size_t s = 0; s < with.size(); ++s) EXPECT_EQ(with[s].position, without[s].position);
}

TEST(ContactStatistics, OfASphereAtRestAreItsWeightAndOverlap) {
  scene::Case c = empty_case({.restitution = 0.3, .mu_s = 0.5});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor_plane()};
  c.particles = {grain(0.01, {0, 0, 0.01}), grain(0.01, {0.1, 0, 0.01})};
  Simulation sim(c);
  while (sim.time_s() < 0.3) sim.step(100);
  const auto before = sim.spheres();
  const std::vector<scene::PairContacts> pairs = sim.contact_statistics();
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].contacts, 0);
  EXPECT_EQ(pairs[0].mean_normal_force_n, 0.0);
  EXPECT_EQ(pairs[1].contacts, 2);
  const double weight = sphere_mass(0.01, 2500.0) * 9.81;
  EXPECT_NEAR(pairs[1].mean_normal_force_n, weight, 1e-3 * weight);
  EXPECT_NEAR(pairs[1].largest_normal_force_n, weight, 1e-3 * weight);
  const double d = hertz_overlap(1e8 / (2.0 * (1.0 - 0.0625)), 0.01, weight);
  EXPECT_NEAR(pairs[1].mean_overlap_ratio, d / 0.01, 1e-3 * d / 0.01);
  EXPECT_EQ(pairs[1].sliding_fraction, 0.0);
  // Looking does not touch.
  const auto after = sim.spheres();
  for (std::size_t s = 0; s < 2; ++s) EXPECT_EQ(before[s].position, after[s].position);
}

}  // namespace
}  // namespace repose::dem

// What a run records: regions, loads on walls, clumps, what came and went, how stages end.
#include <gtest/gtest.h>

#include <unistd.h>

#include "repose/base/error.hpp"
#include "repose/dem/run_case.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

namespace fs = std::filesystem;

/// Runs a case in a folder that goes away with the object.
struct Recorded {
  fs::path path =
      fs::temp_directory_path() / ("repose_records_" + std::to_string(::getpid()) + "_" +
                                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
  ~Recorded() { fs::remove_all(path); }
  scene::Run run(const scene::Case& c) {
    run_case(c, path);
    return scene::read_run(path);
  }
};

/// Soft grains above the plane z = 0 under gravity, one stage of 0.5 s.
scene::Case above_a_floor() {
  scene::Case c = empty_case({.youngs_modulus = 1e6, .restitution = 0.3, .mu_s = 0.5, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.lower_m = {-1, -1, -1};
  c.upper_m = {1, 1, 1};
  c.walls = {floor_plane()};
  c.stages = {{.name = "fall", .duration_s = 0.5}};
  return c;
}

scene::Rain rain_of(double mass_kg, double rate_kg_s) {
  scene::Rain rain;
  rain.name = "rain";
  rain.mixture = {{.material = "grain", .sizes = std::vector<scene::SizeClass>{{0.01, 0.01, 1.0}}}};
  rain.mass_kg = mass_kg;
  rain.mass_rate_kg_s = rate_kg_s;
  rain.lower = {-0.2, -0.2, 0.3};
  rain.upper = {0.2, 0.2, 0.5};
  return rain;
}

TEST(RunRecords, HaveTheWeightOfAGrainOnTheFloor) {
  scene::Case c = above_a_floor();
  c.particles = {grain(0.01, {0.1, 0.2, 0.01})};
  Recorded recorded;
  const table::Table walls = recorded.run(c).walls();
  const double weight = sphere_mass(0.01, 2500.0) * 9.81;
  // At rest after some 0.1 s; what is left of the bounce decays with exp(-t beta omega).
  EXPECT_NEAR(walls.numbers("fz_floor_n").back(), -weight, 1e-6 * weight);
  EXPECT_NEAR(walls.numbers("tx_floor_n_m").back(), -0.2 * weight, 1e-6 * weight);
  EXPECT_NEAR(walls.numbers("ty_floor_n_m").back(), 0.1 * weight, 1e-6 * weight);
  EXPECT_GT(walls.numbers("time_s").front(), 0.0);  // a mean over an interval, not a start
}

TEST(RunRecords, CountAClumpWhereItsCentreIs) {
  scene::Case c = above_a_floor();
  c.gravity_m_s2.setZero();
  c.stages[0].duration_s = 0.001;
  scene::Particle clump = grain(0.02, {0.0, 0.0, 0.5});
  clump.clump = "sinter_3";
  c.particles = {clump};
  // Centred in one region, with parts of its spheres in the other.
  c.regions = {{"left", {-1, -1, 0}, {0.001, 1, 1}}, {"right", {0.001, -1, 0}, {1, 1, 1}}};
  Recorded recorded;
  const scene::Run run = recorded.run(c);
  const double mass = sphere_mass(0.02, 2500.0);  // of the sphere of its volume
  EXPECT_NEAR(run.series().numbers("mass_left_kg").back(), mass, 1e-9 * mass);
  EXPECT_NEAR(run.series().numbers("mass_left_grain_kg").back(), mass, 1e-9 * mass);
  EXPECT_EQ(run.series().numbers("mass_right_kg").back(), 0.0);

  const scene::Snapshot end = run.end_of("fall");
  ASSERT_EQ(end.size(), 3u);
  EXPECT_EQ(end.body, std::vector<std::int64_t>(3, end.body[0]));
  EXPECT_NEAR(end.mass_kg[0] + end.mass_kg[1] + end.mass_kg[2], mass, 1e-9 * mass);
  EXPECT_EQ(run.summary().spheres, 3);
  EXPECT_EQ(run.summary().bodies.alive, 1);
}

TEST(RunRecords, BalanceWhatCameAndWhatWent) {
  scene::Case c = above_a_floor();
  c.rains = {rain_of(0.05, 0.2)};
  c.regions = {{"sink", {-1, -1, -1}, {0, 1, 0.2}, {}, true}};
  Recorded recorded;
  const scene::Run run = recorded.run(c);
  const scene::Ledger& bodies = run.summary().bodies;
  const double one = sphere_mass(0.005, 2500.0);
  EXPECT_NEAR(bodies.inserted_kg, 0.05, one);
  EXPECT_EQ(bodies.inserted, bodies.removed + bodies.alive);
  EXPECT_NEAR(bodies.removed_kg, static_cast<double>(bodies.removed) * one, 1e-12);
  EXPECT_NEAR(bodies.inserted_kg, bodies.removed_kg + bodies.alive_kg, 1e-12);
  EXPECT_GT(bodies.removed, 0);
  EXPECT_GT(bodies.alive, 0);
  const scene::Snapshot end = run.end_of("fall");
  EXPECT_EQ(static_cast<std::int64_t>(end.size()), bodies.alive);
  for (std::size_t i = 1; i < end.size(); ++i) EXPECT_LT(end.id[i - 1], end.id[i]);
}

TEST(RunRecords, AreNotAtRestBeforeTheRainHasFallen) {
  scene::Case c = above_a_floor();
  c.particles = {grain(0.01, {0.5, 0.5, 0.01})};
  c.rains = {rain_of(0.004, 0.02)};
  c.rains[0].start_s = 0.3;
  c.stages[0].duration_s = 3.0;
  c.stages[0].at_rest = scene::AtRest{.kinetic_energy_ratio = 0.1, .window_s = 0.05};
  Recorded recorded;
  const scene::Run run = recorded.run(c);
  EXPECT_EQ(run.summary().stages[0].reason, "at rest");
  EXPECT_GT(run.summary().stages[0].time_s, 0.3 + 0.004 / 0.02);
  EXPECT_LT(run.summary().stages[0].time_s, 3.0);
}

TEST(RunRecords, SayHowMuchRainIsMissingWhenTheRunEndsEarly) {
  scene::Case c = above_a_floor();
  c.particles = {grain(0.01, {0.5, 0.5, 0.1})};
  c.rains = {rain_of(0.02, 0.02)};
  c.stages[0].duration_s = 2.0;
  c.regions = {{"above", {0.4, 0.4, 0.05}, {0.6, 0.6, 1}}};
  c.stages[0].flow_ends = scene::FlowEnds{.region = "above", .fraction = 0.5, .window_s = 0.1};
  Recorded recorded;
  try {
    recorded.run(c);
    ADD_FAILURE() << "a run without all of its rain was accepted";
  } catch (const SimulationError& error) {
    EXPECT_NE(std::string(error.what()).find("kg of rain had not fallen"), std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(fs::exists(recorded.path / "run.h5"));
}

TEST(RunRecords, FollowAMovingWallInVtpFiles) {
  scene::Case c = above_a_floor();
  c.particles = {grain(0.01, {0.5, 0.5, 0.5})};
  c.walls.push_back(rectangle("gate", {0, 0, 0.1}, {0.1, 0, 0}, {0, 0.1, 0}));
  c.motions = {{.walls = {"gate"}, .path = scene::Translation{{0, 0, 1}}}};
  c.motions[0].end_s = 0.15;
  c.stages[0].duration_s = 0.3;
  c.output.snapshot_interval_s = 0.1;
  c.output.vtp = true;
  Recorded recorded;
  recorded.run(c);
  for (const char* file : {"walls_000001.vtp", "walls_000002.vtp"})
    EXPECT_TRUE(fs::exists(recorded.path / "vtp" / file)) << file;
  EXPECT_FALSE(fs::exists(recorded.path / "vtp" / "walls_000003.vtp"));  // it has stopped
  EXPECT_TRUE(fs::exists(recorded.path / "vtp" / "particles_000003.vtp"));
}

}  // namespace
}  // namespace repose::dem

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "repose/base/error.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

/// A box that particles rain into.
scene::Case rainy_case() {
  scene::Case c = empty_case({.restitution = 0.3, .mu_s = 0.5, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.lower_m.setConstant(-0.5);
  c.upper_m.setConstant(0.5);
  c.walls = scene::box_walls("bin", "wall", {-0.05, -0.05, 0}, {0.05, 0.05, 0.4}, {"+z"});
  scene::Rain rain;
  rain.name = "feed";
  rain.mixture = {
      {.material = "grain", .sizes = std::vector<scene::SizeClass>{{0.008, 0.01, 1.0}}}};
  rain.mass_kg = 0.1;
  rain.mass_rate_kg_s = 0.5;
  rain.lower = {-0.04, -0.04, 0.25};
  rain.upper = {0.04, 0.04, 0.3};
  rain.velocity = {0, 0, -0.5};
  c.rains = {rain};
  return c;
}

TEST(Rain, BringsItsMassAtItsRate) {
  Simulation sim(rainy_case());
  EXPECT_EQ(sim.size(), 0u);
  const double largest = sphere_mass(0.005, 2500.0);
  while (sim.time_s() < 0.3) {
    sim.step(100);
    const double due = std::min(0.1, 0.5 * sim.time_s());
    EXPECT_NEAR(sim.mass_kg(), due, largest + 0.5 * 100 * sim.time_step_s());
  }
  EXPECT_NEAR(sim.mass_kg(), 0.1, 0.5 * sphere_mass(0.004, 2500.0));
  EXPECT_EQ(sim.outstanding_rain_kg(), 0.0);
  EXPECT_EQ(sim.ledger().inserted, static_cast<std::int64_t>(sim.size()));
}

TEST(Rain, NeverPlacesAParticleInAnother) {
  scene::Case c = rainy_case();
  c.rains[0].mass_rate_kg_s = 2.0;
  Simulation sim(c);
  std::size_t seen = 0;
  while (sim.time_s() < 0.06) {
    sim.step(1);
    if (sim.size() == seen) continue;
    const std::size_t before = seen;
    seen = sim.size();
    const auto spheres = sim.spheres();
    for (std::size_t i = 0; i < seen; ++i)  // rain comes after all have moved
      for (std::size_t j = std::max(i + 1, before); j < seen; ++j)
        EXPECT_GE((spheres[i].position - spheres[j].position).norm(),
                  (spheres[i].radius_m + spheres[j].radius_m) * (1.0 - 1e-15));
  }
  EXPECT_GT(seen, 20u);
}

TEST(Rain, OfAStageWaitsForIt) {
  scene::Case c = rainy_case();
  c.stages = {{.name = "pour", .duration_s = 1.0}};
  c.rains[0].stage = "pour";
  c.rains[0].start_s = 0.02;
  Simulation sim(c);
  while (sim.time_s() < 0.05) sim.step(10);
  EXPECT_EQ(sim.size(), 0u);
  sim.begin_stage("pour");
  const double begun = sim.time_s();
  while (sim.time_s() < begun + 0.018) sim.step(10);
  EXPECT_EQ(sim.size(), 0u);
  while (sim.time_s() < begun + 0.05) sim.step(10);
  EXPECT_GT(sim.size(), 5u);
}

TEST(Rain, StartsWithTheVelocityItWasGiven) {
  scene::Case c = rainy_case();
  Simulation sim(c);
  while (sim.size() == 0) sim.step();
  // Rain comes at the beginning of a step's forces: the first state seen is the state inserted.
  EXPECT_NEAR(sim.spheres()[0].velocity.z(), -0.5, 1e-12);
}

TEST(Rain, IsTheSameInEveryRun) {
  const auto run = [] {
    Simulation sim(rainy_case());
    while (sim.time_s() < 0.15) sim.step(100);
    return sim.spheres();
  };
  const auto a = run();
  const auto b = run();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].position, b[i].position);
}

TEST(Rain, ThatFindsNoRoomSaysHowFarItCame) {
  scene::Case c = rainy_case();
  c.gravity_m_s2.setZero();
  c.rains[0].velocity.setZero();  // nothing leaves the box that it appears in
  c.rains[0].mass_kg = 5.0;
  c.rains[0].mass_rate_kg_s = 2.0;
  Simulation sim(c);
  try {
    while (sim.time_s() < 3.0) sim.step(1000);
    FAIL();
  } catch (const SimulationError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("rain \"feed\""), std::string::npos) << text;
    EXPECT_NE(text.find("kg are due"), std::string::npos) << text;
  }
}

TEST(Rain, OfLessThanAParticleIsRefused) {
  scene::Case c = rainy_case();
  c.rains[0].mass_kg = 1e-6;
  try {
    Simulation sim(c);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("rain \"feed\": mass_kg"), std::string::npos);
  }
}

TEST(Rain, OfClumpsTurnsThemAtRandom) {
  scene::Case c = rainy_case();
  c.rains[0].mixture[0].clump = "sinter_3";
  Simulation sim(c);
  while (sim.outstanding_rain_kg() > 0.0) sim.step(100);
  std::map<double, int> orientations;
  for (const Body& body : sim.bodies()) {
    EXPECT_EQ(body.spheres, 3);
    ++orientations[body.orientation_wxyz[0]];
  }
  EXPECT_EQ(orientations.size(), sim.bodies().size());
}

TEST(Sink, RemovesWhatComesIntoIt) {
  scene::Case c = rainy_case();
  c.rains[0].mixture.push_back({.material = "grain",
                                .clump = "sinter_3",
                                .mass_fraction = 0.5,
                                .sizes = std::vector<scene::SizeClass>{{0.01, 0.01, 1.0}}});
  c.rains[0].mixture[0].mass_fraction = 0.5;
  scene::Region sink;
  sink.name = "drain";
  sink.lower = {-1, -1, -1};
  sink.upper = {1, 1, 0.05};
  sink.removes = true;
  c.regions = {sink};
  Simulation sim(c);
  while (sim.time_s() < 0.5) {
    sim.step(100);
    const scene::Ledger l = sim.ledger();
    EXPECT_EQ(l.inserted, l.alive + l.removed);
    EXPECT_NEAR(l.inserted_kg, l.alive_kg + l.removed_kg, 1e-15);
    for (const Body& body : sim.bodies()) EXPECT_GE(body.position.z(), 0.05);
  }
  EXPECT_EQ(sim.size(), 0u);
  EXPECT_NEAR(sim.ledger().removed_kg, 0.1, sphere_mass(0.005, 2500.0));
}

TEST(Sink, LeavesTheOthersUndisturbed) {
  // A stack of two in a groove beside spheres that are taken away one by one: the stack goes on to
  // the bit as it does alone, contact history included.
  scene::Case c = empty_case({.restitution = 0.3, .mu_s = 0.5, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor_plane()};
  c.particles = {grain(0.01, {0, 0, 0.0099}, {0.1, 0, 0}), grain(0.01, {0.002, 0, 0.0298})};
  const auto run = [](const scene::Case& scene) {
    Simulation sim(scene);
    sim.step(30000);
    auto spheres = sim.spheres();
    spheres.resize(2);
    return spheres;
  };
  const auto alone = run(c);
  for (int k = 0; k < 20; ++k)
    c.particles.push_back(grain(0.01, {1.0 + 0.05 * k, 0.3, 0.02 + 0.01 * k}, {0.5, 0, 0}));
  scene::Region sink;
  sink.name = "drain";
  sink.lower = {1.2, -1, -1};
  sink.upper = {9, 1, 1};
  sink.removes = true;
  c.regions = {sink};
  const auto beside = run(c);
  for (std::size_t s = 0; s < 2; ++s) EXPECT_EQ(alone[s].position, beside[s].position);
}

TEST(MixedLayer, HasTheMassFractionsAndKindsThatWereAsked) {
  scene::Case c = empty_case({});
  c.gravity_m_s2.z() = -9.81;
  c.materials.push_back({"heavy", 5000.0, 1e8, 0.25});
  for (const char* other : {"heavy", "grain", "wall"})
    c.pairs.push_back({"heavy", other, 0.5, 0.3, 0.0});
  const std::vector<scene::SizeClass> sizes{{0.008, 0.012, 1.0}};
  scene::Layer layer{0.5,
                     {{.material = "grain", .mass_fraction = 0.3, .sizes = sizes},
                      {.material = "heavy", .mass_fraction = 0.7, .sizes = sizes}}};
  c.fill = scene::Fill{{-0.05, -0.05, 0}, {0.05, 0.05, 0.4}, 0.3, {layer}};
  Simulation sim(c);
  std::map<int, double> mass;
  std::map<int, double> height;
  for (const Sphere& s : sim.spheres()) {
    mass[s.material] += s.mass_kg;
    height[s.material] += s.mass_kg * s.position.z();
  }
  EXPECT_NEAR(mass[0], 0.15, 0.5 * sphere_mass(0.004, 2500.0));
  EXPECT_NEAR(mass[2], 0.35, 0.5 * sphere_mass(0.004, 5000.0));
  // Mixed: both have the same mean height to a few standard errors of a hundred particles.
  EXPECT_NEAR(height[0] / mass[0], height[2] / mass[2], 0.01);
}

TEST(ParticleTable, FromCsvIsPlacedAsItStands) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "repose_particle_table_test.csv";
  std::ofstream(file) << "x_m [m],y_m [m],z_m [m],radius_m [m],vx_m_s,vy_m_s,vz_m_s\n"
                         "0.1,0.2,0.3,0.01,1,2,3\n-0.1,0.25,0.3,0.02,0,0,0\n";
  scene::Case c = empty_case({});
  c.particle_tables = {{.location = file.string(), .material = "grain"}};
  const auto spheres = Simulation(c).spheres();
  ASSERT_EQ(spheres.size(), 2u);
  EXPECT_EQ(spheres[0].position, Vec3(0.1, 0.2, 0.3));
  EXPECT_LT((spheres[0].velocity - Vec3(1, 2, 3)).norm(), 1e-15);
  EXPECT_EQ(spheres[1].radius_m, 0.02);
  c.particle_tables[0].material = "";
  EXPECT_THROW(Simulation{c}, InputError);
  c.particle_tables[0].material = "grain";
  c.upper_m.x() = 0.05;
  EXPECT_THROW(Simulation{c}, InputError);
  c.upper_m.x() = 1.0;
  c.particle_tables[0].content_hash = 1;
  EXPECT_THROW(Simulation{c}, InputError);
  std::filesystem::remove(file);
}

TEST(Simulation, RefusesAStepInWhichTheFastestParticleJumps) {
  scene::Case c = empty_case({});
  c.particles = {grain(0.01, {0, 0, 0}, {1e3, 0, 0})};
  try {
    Simulation(c).step();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("fastest particle"), std::string::npos);
  }
}

TEST(Simulation, StartsWithoutAKickFromAFastWallThatHasNoFriction) {
  scene::Case c = empty_case({.restitution = 0.5});
  c.walls = {floor_plane()};
  c.motions = {{.walls = {"floor"}, .path = scene::Translation{.velocity_m_s = {5, 0, 0}}}};
  c.particles = {grain(0.01, {0, 0, 0.0099})};
  Simulation sim(c);
  sim.step(50);
  EXPECT_EQ(sim.spheres()[0].velocity.x(), 0.0);
}

TEST(Simulation, StopsWhenASphereJumps) {
  scene::Case c = empty_case({});
  c.gravity_m_s2.z() = -1e9;
  c.walls = {floor_plane()};
  c.particles = {grain(0.01, {0, 0, 5})};
  try {
    Simulation sim(c);
    sim.step(1000);
    FAIL();
  } catch (const SimulationError& error) {
    EXPECT_NE(std::string(error.what()).find("sphere 0 at (0, 0, 4."), std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("in one time step"), std::string::npos);
  }
}

TEST(Simulation, RefusesToStartWithAParticleDeepInAWall) {
  scene::Case c = empty_case({});
  c.walls = scene::box_walls("bin", "wall", {-0.01, -0.01, 0}, {0.01, 0.01, 0.1}, {});
  c.particles = {grain(0.03, {0, 0, 0.05})};
  try {
    Simulation(c).step();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("larger than its container"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace repose::dem

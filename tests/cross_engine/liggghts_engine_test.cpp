// LIGGGHTS as an engine: what it refuses, what becomes of its failures, and small cases that it
// runs as the bundled engine does.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <cstdlib>

#include <cmath>
#include <fstream>

#include "../dem_adapter/temporary_directory.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem_adapter/engine_choice.hpp"
#include "repose/dem_adapter/liggghts.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

bool is_installed() {
  return std::system("command -v liggghts >/dev/null 2>&1") == 0;
}
#define SKIP_WITHOUT_LIGGGHTS() \
  if (!is_installed()) GTEST_SKIP() << "liggghts is not installed (Debian package liggghts)"

/// A sphere of 10 mm above a gate at z = 0 in a box without lid, floor plane at z = -0.1.
scene::Case ball() {
  scene::Case c;
  c.lower_m = {-0.1, -0.1, -0.12};
  c.upper_m = {0.1, 0.1, 0.2};
  c.materials = {{"glass", 2500.0, 1e7, 0.25}, {"steel", 7800.0, 2e9, 0.3}};
  c.pairs = {{"glass", "glass", 0.5, 0.5, 0.05}, {"glass", "steel", 0.3, 0.5, 0.05}};
  c.walls = {{"floor", "steel", scene::Plane{{0, 0, -0.1}, {0, 0, 1}}},
             {"gate", "steel", scene::Rectangle{{-0.04, -0.04, 0}, {0.08, 0, 0}, {0, 0.08, 0}}}};
  c.regions = {{"above", {-1, -1, 0}, {1, 1, 1}}};
  c.particles = {{.material = "glass", .position = {0.001, 0.002, 0.03}, .radius_m = 0.005}};
  c.stages = {{.name = "fall", .duration_s = 0.05}};
  return c;
}

/// A run of a case in a folder of its own.
class Bench {
 public:
  EngineExit run(const Engine& engine, const scene::Case& scene, int ranks = 1) {
    job_ = folder_.path() / fmt::format("run{}", ++runs_);
    fs::create_directories(job_);
    scene::write_case(job_ / "case.toml", scene);
    return engine.run({.directory = job_, .ranks = ranks});
  }
  scene::Run output() const { return scene::read_run(job_ / "output"); }
  const fs::path& job() const { return job_; }
  fs::path program(const std::string& body) const {
    const auto path = folder_.path() / "liggghts.sh";
    std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
    ::chmod(path.c_str(), 0755);
    return path;
  }

 private:
  test::TemporaryDirectory folder_;
  fs::path job_;
  int runs_ = 0;
};

/// Finished, with what it said if not.
void expect_finished(const EngineExit& exit) {
  EXPECT_EQ(exit.status, EngineStatus::finished) << exit.message;
}

TEST(LiggghtsEngine, RefusesByNameWhatLiggghtsCannotDo) {
  Bench bench;
  const LiggghtsEngine engine({.liggghts = "/bin/false"});
  const auto refused = [&](const char* message, auto change) {
    auto c = ball();
    change(c);
    try {
      bench.run(engine, c);
      ADD_FAILURE() << message;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
    EXPECT_FALSE(fs::exists(bench.job() / "engine.log")) << message;  // nothing was started
  };
  refused("contact.tail", [](auto& c) { c.contact.tail = scene::Tail::clip; });
  refused("restitution = 0.04 of pair glass - steel",
          [](auto& c) { c.pairs[1].restitution = 0.04; });
  refused("rolling_damping = 0.3",
          [](auto& c) { c.contact.rolling_stiffness = scene::RollingStiffness::kt; });
  refused("clump \"sinter_3\"", [](auto& c) { c.particles[0].clump = "sinter_3"; });
  refused("region \"above\" with removes", [](auto& c) { c.regions[0].removes = true; });
  refused("cylinder of region \"above\"", [](auto& c) {
    c.regions[0].cylinder = scene::RegionCylinder{{0, 0, 0}, {0.1, 0, 0.1}, 0.05};
  });
  refused("coefficients of stage \"fall\"", [](auto& c) {
    c.stages[0].coefficients = scene::StageCoefficients{0.5, 0.1, 0.1};
  });
  refused("output.energy", [](auto& c) { c.output.energy = true; });
  refused("rain \"shower\"", [](auto& c) {
    c.rains = {{.name = "shower",
                .mixture = {{.material = "glass",
                             .sizes = std::vector<scene::SizeClass>{{0.01, 0.01, 1.0}}}},
                .mass_kg = 0.01,
                .mass_rate_kg_s = 1.0,
                .lower = {-0.05, -0.05, 0.1},
                .upper = {0.05, 0.05, 0.15}}};
  });
  refused("has two motions", [](auto& c) {
    c.motions = {{.walls = {"gate"}, .path = scene::Translation{{0, 0, 0.1}}},
                 {.walls = {"gate"}, .path = scene::Translation{{0, 0.1, 0}}}};
  });
}

TEST(LiggghtsEngine, NamesTheFailuresOfItsProgram) {
  Bench bench;
  const std::tuple<const char*, Outcome, const char*> kSaid[] = {
      {"echo 'ERROR: Lost atoms: original 3 current 2 (thermo.cpp:438)'; exit 1",
       Outcome::particles_lost, "ERROR: Lost atoms: original 3 current 2 (thermo.cpp:438)"},
      {"echo 'ERROR on proc 0: mesh elements overlap'; echo MPI_ABORT was invoked; exit 1",
       Outcome::engine_failed, "ERROR on proc 0: mesh elements overlap"},
      {"echo '@row 0 nan 0 0 0 0'; echo '@end 0 1 duration'; exit 0", Outcome::non_finite,
       "the kinetic energy or a mass is not finite at 0 s"},
      {"exit 0", Outcome::engine_failed, "LIGGGHTS ended before the last stage did"}};
  for (const auto& [body, outcome, message] : kSaid) {
    const auto exit = bench.run(LiggghtsEngine({.liggghts = bench.program(body)}), ball());
    EXPECT_EQ(exit.status, EngineStatus::failed) << body;
    EXPECT_EQ(exit.failure, outcome) << body;
    EXPECT_EQ(exit.message, message);
  }
}

TEST(LiggghtsEngine, IsNamedByItsContent) {
  const Bench bench;
  const auto one = LiggghtsEngine({.liggghts = bench.program("exit 0")}).name();
  EXPECT_EQ(LiggghtsEngine({.liggghts = bench.program("exit 0")}).name(), one);
  EXPECT_NE(LiggghtsEngine({.liggghts = bench.program("exit 1")}).name(), one);
}

TEST(LiggghtsEngine, SaysWhichPackageIsMissing) {
  const char* const before = std::getenv("PATH");
  const std::string path = before != nullptr ? before : "";
  ::setenv("PATH", "/nowhere", 1);
  try {
    static_cast<void>(LiggghtsEngine());
    ADD_FAILURE();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("install Debian's package liggghts"),
              std::string::npos);
  }
  ::setenv("PATH", path.c_str(), 1);
}

TEST(LiggghtsEngine, FollowsAFreeFallToRounding) {
  SKIP_WITHOUT_LIGGGHTS();
  Bench bench;
  expect_finished(bench.run(LiggghtsEngine(), ball()));
  const auto run = bench.output();
  const auto end = run.end_of("fall");
  ASSERT_EQ(end.size(), 1u);
  const double t = end.time_s;
  EXPECT_NEAR(t, 0.05, run.summary().time_step_s);
  // 17 digits in the dump, some 500 steps of rounding.
  EXPECT_NEAR(end.position[0].z(), 0.03 - 0.5 * 9.81 * t * t, 1e-13);
  EXPECT_NEAR(end.velocity[0].z(), -9.81 * t, 1e-12);
  EXPECT_EQ(end.position[0].x(), 0.001);
  const double mass = 2500.0 * 4.0 / 3.0 * M_PI * 1.25e-7;
  EXPECT_NEAR(end.mass_kg[0], mass, 1e-15);
  const auto& series = run.series();
  EXPECT_NEAR(series.numbers("mass_above_kg").back(), mass, 1e-12);  // 15 digits in its log
  EXPECT_NEAR(series.numbers("mass_above_glass_kg").front(), mass, 1e-12);
  EXPECT_NEAR(series.numbers("kinetic_energy_j").back(), 0.5 * mass * std::pow(9.81 * t, 2), 1e-12);
  EXPECT_EQ(run.summary().engine, "liggghts");
  EXPECT_EQ(run.summary().version, "3.8.0");
  EXPECT_EQ(run.summary().stages.front().reason, "duration");
  EXPECT_TRUE(fs::exists(bench.job() / "output/liggghts/in.liggghts"));
  EXPECT_FALSE(fs::exists(bench.job() / "output/placed"));
}

/// The ball comes to rest on the gate, falls through it and comes to rest again.
scene::Case dropped_twice() {
  auto c = ball();
  c.stages = {{.name = "settle", .duration_s = 2.0, .at_rest = scene::AtRest{1e-5, 0.05}},
              {.name = "open",
               .opens = {"gate"},
               .duration_s = 2.0,
               .minimum_s = 0.1,
               .flow_ends = scene::FlowEnds{"above", 0.005, 0.05}},
              {.name = "rest", .duration_s = 2.0, .at_rest = scene::AtRest{1e-5, 0.05}}};
  c.output.snapshot_interval_s = 0.02;
  return c;
}

TEST(LiggghtsEngine, OpensGatesAndEndsStagesAsTheBundledEngineDoes) {
  SKIP_WITHOUT_LIGGGHTS();
  Bench bench;
  const auto scene = dropped_twice();
  expect_finished(bench.run(BundledEngine(), scene));
  const auto here = bench.output();
  expect_finished(bench.run(LiggghtsEngine(), scene));
  const auto there = bench.output();
  ASSERT_EQ(there.summary().stages.size(), 3u);
  EXPECT_EQ(there.summary().time_step_s, here.summary().time_step_s);
  for (std::size_t s = 0; s < 3; ++s) {
    const auto &a = here.summary().stages[s], &b = there.summary().stages[s];
    EXPECT_EQ(b.reason, a.reason) << a.name;
    EXPECT_NEAR(b.time_s, a.time_s, 2.0 * scene.output.series_interval_s) << a.name;
  }
  for (const char* stage : {"settle", "rest"})  // a fifth of a percent of R
    EXPECT_NEAR(there.end_of(stage).position[0].z(), here.end_of(stage).position[0].z(), 1e-5);
  // In between it falls, from rest but for sqrt(2e-5 g d) = 1.4 mm/s.
  const auto falling = there.end_of("open");
  const double t = falling.time_s - there.summary().stages[0].time_s;
  EXPECT_NEAR(falling.position[0].z(), there.end_of("settle").position[0].z() - 0.5 * 9.81 * t * t,
              1.4e-3 * t);
  EXPECT_NEAR(there.end_of("rest").position[0].z(), -0.1 + 0.005, 5e-5);
  EXPECT_NEAR(double(there.snapshots().size()), double(here.snapshots().size()), 2.0);
  EXPECT_EQ(there.series().numbers("mass_above_kg").back(), 0.0);
}

TEST(LiggghtsEngine, LiftsABallOnAMovingPlate) {
  SKIP_WITHOUT_LIGGGHTS();
  Bench bench;
  auto c = ball();
  c.particles[0].position.z() = 0.005;  // on the gate
  c.motions = {{.walls = {"gate"},
                .path = scene::Translation{{0, 0, 0.2}},
                .stage = "lift",
                .start_s = 0.1,
                .end_s = 0.4}};
  c.stages = {{.name = "settle", .duration_s = 0.1}, {.name = "lift", .duration_s = 0.6}};
  expect_finished(bench.run(LiggghtsEngine(), c));
  const auto run = bench.output();
  EXPECT_NEAR(run.end_of("settle").position[0].z(), 0.005, 5e-5);
  EXPECT_NEAR(run.end_of("lift").position[0].z(), 0.005 + 0.2 * 0.3, 5e-5);
}

TEST(LiggghtsEngine, LosesABallThatFallsBesideTheFloor) {
  SKIP_WITHOUT_LIGGGHTS();
  Bench bench;
  auto c = ball();
  c.walls.erase(c.walls.begin());
  c.particles[0].position.x() = 0.08;
  c.stages[0].duration_s = 0.5;
  const auto exit = bench.run(LiggghtsEngine(), c);
  EXPECT_EQ(exit.status, EngineStatus::failed);
  EXPECT_EQ(exit.failure, Outcome::particles_lost) << exit.message;
}

TEST(LiggghtsEngine, KeepsParticlesWithinAPeriodicDomain) {
  SKIP_WITHOUT_LIGGGHTS();
  Bench bench;
  auto c = ball();
  c.periodic.y = true;
  c.walls.erase(c.walls.begin() + 1);
  c.particles[0].velocity = {0, 3.0, 0};  // some 0.4 m along a period of 0.2 m
  c.stages[0].duration_s = 0.14;
  expect_finished(bench.run(LiggghtsEngine(), c));
  const auto end = bench.output().end_of("fall");
  EXPECT_NEAR(end.position[0].y(), 0.002 + 3.0 * end.time_s - 0.4, 1e-12);
}

TEST(LiggghtsEngine, GivesTheSameBitsOnTwoRanksForOneBall) {
  SKIP_WITHOUT_LIGGGHTS();
  if (std::system("command -v mpirun >/dev/null 2>&1") != 0) GTEST_SKIP() << "no mpirun";
  Bench bench;
  expect_finished(bench.run(LiggghtsEngine(), ball()));
  const auto one = bench.output().end_of("fall");
  expect_finished(bench.run(LiggghtsEngine(), ball(), 2));
  const auto two = bench.output().end_of("fall");
  EXPECT_EQ(one.position[0], two.position[0]);
}

TEST(EngineChoice, IsReadByNameAndRefusesOthers) {
  const auto read = [](const std::string& text) {
    return read_engine_choice(TomlTable::parse(text, "study.toml"), "/folder");
  };
  EXPECT_EQ(read("").name, "");
  const auto choice =
      read("[engine]\nname = \"liggghts\"\nprogram = \"bin/lig\"\nmpirun = \"m\"\n");
  EXPECT_EQ(choice.name, "liggghts");
  EXPECT_EQ(choice.program, "/folder/bin/lig");
  EXPECT_EQ(choice.mpirun, "m");
  EXPECT_THROW(read("[engine]\nname = \"edem\"\n"), InputError);
  EXPECT_THROW(read("[engine]\nprogram = \"x\"\n"), InputError);
  EXPECT_EQ(parse_engine_choice("./mine").program, "./mine");
  EXPECT_EQ(parse_engine_choice("./mine").name, "bundled");
  EXPECT_EQ(parse_engine_choice("liggghts").name, "liggghts");
  EXPECT_THROW(parse_engine_choice("edem"), InputError);
}

}  // namespace
}  // namespace repose::dem_adapter

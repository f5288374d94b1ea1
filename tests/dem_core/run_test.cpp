// Whole runs: beds that settle, stages, output, the program.
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem/run_case.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

namespace fs = std::filesystem;

/// A folder that goes away with the test.
struct Scratch {
  fs::path path =
      fs::temp_directory_path() / ("repose_dem_" + std::to_string(::getpid()) + "_" +
                                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
  Scratch() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Scratch() { fs::remove_all(path); }
};

/// 60 g of 8 to 10 mm spheres in a box with a trap door, above a plane.
scene::Case trap_door() {
  scene::Case c = empty_case(
      {.density = 2500.0, .youngs_modulus = 5e6, .restitution = 0.4, .mu_s = 0.5, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.lower_m = {-0.5, -0.5, -0.2};
  c.upper_m = {0.5, 0.5, 0.3};
  c.walls = scene::box_walls("bin", "wall", {-0.03, -0.03, 0}, {0.03, 0.03, 0.2}, {"+z"});
  scene::Wall ground = floor_plane();
  std::get<scene::Plane>(ground.shape).origin.z() = -0.1;
  c.walls.push_back(ground);
  c.regions = {{"bin", {-1, -1, 0}, {1, 1, 1}}};
  c.fill = scene::Fill{
      {-0.03, -0.03, 0}, {0.03, 0.03, 0.2}, 0.25, {layer_of("grain", 0.06, {{0.008, 0.010, 1.0}})}};
  c.time_step_rayleigh_fraction = 0.25;
  scene::Stage settle{.name = "settle", .duration_s = 2.0};
  settle.at_rest = scene::AtRest{1e-6, 0.05};
  scene::Stage open{.name = "open", .opens = {"bin.-z"}, .duration_s = 3.0};
  open.flow_ends = scene::FlowEnds{"bin", 0.001, 0.2};
  c.stages = {settle, open};
  return c;
}

std::uint64_t state_hash(Simulation& sim) {
  std::string bytes;
  for (const Sphere& s : sim.spheres())
    for (const Vec3& v : {s.position, s.velocity, s.angular_velocity}) {
      char raw[sizeof(double) * 3];
      std::memcpy(raw, v.data(), sizeof raw);
      bytes.append(raw, sizeof raw);
    }
  return content_hash(bytes);
}

TEST(Determinism, OneSeedGivesTheSameBits) {
  const auto run = [](std::uint64_t seed) {
    scene::Case c = trap_door();
    c.seed = seed;
    Simulation sim(c);
    sim.step(3000);
    return state_hash(sim);
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(SettledBed, ComesToRestWithoutCreepOrNoise) {
  Simulation sim(trap_door());
  while (sim.time_s() < 0.1) sim.step();
  const double falling = sim.kinetic_energy_j();
  while (sim.time_s() < 2.6) sim.step();  // what is left falls by a hundred in 0.4 s
  EXPECT_LT(sim.kinetic_energy_j(), 1e-5 * falling);
  EXPECT_GT(sim.contacts(), sim.size());
  for (const Sphere& s : sim.spheres()) {
    EXPECT_LT(s.velocity.norm(), 1e-14);
    // Nothing resists twisting about a vertical contact normal: a sphere that only the floor
    // touches may go on spinning about z.
    EXPECT_LT(Vec3(s.angular_velocity.x(), s.angular_velocity.y(), 0.0).norm() * s.radius_m, 1e-14);
  }
}

TEST(RunCase, EndsItsStagesByTheirCriteria) {
  const Scratch scratch;
  const scene::Case c = trap_door();
  double last = 0.0;
  const scene::RunSummary summary = run_case(
      c, scratch.path / "run", {.progress = [&](double done, double total, std::string_view) {
        EXPECT_GE(done, last);
        EXPECT_LE(done, total * (1 + 1e-3));
        last = done;
      }});
  ASSERT_EQ(summary.stages.size(), 2u);
  EXPECT_EQ(summary.stages[0].reason, "at rest");
  EXPECT_EQ(summary.stages[1].reason, "flow ended");
  const scene::Run run = scene::read_run(scratch.path / "run");
  EXPECT_EQ(run.summary().steps, summary.steps);
  EXPECT_TRUE(run.scene() == c);
  ASSERT_EQ(run.snapshots().size(), 2u);
  const auto mass = run.series().numbers("mass_bin_kg");
  EXPECT_NEAR(mass.front(), summary.bodies.alive_kg, 1e-12);
  EXPECT_EQ(mass.back(), 0.0);  // the whole floor opened
  const auto time = run.series().numbers("time_s");
  EXPECT_EQ(time.front(), 0.0);
  EXPECT_NEAR(time.back(), summary.stages[1].time_s, 1e-12);
  for (std::size_t i = 1; i < time.size(); ++i) EXPECT_GT(time[i], time[i - 1]);
  const scene::Snapshot end = run.end_of("open");
  for (const Vec3& x : end.position) EXPECT_LT(x.z(), 0.0);
  EXPECT_GT(run.summary().largest_overlap_ratio, 0.0);
  EXPECT_LT(run.summary().largest_overlap_ratio, 0.5);
}

TEST(PlaceParticles, LeavesWhatARunWouldBeginWith) {
  const Scratch scratch;
  const fs::path dir = scratch.path / "placed";
  const scene::Case c = trap_door();
  const scene::RunSummary placed = place_particles(c, dir);
  const scene::Run run = scene::read_run(dir);
  Simulation sim(c);
  ASSERT_EQ(run.snapshots().size(), 1u);
  const scene::Snapshot snapshot = run.snapshot(0);
  const auto spheres = sim.spheres();
  ASSERT_EQ(snapshot.size(), spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    EXPECT_EQ(snapshot.position[i], spheres[i].position);
    EXPECT_EQ(snapshot.radius_m[i], spheres[i].radius_m);
  }
  EXPECT_EQ(placed.time_step_s, sim.time_step_s());
  EXPECT_EQ(run.summary().steps, 0);
  EXPECT_EQ(run.summary().bodies, sim.ledger());
  EXPECT_EQ(run.series().rows(), 1u);
}

TEST(RunCase, WritesSnapshotsOnTime) {
  const Scratch scratch;
  scene::Case c = trap_door();
  c.stages = {{.name = "fall", .duration_s = 0.1}};
  c.output.snapshot_interval_s = 0.025;
  const scene::RunSummary summary = run_case(c, scratch.path / "run");
  const scene::Run run = scene::read_run(scratch.path / "run");
  ASSERT_GE(run.snapshots().size(), 4u);
  ASSERT_LE(run.snapshots().size(), 5u);  // the end of the stage may come just after the last
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(run.snapshots()[i].time_s, 0.025 * (static_cast<double>(i) + 1),
                4.0 * summary.time_step_s);
}

TEST(RunCase, AnEndlessDurationLeavesTheEndToTheCriterion) {
  const Scratch scratch;
  scene::Case c = trap_door();
  c.stages[0].duration_s = 1e99;  // more steps than any integer counts
  c.stages[1].duration_s = 0.01;
  c.stages[1].flow_ends.reset();
  double largest_before = 0.0, done_last = 0.0, total_last = 0.0;
  const scene::RunSummary summary = run_case(
      c, scratch.path / "run", {.progress = [&](double done, double total, std::string_view stage) {
        if (stage == "settle") largest_before = std::max(largest_before, done / total);
        done_last = done;
        total_last = total;
      }});
  ASSERT_EQ(summary.stages.size(), 2u);
  EXPECT_EQ(summary.stages[0].reason, "at rest");
  EXPECT_GT(summary.stages[0].time_s, 0.05);
  EXPECT_LT(largest_before, 1e-9);
  // What is done is the simulated time, and the end is known once the endless stage is over.
  EXPECT_NEAR(done_last, summary.stages[1].time_s, 1e-12);
  EXPECT_NEAR(done_last / total_last, 1.0, 1e-3);
}

TEST(RunCase, EndlessIntervalsWriteOnlyTheEndsOfStages) {
  const Scratch scratch;
  scene::Case c = trap_door();
  c.stages = {{.name = "fall", .duration_s = 0.01}, {.name = "on", .duration_s = 0.01}};
  c.output.series_interval_s = 1e99;
  c.output.snapshot_interval_s = 1e99;
  run_case(c, scratch.path / "run");
  const scene::Run run = scene::read_run(scratch.path / "run");
  EXPECT_EQ(run.series().numbers("time_s").size(), 3u);  // the start and two ends
  EXPECT_EQ(run.snapshots().size(), 2u);
}

TEST(RunCase, ThatFailsLeavesNoResult) {
  const Scratch scratch;
  scene::Case c = trap_door();
  c.walls.pop_back();  // no ground: spheres fall out of the domain
  EXPECT_THROW(run_case(c, scratch.path / "run"), SimulationError);
  EXPECT_FALSE(fs::exists(scratch.path / "run" / "run.h5"));
  EXPECT_NE(read_file(scratch.path / "run" / "log.txt").find("left the domain"), std::string::npos);
  EXPECT_THROW(scene::read_run(scratch.path / "run"), StorageError);
}

TEST(RunCase, ThatCannotBeginSaysWhyInItsLog) {
  const Scratch scratch;
  scene::Case c = trap_door();
  c.walls.push_back({"drum", "wall", scene::Mesh{.file = scratch.path / "nowhere.stl"}});
  EXPECT_THROW(run_case(c, scratch.path / "run"), StorageError);
  EXPECT_NE(read_file(scratch.path / "run" / "log.txt").find("failed: "), std::string::npos);
}

/// Exit code of the program with these arguments, output to log.
int program(const std::string& arguments, const fs::path& log) {
  const std::string command =
      std::string(REPOSE_BIN) + "/repose-dem " + arguments + " > " + log.string() + " 2>&1";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(Program, RunsIntoAFileAndTellsErrorsApart) {
  const Scratch scratch;
  const fs::path log = scratch.path / "log";
  scene::Case c = trap_door();
  c.stages = {{.name = "fall", .duration_s = 0.02}};
  scene::write_case(scratch.path / "case.toml", c);
  const std::string input = (scratch.path / "case.toml").string();
  EXPECT_EQ(program(input + " -o " + (scratch.path / "run.h5").string() + " --json --seed 9", log),
            0);
  EXPECT_EQ(scene::read_run(scratch.path / "run.h5").summary().seed, 9u);
  EXPECT_FALSE(fs::exists(scratch.path / "run.h5.parts"));
  EXPECT_EQ(program("--help", log), 0);
  EXPECT_EQ(program(input, log), 2);
  EXPECT_EQ(program(input + "x -o " + (scratch.path / "a").string(), log), 6);
  c.walls.clear();
  c.stages[0].duration_s = 5.0;
  scene::write_case(scratch.path / "falls.toml", c);
  EXPECT_EQ(
      program((scratch.path / "falls.toml").string() + " -o " + (scratch.path / "b").string(), log),
      5);
  std::ofstream(scratch.path / "bad.toml") << "gravity = 1\n";
  EXPECT_EQ(
      program((scratch.path / "bad.toml").string() + " -o " + (scratch.path / "c").string(), log),
      3);
  EXPECT_FALSE(fs::exists(scratch.path / "c"));
}

TEST(Program, StopsCleanlyWhenTold) {
  const Scratch scratch;
  scene::Case c = trap_door();
  c.stages = {{.name = "long", .duration_s = 1000.0}};
  scene::write_case(scratch.path / "case.toml", c);
  const std::string bin = std::string(REPOSE_BIN) + "/repose-dem";
  const std::string input = (scratch.path / "case.toml").string();
  const std::string output = (scratch.path / "run").string();
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl(bin.c_str(), "repose-dem", input.c_str(), "-o", output.c_str(), "--quiet", nullptr);
    ::_exit(127);
  }
  while (!fs::exists(scratch.path / "run" / "log.txt")) std::this_thread::yield();
  ::kill(child, SIGTERM);
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 128 + SIGTERM);  // as a shell reports it
  EXPECT_FALSE(fs::exists(scratch.path / "run" / "run.h5"));
  EXPECT_NE(read_file(scratch.path / "run" / "log.txt").find("interrupted"), std::string::npos);
}

}  // namespace
}  // namespace repose::dem

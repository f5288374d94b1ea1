// A settled bed of 29,520 spheres followed by LIGGGHTS and by this engine from the same state.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "../dem_adapter/temporary_directory.hpp"
#include "repose/dem/pair_law.hpp"
#include "repose/dem/simulation.hpp"
#include "repose/dem_adapter/liggghts.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::cross_engine {
namespace {

namespace fs = std::filesystem;

constexpr double kStep_s = 1e-5;

/// The table of the particles, with a header.
void write_particles(const fs::path& table) {
  std::ofstream out(table);
  out << "x_m,y_m,z_m,radius_m\n";
  std::FILE* in = ::popen("zcat '" REPOSE_TEST_DATA "/dem/bed_29520.csv.gz'", "r");
  char line[256];
  while (in != nullptr && std::fgets(line, sizeof line, in) != nullptr)
    if (line[0] == '-' || (line[0] >= '0' && line[0] <= '9')) out << line;
  if (in != nullptr) ::pclose(in);
}

/// Box of 0.25 x 0.25 m with planes; radii 4, 5 and 6.5 mm, at rest; 1,000 steps.
scene::Case settled_bed(const fs::path& table) {
  scene::Case c;
  c.lower_m = {-0.01, -0.01, -0.01};
  c.upper_m = {0.26, 0.26, 0.9};
  c.materials = {{"glass", 3500.0, 2.5e8, 0.25}};
  c.pairs = {{"glass", "glass", 0.5, 0.5, 0.15, 0.3}};
  const auto plane = [&](const char* name, const scene::Vec3& origin, const scene::Vec3& normal) {
    c.walls.push_back({name, "glass", scene::Plane{origin, normal}});
  };
  plane("x0", {0, 0, 0}, {1, 0, 0});
  plane("x1", {0.25, 0, 0}, {-1, 0, 0});
  plane("y0", {0, 0, 0}, {0, 1, 0});
  plane("y1", {0, 0.25, 0}, {0, -1, 0});
  plane("z0", {0, 0, 0}, {0, 0, 1});
  c.particle_tables = {{.location = table.string(), .material = "glass"}};
  c.time_step_rayleigh_fraction = kStep_s / dem::rayleigh_time_s(c.materials[0], 0.004);
  c.stages = {{.name = "follow", .duration_s = 1000 * kStep_s}};
  c.output.snapshot_interval_s = 100 * kStep_s;
  c.contact.compatibility = scene::Compatibility::liggghts;
  return c;
}

TEST(Liggghts, FollowsASettledBedWithTheSameKineticEnergyUnderCompat) {
  if (std::system("command -v liggghts >/dev/null 2>&1") != 0)
    GTEST_SKIP() << "liggghts is not installed (Debian package liggghts)";
  const test::TemporaryDirectory folder;
  write_particles(folder / "bed.csv");
  const auto c = settled_bed(folder / "bed.csv");
  scene::write_case(folder / "case.toml", c);
  const auto exit = dem_adapter::LiggghtsEngine().run({.directory = folder.path()});
  ASSERT_EQ(exit.status, dem_adapter::EngineStatus::finished) << exit.message;
  const auto run = scene::read_run(folder / "output");
  ASSERT_EQ(run.snapshots().size(), 10u);
  ASSERT_EQ(run.snapshot(0).size(), 29520u);
  dem::Simulation sim(c, {.time_step_s = kStep_s});
  double worst = 0.0;
  for (std::size_t f = 0; f < run.snapshots().size(); ++f) {
    sim.step(100);
    const auto there = run.snapshot(f);
    const auto spheres = sim.spheres();
    double ours = 0.0, theirs = 0.0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      ours += 0.5 * spheres[i].mass_kg * spheres[i].velocity.squaredNorm();
      theirs += 0.5 * spheres[i].mass_kg * there.velocity[i].squaredNorm();
    }
    worst = std::max(worst, std::abs(ours / theirs - 1.0));
    std::printf("step %5.0f: %.8e J here, %.8e J in LIGGGHTS\n", there.time_s / kStep_s, ours,
                theirs);
  }
  EXPECT_LT(worst, 1e-3);
}

}  // namespace
}  // namespace repose::cross_engine

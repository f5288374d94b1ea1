// A settled bed of 29,520 spheres followed by LIGGGHTS and by this engine from the same state.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <sstream>

#include "liggghts.hpp"
#include "repose/dem/simulation.hpp"

namespace repose::cross_engine {
namespace {

namespace fs = std::filesystem;

/// Box of 0.25 x 0.25 m with planes; radii 4, 5 and 6.5 mm, at rest.
scene::Case settled_bed() {
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
  std::FILE* in = ::popen("zcat '" REPOSE_TEST_DATA "/dem/bed_29520.csv.gz'", "r");
  char line[256];
  while (in != nullptr && std::fgets(line, sizeof line, in) != nullptr) {
    scene::Particle p;
    p.material = "glass";
    char comma = 0;
    std::istringstream cells(line);
    if (cells >> p.position.x() >> comma >> p.position.y() >> comma >> p.position.z() >> comma >>
        p.radius_m)
      c.particles.push_back(p);
  }
  if (in != nullptr) ::pclose(in);
  return c;
}

TEST(Liggghts, FollowsASettledBedWithTheSameKineticEnergyUnderCompat) {
  if (!have_liggghts()) GTEST_SKIP() << "liggghts is not installed (Debian package liggghts)";
  scene::Case c = settled_bed();
  ASSERT_EQ(c.particles.size(), 29520u);
  c.contact.compatibility = scene::Compatibility::liggghts;
  const fs::path folder = fs::temp_directory_path() / ("repose_bed_" + std::to_string(::getpid()));
  const auto frames = run_liggghts(c, {}, {1e-5, 1000, 100, 0.002}, folder);
  fs::remove_all(folder);
  ASSERT_EQ(frames.size(), 11u);
  dem::Simulation sim(c, {.time_step_s = 1e-5});
  double worst = 0.0;
  for (std::size_t f = 1; f < frames.size(); ++f) {
    sim.step(100);
    const auto spheres = sim.spheres();
    double ours = 0.0, theirs = 0.0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      ours += 0.5 * spheres[i].mass_kg * spheres[i].velocity.squaredNorm();
      theirs += 0.5 * spheres[i].mass_kg * frames[f].particles[i].velocity.squaredNorm();
    }
    worst = std::max(worst, std::abs(ours / theirs - 1.0));
    std::printf("step %5.0f: %.8e J here, %.8e J in LIGGGHTS\n", 100.0 * static_cast<double>(f),
                ours, theirs);
  }
  EXPECT_LT(worst, 1e-3);
}

}  // namespace
}  // namespace repose::cross_engine

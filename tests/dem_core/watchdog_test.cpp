// What ends or warns of a run that is unphysical, and what must not.
#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "contact/impact.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem/run_case.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

/// The message of the error with which the simulation ends within n steps, "" if it does not.
std::string end_of(Simulation& sim, std::int64_t n) {
  try {
    sim.step(n);
  } catch (const SimulationError& error) {
    return error.what();
  }
  return "";
}

testing::AssertionResult has(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << '"' << text << "\" lacks \"" << part << '"';
}

TEST(Impact, OverlapAndSpeedAreThoseOfTheClosedFormAndOfEachOther) {
  const ContactBodies bodies{.r_eff = 0.005, .m_eff = 0.001};
  const HertzImpact impact = hertz_impact(1e8, 0.005, 0.001, 2.0);
  EXPECT_NEAR(impact_overlap(1e8, bodies, 2.0), impact.largest_overlap,
              1e-14 * impact.largest_overlap);
  EXPECT_NEAR(impact_speed(1e8, bodies, impact.largest_overlap), 2.0, 1e-14);
}

/// A sphere that meets a wall of its own stiffness at the speed at which an elastic impact overlaps
/// by this part of its radius.
scene::Case impact_of(double overlap_ratio, double restitution) {
  const OneMaterial material{.youngs_modulus = 1e6, .restitution = restitution};
  scene::Case c = empty_case(material);
  c.walls = {floor_plane()};
  const double r = 0.01;
  const double e_eff = material.youngs_modulus / (2.0 * (1.0 - 0.0625));
  const double speed = impact_speed(e_eff, sphere_wall(r, sphere_mass(r, 2500)), overlap_ratio * r);
  c.particles = {grain(r, {0, 0, 1.01 * r}, {0, 0, -speed})};
  return c;
}

TEST(Watchdog, NamesSphereWallAndLimitOfADeepOverlap) {
  Simulation sim(impact_of(0.6, 1.0), {.time_step_s = 4e-5});
  const std::string text = end_of(sim, 100000);
  for (const char* part : {"sphere 0 at (0, 0, 0.00", "overlaps wall \"floor\" by 5",
                           "at most 50 % is allowed", "speed ", "raise youngs_modulus_pa"})
    EXPECT_TRUE(has(text, part));
}

TEST(Watchdog, TakesADeepOverlapThatItsSpeedExplains) {
  Simulation sim(impact_of(0.45, 1.0), {.time_step_s = 4e-5});
  EXPECT_EQ(end_of(sim, 5000), "");
  EXPECT_GT(sim.take_largest_overlap().ratio(), 0.44);
  EXPECT_GT(sim.spheres()[0].velocity.z(), 0.0);
}

TEST(Watchdog, EndsAtThirtyPerCentWhatNoSpeedExplains) {
  scene::Case c = impact_of(0.01, 0.3);  // a press comes down on a sphere at rest
  c.particles[0] = grain(0.01, {0, 0, 0.01});
  scene::Wall press = floor_plane();
  press.name = "press";
  std::get<scene::Plane>(press.shape) = {.origin = {0, 0, 0.0201}, .normal = {0, 0, -1}};
  c.walls.push_back(press);
  c.motions = {{.walls = {"press"}, .path = scene::Translation{{0, 0, -0.1}}}};
  Simulation sim(c);
  const std::string text = end_of(sim, 100000);
  EXPECT_TRUE(has(text, "by 30 % of the smaller radius; at most 30 % is allowed"));
}

TEST(Watchdog, NamesASphereWhoseSpeedJumps) {
  scene::Case c = empty_case({.youngs_modulus = 1e9, .restitution = 0.9});
  c.gravity_m_s2.z() = -9.81;  // a fall through the domain of 20 m: 26 m/s
  c.particles = {grain(0.01, {0, 0, 0}), grain(0.002, {0.0115, 0, 0})};  // 25 % of the small one
  c.materials[0].density_kg_m3 = 2.0;
  Simulation sim(c);
  const std::string text = end_of(sim, 100000);
  for (const char* part : {"sphere 1 at (", "has jumped to speed ", "was faster than 26.", " m/s",
                           "began in each other"})
    EXPECT_TRUE(has(text, part));
}

TEST(Watchdog, TakesSpeedsThatHaveAReason) {
  scene::Case c = empty_case({.youngs_modulus = 1e9, .restitution = 1.0});
  c.particles = {grain(0.01, {0, 0, 0.02})};
  scene::Wall bat = rectangle("bat", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  c.walls = {bat};
  c.motions = {{.walls = {"bat"}, .path = scene::Translation{{0, 0, 20}}}};
  Simulation sim(c);
  while (sim.time_s() < 0.01) ASSERT_EQ(end_of(sim, 100), "");
  EXPECT_NEAR(sim.spheres()[0].velocity.z(), 40.0, 0.1);  // at rest until the bat came
  scene::Case fast = empty_case({.youngs_modulus = 1e9});
  fast.particles = {grain(0.01, {0, 0, 0}, {70, 0, 0})};
  Simulation flight(fast);
  EXPECT_EQ(end_of(flight, 1000), "");
  scene::Case slow = empty_case({.youngs_modulus = 1e9, .restitution = 0.9});
  slow.pairs[0].cohesion_energy_density_j_m3 = 1e5;  // what rests begins to move
  slow.particles = {grain(0.01, {0, 0, 0}), grain(0.01, {0.01999, 0, 0})};
  Simulation cohesive(slow);
  EXPECT_EQ(end_of(cohesive, 5000), "");
  EXPECT_GT(cohesive.kinetic_energy_j(), 0.0);
}

/// The deepest overlap of a run of 0.05 s, and the warnings it gave.
struct Outcome {
  double largest_overlap_ratio;
  std::vector<std::string> warnings;
  std::string log;
};
Outcome outcome_of(scene::Case c) {
  c.stages = {{.name = "hit", .duration_s = 0.05}};
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("repose_watchdog_" + std::to_string(::getpid()));
  Outcome outcome;
  outcome.largest_overlap_ratio =
      run_case(c, folder,
               {.warn = [&](std::string_view text) { outcome.warnings.emplace_back(text); }})
          .largest_overlap_ratio;
  outcome.log = read_file(folder / "log.txt");
  std::filesystem::remove_all(folder);
  return outcome;
}

TEST(Watchdog, WarnsOfTheFirstAndTheDeepestSoftContactWithTheStiffnessThatCuresIt) {
  scene::Case c = impact_of(0.2, 0.9);
  c.particles.push_back(grain(0.01, {1, 1, 0.05}, 1.5 * c.particles[0].velocity));  // later, deeper
  const Outcome soft = outcome_of(c);
  ASSERT_EQ(soft.warnings.size(), 2u);
  for (const std::string& warning : soft.warnings) {
    for (const char* part : {"overlapped wall \"floor\" by ", " times the youngs_modulus_pa, ",
                             " for \"grain\" and ", " for \"wall\", would keep that below 5 %"})
      EXPECT_TRUE(has(warning, part));
    EXPECT_TRUE(has(soft.log, "warning: " + warning));
  }
  EXPECT_TRUE(has(soft.warnings[0], "sphere 0"));
  EXPECT_TRUE(has(soft.warnings[1], "sphere 1"));
  // Damping acts alike on stiff and soft contacts: the overlap goes with E^-0.4.
  const double factor = std::pow(soft.largest_overlap_ratio / 0.05, 2.5);
  char text[64];
  std::snprintf(text, sizeof text, "; %.2g times the", factor);
  EXPECT_TRUE(has(soft.warnings[1], text));
  for (scene::Material& material : c.materials) material.youngs_modulus_pa *= 1.01 * factor;
  const Outcome stiff = outcome_of(c);
  EXPECT_LE(stiff.largest_overlap_ratio, 0.05);
  EXPECT_GT(stiff.largest_overlap_ratio, 0.049);
  EXPECT_TRUE(stiff.warnings.empty());
}

}  // namespace
}  // namespace repose::dem

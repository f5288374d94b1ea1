#include <gtest/gtest.h>

#include "mesh_walls.hpp"
#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

using std::numbers::pi;

scene::Motion moving(const std::string& wall, decltype(scene::Motion::path) path) {
  return {.walls = {wall}, .path = std::move(path)};
}

void run_until(Simulation& sim, double time_s) {
  while (sim.time_s() < time_s) sim.step();
}

TEST(MovingPlate, GivesAnElasticSphereTwiceItsSpeedAndTheEnergyItGains) {
  // The plate comes from afar, so that its motion alone must bring it into the lists.
  scene::Case c = empty_case({.restitution = 1.0});
  c.walls = {rectangle("plate", {-1, -1, -0.3}, {2, 0, 0}, {0, 2, 0})};
  c.motions = {moving("plate", scene::Translation{{0, 0, 1}})};
  c.particles = {grain(0.01, {0.3, 0.2, 0.0})};
  const auto error_at = [&](double fraction) {
    c.time_step_rayleigh_fraction = fraction;
    Simulation sim(c);
    run_until(sim, 0.31);
    const Sphere sphere = sim.spheres()[0];
    const WallLoad load = sim.take_wall_loads()[0];
    EXPECT_NEAR(sphere.velocity.z(), 2.0, 2e-3);
    EXPECT_EQ(sim.contacts(), 0u);
    // Momentum: each step's force acts for dt, so that impulse and momentum agree to rounding.
    const double impulse = load.force_n.z() * static_cast<double>(sim.steps()) * sim.time_step_s();
    EXPECT_NEAR(impulse, -sphere.mass_kg * sphere.velocity.z(), 1e-10 * sphere.mass_kg);
    return std::abs(load.work_j - sim.kinetic_energy_j()) / sim.kinetic_energy_j();
  };
  // The contact takes some 30 steps; leapfrog is of second order.
  EXPECT_LT(error_at(0.15), 5e-3);
  EXPECT_LT(error_at(0.015), 5e-5);
}

TEST(MovingPlate, CarriesASphereThroughItsOscillation) {
  const OneMaterial material{.youngs_modulus = 1e7, .restitution = 0.3};
  scene::Case c = empty_case(material);
  c.gravity_m_s2.z() = -9.81;
  c.walls = {rectangle("plate", {-0.1, -0.1, 0}, {0.2, 0, 0}, {0, 0.2, 0})};
  c.motions = {moving(
      "plate",
      scene::Oscillation{.amplitude_m = {0, 0, 5e-4}, .frequency_hz = 10, .phase_rad = pi / 2})};
  const double r = 0.01;
  const double weight = sphere_mass(r, material.density) * 9.81;
  const double d = hertz_overlap(material.youngs_modulus / (2 * (1 - 0.0625)), r, weight);
  c.particles = {grain(r, {0, 0, r - d})};
  Simulation sim(c);
  run_until(sim, 0.3);  // transients are gone after a few periods of the contact, some ms
  sim.take_wall_loads();
  const double a_omega2 = 5e-4 * 400 * pi * pi;  // 1.97 m/s2: the force changes by 20 %
  double largest = 0.0;
  const double begin = sim.time_s();
  double force_sum = 0.0, work = 0.0;
  int samples = 0;
  while (sim.time_s() < begin + 0.3 - 0.5 * sim.time_step_s()) {
    sim.step();
    const WallLoad load = sim.take_wall_loads()[0];
    const double expected = weight * (1 - a_omega2 / 9.81 * std::cos(20 * pi * sim.time_s()));
    largest = std::max(largest, std::abs(-load.force_n.z() - expected));
    force_sum -= load.force_n.z();
    work += load.work_j;
    ++samples;
  }
  EXPECT_NEAR(force_sum / samples, weight, 1e-3 * weight);
  // Quasi-static: the contact's own frequency is some 30 times higher, which leaves 1/900 of 20 %,
  // and damping as much again; the rectangular sum over whole periods leaves little.
  EXPECT_LT(largest, 0.01 * weight);
  EXPECT_LT(std::abs(work), 0.01 * weight * 5e-4);
}

TEST(ConveyorBelt, TakesASphereToTwoSeventhsOfItsSpeed) {
  // The impulse of friction J changes v by J/m and w R by 2.5 J/m, until v + w R is the belt's
  // speed; as long as it slips the belt feels mu m g, once the tangential spring is wound up.
  scene::Case c = empty_case({.mu_s = 0.3});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor_plane()};
  c.motions = {moving("floor", scene::Translation{{1.0, 0, 0}})};
  const double weight = sphere_mass(0.01, 2500) * 9.81;
  c.particles = {grain(0.01, {0, 0, 0.01 - hertz_overlap(1e8 / (2 * (1 - 0.0625)), 0.01, weight)})};
  Simulation sim(c);
  run_until(sim, 0.01);
  sim.take_wall_loads();
  run_until(sim, 0.05);  // it slips for 2/7 / (0.3 g) = 0.097 s
  EXPECT_NEAR(sim.take_wall_loads()[0].force_n.x(), -0.3 * weight, 2e-3 * weight);
  run_until(sim, 0.3);
  // The lever arm is R - d/2, smaller than R by 1e-3.
  EXPECT_NEAR(sim.spheres()[0].velocity.x(), 2.0 / 7.0, 1e-3);
  sim.take_wall_loads();
  run_until(sim, 0.4);
  const WallLoad rolling = sim.take_wall_loads()[0];
  EXPECT_NEAR(rolling.force_n.x(), 0.0, 1e-4 * weight);
}

/// Where a sphere comes that rolls on a turntable which makes 5 rad/s, after half and after a whole
/// round of its own.
struct Orbit {
  Vec3 start, half, whole;
};
Orbit orbit_on(const scene::Wall& table) {
  scene::Case c = empty_case({.restitution = 0.3, .mu_s = 0.8});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {table};
  const double rate = 5.0;
  c.motions = {moving(table.name, scene::Rotation{.axis = {0, 0, 1}, .rate_rad_s = rate})};
  const double r = 0.01;
  const double d = hertz_overlap(1e8 / (2 * (1 - 0.0625)), r, sphere_mass(r, 2500) * 9.81);
  const Vec3 x(0.05, 0.0, r - d);
  const Vec3 v(0.1, 0.0, 0.0);
  // No slip: v + w x (-(r - d/2) z) = rate z x x.
  const Vec3 slip = Vec3(-rate * x.y(), rate * x.x(), 0) - v;
  const Vec3 w = Vec3(slip.y(), -slip.x(), 0) / (r - d / 2);
  c.particles = {grain(r, x, v, w)};
  Simulation sim(c);
  const double period = 7 * pi / rate;
  Orbit orbit{x, {}, {}};
  run_until(sim, period / 2);
  orbit.half = sim.spheres()[0].position;
  run_until(sim, period);
  orbit.whole = sim.spheres()[0].position;
  return orbit;
}

TEST(Turntable, ASphereRollsInACircleTwoSeventhsAsFast) {
  // [Weltner1979]: dv/dt = (2/7) Omega x v, so that the circle has the radius 7 v / (2 Omega).
  const Orbit disc = orbit_on({"table", "wall", scene::Disc{{0, 0, 0}, {0, 0, 1}, 0.3}});
  const double diameter = 2 * 7 * 0.1 / (2 * 5.0);
  EXPECT_LT((disc.half - disc.start - Vec3(0, diameter, 0)).norm(), 5e-3 * diameter);
  EXPECT_LT((disc.whole - disc.start).norm(), 5e-3 * diameter);
  // Cut into triangles that turn below it, it does the same.
  const Orbit mesh =
      orbit_on(mesh_wall("table", floor_triangles(-0.25, 0.25, -0.25, 0.25, 30, 30, 0.4)));
  EXPECT_LT((mesh.half - disc.half).norm(), 1e-9);
  EXPECT_LT((mesh.whole - disc.whole).norm(), 1e-9);
}

TEST(WallLoads, OfABoxAtRestAreTheWeightOfTheBed) {
  scene::Case c = empty_case({.youngs_modulus = 1e7, .restitution = 0.3, .mu_s = 0.4, .mu_r = 0.1});
  c.gravity_m_s2.z() = -9.81;
  c.walls = scene::box_walls("bin", "wall", {-0.03, -0.03, 0}, {0.03, 0.03, 0.2}, {"+z"});
  c.fill = scene::Fill{
      {-0.03, -0.03, 0}, {0.03, 0.03, 0.2}, 0.25, {layer_of("grain", 0.15, {{0.008, 0.012, 1.0}})}};
  Simulation sim(c);
  run_until(sim, 1.0);
  sim.take_wall_loads();
  run_until(sim, 1.1);
  Vec3 force = Vec3::Zero();
  for (const WallLoad& load : sim.take_wall_loads()) {
    force += load.force_n;
    EXPECT_EQ(load.work_j, 0.0);
  }
  const double weight = sim.mass_kg() * 9.81;
  EXPECT_NEAR(force.z(), -weight, 1e-3 * weight);
  EXPECT_NEAR(force.x(), 0.0, 1e-3 * weight);
  EXPECT_NEAR(force.y(), 0.0, 1e-3 * weight);
}

TEST(Stage, BeginsItsMotionsAndOpensItsWalls) {
  scene::Case c = empty_case({});
  c.walls = {rectangle("shelf", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}),
             rectangle("piston", {-1, -1, -0.1}, {2, 0, 0}, {0, 2, 0})};
  scene::Motion lift = moving("piston", scene::Translation{{0, 0, 1}});
  lift.stage = "lift";
  c.motions = {lift};
  c.stages = {{.name = "wait", .duration_s = 1},
              {.name = "lift", .opens = {"shelf"}, .duration_s = 1}};
  c.particles = {grain(0.01, {0, 0, 0.0099})};
  Simulation sim(c);
  sim.begin_stage("wait");
  EXPECT_EQ(sim.contacts(), 1u);
  run_until(sim, 0.02);
  const double z = sim.wall_poses()[1].translation.z();
  EXPECT_EQ(z, 0.0);
  sim.begin_stage("lift");
  const double begun = sim.time_s();
  EXPECT_EQ(sim.contacts(), 0u);
  sim.step(100);
  EXPECT_NEAR(sim.wall_poses()[1].translation.z(), sim.time_s() - begun, 1e-15);
  EXPECT_TRUE(sim.wall_poses()[0].is_open);
  EXPECT_THROW(sim.begin_stage("lunch"), InputError);
}

/// The message with which 0.1 s on a moved floor end, "" if they do not; spheres at x = 0.3 m.
std::string failure_on(const scene::Wall& floor, decltype(scene::Motion::path) path) {
  scene::Case c = empty_case({});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {floor};
  c.motions = {moving(floor.name, std::move(path))};
  c.particles = {grain(0.01, {0.3, 0.2, 0.0101})};
  Simulation sim(c);
  try {
    run_until(sim, 0.1);
    return "";
  } catch (const SimulationError& error) {
    return error.what();
  }
}

TEST(MovingPlate, ThatATableThrowsPastASphereIsAnError) {
  // From one point to the next within a billionth of a step, when no step looks at its speed.
  const scene::TimeTable jump{{0.0, 0.05, 0.05 + 1e-14}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0.02}}};
  const auto plate = rectangle("plate", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const std::string text = failure_on(plate, jump);
  EXPECT_NE(text.find("wall \"plate\" moved by 0.02 m in the time step before 0.05"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("a quarter of the smallest radius, 0.0025 m"), std::string::npos) << text;
}

TEST(SurfaceThatSlidesInItself, MayMoveAsFastAsItLikes) {
  // More than a radius a step: 1e4 m/s for 1e-5 s and more.
  EXPECT_EQ(failure_on(floor_plane(), scene::Translation{{1e4, 0, 0}}), "");
  EXPECT_EQ(failure_on(floor_plane(), scene::Rotation{.centre = {10, 0, 0}, .rate_rad_s = 1e3}),
            "");
  EXPECT_EQ(failure_on({"disc", "wall", scene::Disc{{0.3, 0.2, 0}, {0, 0, 1}, 1.0}},
                       scene::Rotation{.centre = {0.3, 0.2, 0}, .rate_rad_s = 1e4}),
            "");
  // About an axis beside its own it does move.
  EXPECT_NE(failure_on({"disc", "wall", scene::Disc{{0.3, 0.2, 0}, {0, 0, 1}, 1.0}},
                       scene::Rotation{.centre = {0.0, 0.2, 0}, .rate_rad_s = 1e4}),
            "");
}

TEST(MovingPlate, TooFastForTheTimeStepIsAnError) {
  scene::Case c = empty_case({});
  c.walls = {rectangle("plate", {-1, -1, -0.3}, {2, 0, 0}, {0, 2, 0})};
  c.motions = {moving("plate", scene::Translation{{0, 0, 1000}})};
  c.particles = {grain(0.01, {0.3, 0.2, 0.0})};
  Simulation sim(c);
  EXPECT_THROW(sim.step(10), SimulationError);
}

}  // namespace
}  // namespace repose::dem

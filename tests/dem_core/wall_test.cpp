#include <gtest/gtest.h>

#include "repose/base/error.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

/// A sphere that falls obliquely onto walls at z = 0, bounces and rolls along x across x = 0.
std::vector<Sphere> rolled_over(const std::vector<scene::Wall>& walls) {
  scene::Case c = empty_case({.restitution = 0.4, .mu_s = 0.5, .mu_r = 0.02});
  c.gravity_m_s2.z() = -9.81;
  c.walls = walls;
  c.particles = {grain(0.01, {-0.02, 0, 0.012}, {0.5, 0.02, 0})};
  Simulation sim(c);
  while (sim.time_s() < 0.4) sim.step();
  EXPECT_GT(sim.spheres()[0].position.x(), 0.05);
  return sim.spheres();
}

TEST(Rectangle, CoplanarNeighborsActAsOne) {
  const auto one = rolled_over({rectangle("a", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0})});
  const auto two = rolled_over({rectangle("a", {-1, -1, 0}, {1, 0, 0}, {0, 2, 0}),
                                rectangle("b", {0, -1, 0}, {1, 0, 0}, {0, 2, 0})});
  const auto many = rolled_over({rectangle("a", {-1, -1, 0}, {1, 0, 0}, {0, 1, 0}),
                                 rectangle("b", {0, -1, 0}, {0.011, 0, 0}, {0, 2, 0}),
                                 rectangle("c", {0.011, -1, 0}, {1, 0, 0}, {0, 2, 0}),
                                 rectangle("d", {-1, 0, 0}, {1, 0, 0}, {0, 1, 0})});
  // The same arithmetic up to the rounding of heights over other origins.
  EXPECT_LT((one[0].position - two[0].position).norm(), 1e-12);
  EXPECT_LT((one[0].velocity - two[0].velocity).norm(), 1e-10);
  EXPECT_LT((one[0].position - many[0].position).norm(), 1e-12);
}

/// A section of a pipe about the line y = 0, z = 0.05 from x0 to x1.
scene::Wall section(const std::string& name, double x0, double x1, double r0, double r1) {
  return {name, "wall", scene::Cone{{x0, 0, 0.05}, {x1, 0, 0.05}, r0, r1}};
}

TEST(Pipe, SectionsThatGoOnSmoothlyActAsOne) {
  struct Course {
    double r0, middle, r1;  // at x = -1, 0 and 1
  };
  for (const Course& pipe : {Course{0.05, 0.05, 0.05}, Course{0.06, 0.05, 0.04}}) {
    const auto one = rolled_over({section("a", -1, 1, pipe.r0, pipe.r1)});
    const auto two = rolled_over(
        {section("a", -1, 0, pipe.r0, pipe.middle), section("b", 0, 1, pipe.middle, pipe.r1)});
    // The middle one, drawn the other way, joins two that were apart.
    const double at = pipe.middle + 0.25 * (pipe.r1 - pipe.middle);
    const auto three =
        rolled_over({section("a", -1, 0, pipe.r0, pipe.middle), section("c", 0.25, 1, at, pipe.r1),
                     section("b", 0.25, 0, at, pipe.middle)});
    // The same arithmetic up to the rounding of heights over other origins.
    EXPECT_LT((one[0].position - two[0].position).norm(), 1e-12);
    EXPECT_LT((one[0].velocity - two[0].velocity).norm(), 1e-10);
    EXPECT_LT((one[0].position - three[0].position).norm(), 1e-12);
  }
}

TEST(Rectangle, InACornerEachFacePushesOnce) {
  // Statics: in a 90 degree groove tilted by 45 degrees each face carries m g / sqrt(2).
  scene::Case c = empty_case({.density = 2500.0, .youngs_modulus = 1e8});
  c.gravity_m_s2 = {-9.81 / std::sqrt(2.0), 0, -9.81 / std::sqrt(2.0)};
  c.walls = {rectangle("floor", {0, -1, 0}, {1, 0, 0}, {0, 2, 0}),
             rectangle("side", {0, -1, 0}, {0, 2, 0}, {0, 0, 1})};
  const double r = 0.01;
  const double load = sphere_mass(r, 2500.0) * 9.81 / std::sqrt(2.0);
  const double d = hertz_overlap(1e8 / (2 * (1 - 0.0625)), r, load);
  c.particles = {grain(r, {r - d, 0, r - d})};
  Simulation sim(c);
  while (sim.time_s() < 0.05) sim.step();
  EXPECT_EQ(sim.contacts(), 2u);
  EXPECT_NEAR(sim.spheres()[0].position.x(), r - d, 1e-6 * d);
  EXPECT_NEAR(sim.spheres()[0].position.z(), r - d, 1e-6 * d);
}

TEST(Rectangle, PushesOnceAtAConvexEdgeAndAtACorner) {
  // A sphere balanced on the rim that a table shares with its sides.
  scene::Case c = empty_case({});
  c.walls = {rectangle("top", {-1, -1, 0}, {1, 0, 0}, {0, 1, 0}),
             rectangle("side x", {0, -1, -1}, {0, 1, 0}, {0, 0, 1}),
             rectangle("side y", {-1, 0, -1}, {1, 0, 0}, {0, 0, 1})};
  const double r = 0.01;
  const Vec3 over_edge = Vec3(1, 0, 1).normalized() * (0.99 * r) + Vec3(0, -0.5, 0);
  const Vec3 over_corner = Vec3(1, 1, 1).normalized() * (0.99 * r);
  for (const Vec3& x : {over_edge, over_corner}) {
    c.particles = {grain(r, x)};
    Simulation sim(c);
    EXPECT_EQ(sim.contacts(), 1u);
    const double before = sim.kinetic_energy_j();
    sim.step();
    const Vec3 direction = sim.spheres()[0].velocity.normalized();
    EXPECT_NEAR(direction.dot((x - Vec3(0, x.y() < -0.1 ? x.y() : 0.0, 0)).normalized()), 1.0,
                1e-9);
    EXPECT_GT(sim.kinetic_energy_j(), before);
  }
}

TEST(Rectangle, PushesOnBothSides) {
  scene::Case c = empty_case({.restitution = 1.0});
  c.walls = {rectangle("plate", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0})};
  c.particles = {grain(0.01, {0, 0, 0.0101}, {0, 0, -0.1}),
                 grain(0.01, {0.5, 0, -0.0101}, {0, 0, 0.1})};
  Simulation sim(c);
  while (sim.time_s() < 0.02) sim.step();
  EXPECT_NEAR(sim.spheres()[0].velocity.z(), 0.1, 1e-4);
  EXPECT_NEAR(sim.spheres()[1].velocity.z(), -0.1, 1e-4);
}

TEST(Gate, LetsASphereFallOnceOpened) {
  scene::Case c = empty_case({});
  c.gravity_m_s2.z() = -9.81;
  c.walls = {rectangle("gate", {-0.1, -0.1, 0}, {0.2, 0, 0}, {0, 0.2, 0})};
  c.particles = {grain(0.01, {0, 0, 0.01})};
  Simulation sim(c);
  while (sim.time_s() < 0.1) sim.step();
  EXPECT_GT(sim.spheres()[0].position.z(), 0.0099);
  sim.open("gate");
  const double z0 = sim.spheres()[0].position.z();
  const double t0 = sim.time_s();
  while (sim.time_s() < 0.2) sim.step();
  const double t = sim.time_s() - t0;
  // Free fall but for the force of one step and the overlap that it released.
  EXPECT_NEAR(sim.spheres()[0].position.z() - z0, -0.5 * 9.81 * t * t, 1e-5 + 9.81 * t * 1e-4);
  EXPECT_EQ(sim.contacts(), 0u);
  EXPECT_THROW(sim.open("door"), InputError);
}

TEST(Periodic, ASphereCrossesAndMeetsItsNeighborOnTheOtherSide) {
  scene::Case c = empty_case({.restitution = 1.0});
  c.lower_m = {-1, 0, -1};
  c.upper_m = {1, 0.05, 1};
  c.periodic.y = true;
  c.particles = {grain(0.01, {0, 0.04, 0}, {0, 1, 0}), grain(0.01, {0, 0.015, 0})};
  Simulation sim(c);
  const double momentum = sim.spheres()[0].mass_kg;
  while (sim.time_s() < 0.03) sim.step();
  const auto s = sim.spheres();
  // Gap through the boundary: 0.05 - 0.025 - 0.02 = 5 mm; equal masses exchange velocities, and the
  // second then goes round and meets the first from the other side.
  EXPECT_NEAR(s[0].mass_kg * (s[0].velocity.y() + s[1].velocity.y()), momentum, 1e-12 * momentum);
  EXPECT_NEAR(s[1].velocity.y(), 1.0, 1e-3);
  EXPECT_GE(s[0].position.y(), 0.0);
  EXPECT_LT(s[1].position.y(), 0.05);
}

TEST(Domain, LosingASphereNamesItItsPlaceAndSpeed) {
  scene::Case c = empty_case({});
  c.gravity_m_s2.z() = -9.81;
  c.particles = {grain(0.01, {0, 0, 5}), grain(0.01, {1, 2, -9.9})};
  Simulation sim(c);
  try {
    while (sim.time_s() < 1.0) sim.step();
    FAIL();
  } catch (const SimulationError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("sphere 1 left the domain at (1, 2, -10"), std::string::npos) << text;
    EXPECT_NE(text.find("m/s"), std::string::npos) << text;
  }
}

TEST(Simulation, RefusesWhatItCannotRun) {
  scene::Case c = empty_case({});
  EXPECT_THROW(Simulation(c).step(), InputError);  // no spheres
  c.particles = {grain(0.01, {0, 0, 0})};
  EXPECT_THROW(Simulation(c, {.time_step_s = 1.0}).step(), InputError);
  Simulation sim(c);
  EXPECT_THROW(sim.add_particle(grain(-1.0, {0, 0, 0})), InputError);
  EXPECT_THROW(sim.add_particle(grain(0.01, {50, 0, 0})), InputError);
  EXPECT_EQ(sim.add_particle(grain(0.01, {1, 0, 0})), 1);
  sim.step();
  EXPECT_THROW(sim.add_particle(grain(0.01, {2, 0, 0})), InputError);
  c.pairs.clear();
  EXPECT_THROW(Simulation(c).step(), InputError);
  c = empty_case({});
  c.periodic.x = true;
  c.lower_m.x() = 0.0;
  c.upper_m.x() = 0.03;
  c.particles = {grain(0.01, {0.01, 0, 0})};
  EXPECT_THROW(Simulation{c}, InputError);  // a period must hold two diameters
}

}  // namespace
}  // namespace repose::dem

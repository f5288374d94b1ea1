#include <gtest/gtest.h>

#include <algorithm>

#include "small_cases.hpp"

namespace repose::dem {
namespace {

/// Deepest overlap, largest force on sphere 0 and contact time of one impact.
HertzImpact measured_impact(Simulation& sim, double radius, double mass) {
  HertzImpact seen{0.0, 0.0, 0.0};
  const double dt = sim.time_step_s();
  Vec3 before = sim.spheres()[0].velocity;
  std::int64_t touching = 0;
  bool touched = false;
  for (int k = 0; k < 20000; ++k) {
    sim.step();
    const Vec3 now = sim.spheres()[0].velocity;
    seen.largest_force = std::max(seen.largest_force, mass * (now - before).norm() / dt);
    before = now;
    const bool touches = sim.contacts() > 0;
    touching += touches ? 1 : 0;
    if (touched && !touches) break;
    touched = touches;
  }
  seen.largest_overlap = sim.take_largest_overlap().ratio() * radius;
  seen.duration = static_cast<double>(touching) * dt;
  return seen;
}

/// A discrete maximum is low by at most (curvature/2)(dt/2)^2, and leapfrog is of second order:
/// both are below (pi dt/T)^2; a duration counted in steps is off by at most one at each end.
void expect_like(const HertzImpact& seen, const HertzImpact& exact, double dt) {
  const double relative = std::pow(std::numbers::pi * dt / exact.duration, 2);
  EXPECT_NEAR(seen.largest_overlap, exact.largest_overlap, relative * exact.largest_overlap);
  EXPECT_NEAR(seen.largest_force, exact.largest_force, 2.0 * relative * exact.largest_force);
  EXPECT_NEAR(seen.duration, exact.duration, 2.0 * dt);
}

TEST(HertzContact, TwoEqualSpheresMatchClosedForm) {
  // [Chung2011, test 1]: glass and limestone; the closed form gives the figures in the last
  // columns.
  struct Row {
    double modulus, poisson, density, force, overlap, duration;
  };
  for (const Row& row : {Row{48e9, 0.20, 2800.0, 10696.9, 274.11e-6, 40.34e-6},
                         Row{20e9, 0.25, 2500.0, 7108.2, 368.30e-6, 54.20e-6}}) {
    scene::Case c = empty_case({.density = row.density,
                                .youngs_modulus = row.modulus,
                                .poissons_ratio = row.poisson,
                                .restitution = 1.0,
                                .mu_s = 0.35});
    const double r = 0.010;
    const double m = sphere_mass(r, row.density);
    c.particles = {grain(r, {-r - 1e-6, 0, 0}, {10, 0, 0}),
                   grain(r, {r + 1e-6, 0, 0}, {-10, 0, 0})};
    const double e_eff = row.modulus / (2.0 * (1.0 - row.poisson * row.poisson));
    const HertzImpact exact = hertz_impact(e_eff, r / 2, m / 2, 20.0);
    EXPECT_NEAR(exact.largest_force, row.force, 0.06);
    EXPECT_NEAR(exact.largest_overlap, row.overlap, 0.006e-6);
    EXPECT_NEAR(exact.duration, row.duration, 0.006e-6);
    Simulation sim(c, {.time_step_s = exact.duration / 1000});
    expect_like(measured_impact(sim, r, m), exact, sim.time_step_s());
  }
}

TEST(HertzContact, SphereOnRigidPlaneMatchesClosedForm) {
  // [Chung2011, test 2]: aluminium and magnesium alloy.
  struct Row {
    double modulus, poisson, density, force, overlap, duration;
  };
  for (const Row& row : {Row{70e9, 0.30, 2699.0, 11369.9, 49.717e-6, 731.7e-6},
                         Row{40e9, 0.35, 1800.0, 7232.7, 52.123e-6, 767.1e-6}}) {
    scene::Case c = empty_case({.density = row.density,
                                .youngs_modulus = row.modulus,
                                .poissons_ratio = row.poisson,
                                .restitution = 1.0,
                                .wall_stiffness = 1e9});
    const double r = 0.1;
    const double m = sphere_mass(r, row.density);
    c.walls = {floor_plane()};
    c.particles = {grain(r, {0, 0, r + 1e-8}, {0, 0, -0.2})};
    const double e_eff = row.modulus / (1.0 - row.poisson * row.poisson);
    const HertzImpact exact = hertz_impact(e_eff, r, m, 0.2);
    EXPECT_NEAR(exact.largest_force, row.force, 0.06);
    EXPECT_NEAR(exact.largest_overlap, row.overlap, 0.001e-6);
    EXPECT_NEAR(exact.duration, row.duration, 0.06e-6);
    Simulation sim(c, {.time_step_s = exact.duration / 1000});
    expect_like(measured_impact(sim, r, m), exact, sim.time_step_s());
  }
}

/// Ratio of the speeds after and before an impact on a plane, with `steps` steps in the contact.
double rebound_ratio(double restitution, double steps) {
  const OneMaterial alumina{.density = 4000.0,
                            .youngs_modulus = 380e9,
                            .poissons_ratio = 0.23,
                            .restitution = restitution};
  scene::Case c = empty_case(alumina);
  const double r = 0.0025;
  c.walls = {floor_plane()};
  c.particles = {grain(r, {0, 0, r + 1e-7}, {0, 0, -3.9})};
  const double e_eff = 380e9 / (2.0 * (1.0 - 0.23 * 0.23));
  const double duration = hertz_impact(e_eff, r, sphere_mass(r, 4000.0), 3.9).duration;
  Simulation sim(c, {.time_step_s = duration / steps});
  for (double k = 0; k < 4.0 * steps; ++k) sim.step();
  EXPECT_EQ(sim.contacts(), 0u);
  return sim.spheres()[0].velocity.z() / 3.9;
}

TEST(Restitution, OfAnImpactEqualsItsCoefficient) {
  // [Chung2011, test 3]; beta(e) is exact for Hertz contacts, what is left is of first order in dt.
  for (double e : {0.2, 0.4, 0.6, 0.8, 0.9, 1.0})
    EXPECT_NEAR(rebound_ratio(e, 4000.0), e, 2.0 / 4000.0) << e;
}

TEST(Restitution, ErrorOfAnImpactFallsWithTheTimeStep) {
  // Damping is taken half a step early, so the order is one; without it leapfrog has order two,
  // which the start of a contact inside a step lowers at worst to 1.5 for a force that grows with
  // d^1.5.
  const double damped_coarse = std::abs(rebound_ratio(0.5, 200.0) - 0.5);
  const double damped_fine = std::abs(rebound_ratio(0.5, 800.0) - 0.5);
  EXPECT_LT(damped_fine, damped_coarse / 3.0);
  EXPECT_GT(damped_coarse, 1e-5);
  const double elastic_coarse = std::abs(rebound_ratio(1.0, 50.0) - 1.0);
  const double elastic_fine = std::abs(rebound_ratio(1.0, 800.0) - 1.0);
  EXPECT_LT(elastic_fine, elastic_coarse / 64.0 + 1e-9);  // 16^1.5
}

TEST(PairCollision, ConservesLinearAndAngularMomentum) {
  scene::Case c = empty_case({.restitution = 0.6, .mu_s = 0.4, .mu_r = 0.1});
  c.particles = {grain(0.010, {-0.0105, 0.002, 0}, {1.5, 0.3, 0.1}, {10, -40, 25}),
                 grain(0.007, {0.0075, -0.003, 0.001}, {-0.8, 0, 0}, {-90, 15, 5})};
  Simulation sim(c);
  const auto momenta = [&] {
    Vec3 linear = Vec3::Zero();
    Vec3 angular = Vec3::Zero();
    for (const Sphere& s : sim.spheres()) {
      linear += s.mass_kg * s.velocity;
      const Vec3 p = s.mass_kg * s.velocity;
      angular += Vec3(s.position.y() * p.z() - s.position.z() * p.y(),
                      s.position.z() * p.x() - s.position.x() * p.z(),
                      s.position.x() * p.y() - s.position.y() * p.x());
      angular += 0.4 * s.mass_kg * s.radius_m * s.radius_m * s.angular_velocity;
    }
    return std::pair{linear, angular};
  };
  const auto before = momenta();
  const double energy = sim.kinetic_energy_j();
  bool touched = false;
  while (sim.time_s() < 0.01) {
    sim.step();
    touched = touched || sim.contacts() > 0;
  }
  EXPECT_TRUE(touched);
  const auto after = momenta();
  const double rounding = 1e-13;  // some hundred steps of sums of order 1e-2 and below
  EXPECT_LT((after.first - before.first).norm(), rounding * before.first.norm() * 100);
  EXPECT_LT((after.second - before.second).norm(), rounding * 100 * before.second.norm());
  EXPECT_LT(sim.kinetic_energy_j(), energy);
}

}  // namespace
}  // namespace repose::dem

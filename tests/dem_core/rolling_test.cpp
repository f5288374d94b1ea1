#include <gtest/gtest.h>

#include "small_cases.hpp"

namespace repose::dem {
namespace {

constexpr double kGravity = 9.81;

/// A sphere that rests on the plane z = 0, pressed to its static overlap, rolling or sliding in x.
struct OnPlane {
  OneMaterial material;
  double radius = 0.005;
  double slope = 0.0;  ///< of the plane, as an angle: gravity is tilted instead
  Vec3 velocity = Vec3::Zero();
  double spin = 0.0;

  double mass() const { return sphere_mass(radius, material.density); }
  double e_eff() const {
    return material.youngs_modulus /
           (2.0 * (1.0 - material.poissons_ratio * material.poissons_ratio));
  }
  double overlap() const {
    return hertz_overlap(e_eff(), radius, mass() * kGravity * std::cos(slope));
  }
  double contact_radius() const { return std::sqrt(radius * overlap()); }
  double rolling_stiffness() const {
    return 3.0 * e_eff() * contact_radius() * std::pow(material.mu_r * radius, 2);
  }
  double rolling_inertia() const { return 1.4 * mass() * radius * radius; }
  Simulation start(double rayleigh_fraction = 0.1) const {
    scene::Case c = empty_case(material);
    c.time_step_rayleigh_fraction = rayleigh_fraction;
    c.gravity_m_s2 = {kGravity * std::sin(slope), 0.0, -kGravity * std::cos(slope)};
    c.walls = {floor_plane()};
    c.particles = {grain(radius, {0, 0, radius - overlap()}, velocity, {0, spin, 0})};
    return Simulation(c);
  }
};

const OneMaterial kRolling{.density = 2500.0,
                           .youngs_modulus = 50e6,
                           .poissons_ratio = 0.3,
                           .restitution = 0.5,
                           .mu_s = 0.5,
                           .mu_r = 0.1};

TEST(Sliding, TurnsIntoRollingAtFiveSeventhsOfItsSpeed) {
  OneMaterial m = kRolling;
  m.mu_r = 0.0;
  const OnPlane plane{.material = m, .velocity = {0.2, 0, 0}};
  Simulation sim = plane.start();
  while (sim.time_s() < 0.2) sim.step();
  const Sphere s = sim.spheres()[0];
  // The lever arm is R - d/2 instead of R: a relative change of order d/R.
  const double tolerance = plane.overlap() / plane.radius;
  EXPECT_NEAR(s.velocity.x(), 5.0 / 7.0 * 0.2, tolerance * 0.2);
  EXPECT_NEAR(s.angular_velocity.y() * plane.radius, s.velocity.x(), tolerance * 0.2);
}

TEST(Slope, SpeedMatchesRollingAndSlidingTheory) {
  OneMaterial m = kRolling;
  m.mu_r = 0.0;
  m.mu_s = 0.2;
  for (double degrees : {20.0, 50.0}) {  // rolls while tan(slope) < 3.5 mu = 0.7
    const double slope = degrees * std::numbers::pi / 180.0;
    const OnPlane plane{.material = m, .slope = slope};
    Simulation sim = plane.start();
    while (sim.time_s() < 0.1) sim.step();
    const double acceleration = degrees < 35.0
                                    ? 5.0 / 7.0 * kGravity * std::sin(slope)
                                    : kGravity * (std::sin(slope) - 0.2 * std::cos(slope));
    // The tangential spring loads over d_t ~ mu d first, out of a path of centimetres.
    EXPECT_NEAR(sim.spheres()[0].velocity.x(), acceleration * sim.time_s(),
                5e-4 * acceleration * sim.time_s())
        << degrees;
  }
}

TEST(Slope, WithoutFrictionASphereSlidesLikeABlock) {
  OneMaterial m = kRolling;
  m.mu_r = 0.0;
  m.mu_s = 0.0;
  const OnPlane plane{.material = m, .slope = 0.5};
  Simulation sim = plane.start();
  while (sim.time_s() < 0.1) sim.step();
  const Sphere s = sim.spheres()[0];
  EXPECT_NEAR(s.velocity.x(), kGravity * std::sin(0.5) * sim.time_s(), 1e-12);
  EXPECT_EQ(s.angular_velocity.norm(), 0.0);
}

TEST(Slope, RollingFrictionHoldsBelowItsAngleAndYieldsAbove) {
  const double below = std::atan(0.08);
  Simulation held = OnPlane{.material = kRolling, .slope = below}.start();
  while (held.time_s() < 1.0) held.step();
  EXPECT_LT(held.spheres()[0].position.x(), 20e-6);
  EXPECT_LT(held.spheres()[0].velocity.norm(), 1e-9);

  const double above = std::atan(0.12);
  Simulation free = OnPlane{.material = kRolling, .slope = above}.start();
  while (free.time_s() < 0.5) free.step();
  const double start = free.spheres()[0].velocity.x();
  const double from = free.time_s();
  while (free.time_s() < 1.0) free.step();
  const double acceleration = (free.spheres()[0].velocity.x() - start) / (free.time_s() - from);
  const double theory = 5.0 / 7.0 * kGravity * (std::sin(above) - 0.1 * std::cos(above));
  EXPECT_NEAR(acceleration, theory, 1e-3 * 5.0 / 7.0 * kGravity * 0.1);
}

TEST(RollingFriction, StopsARollingSphereInTimeAndDistance) {
  const double v0 = 0.1;
  const OnPlane plane{.material = kRolling, .velocity = {v0, 0, 0}, .spin = v0 / 0.005};
  Simulation sim = plane.start();
  const double deceleration = 5.0 / 7.0 * 0.1 * kGravity;
  while (sim.spheres()[0].velocity.x() > 0.0 && sim.time_s() < 1.0) sim.step();
  // Until the rolling spring has wound up to its limit, over an angle M_max/k_r, the dashpot acts
  // and takes C_r/I_r of that angle; the path of winding itself is neither fast nor slow rolling.
  const double winding = 0.1 * plane.radius * plane.mass() * kGravity / plane.rolling_stiffness();
  const double damping = 2.0 * 0.3 * std::sqrt(plane.rolling_stiffness() / plane.rolling_inertia());
  const double speed = v0 - damping * winding * plane.radius;
  const double extra_path = winding * plane.radius;
  EXPECT_NEAR(sim.spheres()[0].position.x(), speed * speed / (2.0 * deceleration),
              2.0 * extra_path);
  EXPECT_NEAR(sim.time_s(), speed / deceleration, 2.0 * extra_path / v0 + 2.0 * sim.time_step_s());
  EXPECT_NEAR(v0 / deceleration, 0.14271, 1e-5);
  while (sim.time_s() < 2.0) sim.step();
  EXPECT_LT(sim.spheres()[0].velocity.norm(), 1e-12);  // comes to rest, no creep
}

/// Lowest angular frequency of rolling on the rolling spring k_r and the tangential spring k_t:
/// m x" = -k_t (x - R q), 0.4 m R^2 q" = k_t R (x - R q) - k_r q.
double rolling_frequency(const OnPlane& plane) {
  const double m = plane.mass();
  const double inertia = 0.4 * m * plane.radius * plane.radius;
  const double shear =
      plane.material.youngs_modulus / (2.0 * (1.0 + plane.material.poissons_ratio));
  const double k_t =
      8.0 * shear / (2.0 * (2.0 - plane.material.poissons_ratio)) * plane.contact_radius();
  const double a = k_t / m;
  const double b = (k_t * plane.radius * plane.radius + plane.rolling_stiffness()) / inertia;
  const double c = k_t * plane.radius / m * k_t * plane.radius / inertia;
  return std::sqrt(0.5 * (a + b - std::sqrt((a - b) * (a - b) + 4.0 * c)));
}

/// Time between the first two zeros of the velocity of a sphere that rocks without slip.
double rocking_half_period(const OnPlane& plane) {
  Simulation sim = plane.start(0.05);
  std::vector<double> zeros;
  double before = plane.velocity.x();
  while (zeros.size() < 2 && sim.time_s() < 1.0) {
    sim.step();
    const double now = sim.spheres()[0].velocity.x();
    if (before * now <= 0.0)
      zeros.push_back(sim.time_s() - sim.time_step_s() * now / (now - before));
    before = now;
  }
  return zeros.size() == 2 ? zeros[1] - zeros[0] : 0.0;
}

TEST(RollingFriction, RocksWithItsOwnPeriod) {
  OneMaterial undamped = kRolling;
  undamped.rolling_damping = 0.0;
  undamped.restitution = 1.0;
  const OnPlane plane{.material = undamped, .velocity = {1e-4, 0, 0}, .spin = 1e-4 / 0.005};
  // The tangential mode, ten times as fast, is excited a little too and shifts the zeros.
  const double exact = std::numbers::pi / rolling_frequency(plane);
  EXPECT_NEAR(exact,
              std::numbers::pi * std::sqrt(plane.rolling_inertia() / plane.rolling_stiffness()),
              0.01 * exact);
  EXPECT_NEAR(rocking_half_period(plane), exact, 5e-3 * exact);

  OneMaterial damped = undamped;
  damped.rolling_damping = 0.3;
  const OnPlane slower{.material = damped, .velocity = {1e-4, 0, 0}, .spin = 1e-4 / 0.005};
  EXPECT_NEAR(rocking_half_period(slower), exact / std::sqrt(1.0 - 0.09), 0.01 * exact);
}

}  // namespace
}  // namespace repose::dem

// Clumps: volume and inertia against closed forms, free motion, and their part
// in a settled heap.
#include <cmath>
#include <numbers>

#include "check.hpp"
#include "particles/rotation.hpp"
#include "repose/base/random.hpp"
#include "repose/dem/cross.hpp"
#include "repose/dem/simulation.hpp"
#include "repose/scene/clump_form.hpp"

namespace repose::physics {
namespace {

using dem::Vec3;
constexpr double kPi = std::numbers::pi;

/// Two unit spheres whose centres are 2 s apart: each is cut at the distance s
/// from its centre.
struct Dumbbell {
  double volume, along, across;  ///< second moments along the axis and across it
  explicit Dumbbell(double s) {
    const double one = kPi * (2.0 / 3.0 + s - s * s * s / 3.0);
    const double first = kPi * std::pow(1.0 - s * s, 2) / 4.0;
    const double second = kPi * (2.0 / 15.0 + s * s * s / 3.0 - std::pow(s, 5) / 5.0);
    const auto disc = [](double z) {
      return kPi / 4.0 * (z - 2.0 * z * z * z / 3.0 + std::pow(z, 5) / 5.0);
    };
    volume = 2.0 * one;
    along = 2.0 * (second + 2.0 * s * first + s * s * one);
    across = 2.0 * (disc(1.0) + disc(s));
  }
};

void add_inertia(std::vector<Check>& checks) {
  double worst = 0.0;
  for (double s : {0.05, 0.2, 0.5, 0.8, 0.95}) {
    const Dumbbell exact(s);
    const Vec3 axis = Vec3(1, -2, 3).normalized();
    const auto m = scene::union_moments({{-s * axis, 1.0}, {s * axis, 1.0}});
    const double along = axis.dot(m.second * axis);
    worst = std::max({worst, std::abs(m.volume / exact.volume - 1.0),
                      std::abs(along / exact.along - 1.0),
                      std::abs((m.second.trace() - along) / (2.0 * exact.across) - 1.0)});
  }
  checks.push_back(
      {"two overlapping spheres: largest relative error of volume "
       "and second moments",
       worst, 0.0, 1e-10, "", Demand::at_most});
  const auto form = scene::clump_form(scene::shipped_clumps().front());
  const double lens = kPi * 5.75 * 0.0625 / 12.0;
  checks.push_back({"sinter_3: radius of a constituent over the equivalent radius",
                    form.smallest_radius, std::cbrt(1.0 / (3.0 - 3.0 * lens / (4.0 / 3.0 * kPi))),
                    1e-9});
}

/// Precession of a symmetric top about its angular momentum: |L|/A.
double precession_error(int steps) {
  const double a = 2.0, c = 1.0, duration = 5.0;
  const Vec3 l(0.3, 0.0, 1.0);
  dem::Quaternion q;
  for (int k = 0; k < steps; ++k) q = dem::free_rotation(q, l, {c, a, a}, duration / steps);
  const Vec3 n = l.normalized();
  const Vec3 start = Vec3::UnitX();
  const double angle = l.norm() / a * duration;
  const Vec3 along = start.dot(n) * n;
  const Vec3 expected =
      along + std::cos(angle) * (start - along) + std::sin(angle) * dem::cross(n, start);
  return (dem::rotation_matrix(q).col(0) - expected).norm();
}

void add_precession(Extent extent, std::vector<Check>& checks) {
  const double coarse = precession_error(400), fine = precession_error(800);
  checks.push_back(
      {"free precession of a symmetric body: error of its axis "
       "after 0.4 turns, 800 steps",
       fine, 0.0, 5e-5, "rad", Demand::at_most});
  checks.push_back({"free precession: order of the error in the time step",
                    std::log2(coarse / fine), 2.0, 0.05});
  const Vec3 inertia(1.0, 1.5, 2.2), l(0.1, 1.0, 0.2);
  dem::Quaternion q;
  const auto energy = [&] {
    const Vec3 p = dem::rotation_matrix(q).transpose() * l;
    return 0.5 * p.dot(p.cwiseQuotient(inertia));
  };
  const double before = energy();
  const int steps = extent == Extent::quick ? 100000 : 5000000;
  double largest = 0.0;
  for (int k = 0; k < steps; ++k) {
    q = dem::free_rotation(q, l, inertia, 0.01);
    largest = std::max(largest, std::abs(energy() / before - 1.0));
  }
  checks.push_back(
      {"a body tumbling about its unstable axis: largest relative "
       "error of its energy "
       "over all steps, 0.0064 rad each",
       largest, 0.0, 1e-5, "", Demand::at_most});
}

/// Two clumps meet off centre, without friction and dissipation.
void add_collision(std::vector<Check>& checks) {
  scene::Case c;
  c.gravity_m_s2.setZero();
  c.lower_m.setConstant(-1.0);
  c.upper_m.setConstant(1.0);
  c.time_step_rayleigh_fraction = 0.02;
  c.materials = {{"grain", 2500.0, 1e8, 0.25}};
  c.pairs = {{"grain", "grain", 1.0, 0.0, 0.0, 0.3}};
  c.stages = {{.name = "fly", .duration_s = 1.0}};
  scene::Particle left, right;
  left.material = right.material = "grain";
  left.clump = right.clump = "sinter_3";
  left.radius_m = right.radius_m = 0.01;
  left.position = {-0.02, 0.004, 0.001};
  left.velocity = {0.5, 0, 0};
  left.angular_velocity = {0, 3, 9};
  right.position = {0.02, 0, 0};
  right.velocity = {-0.5, 0, 0};
  right.orientation_wxyz = {0.5, 0.5, -0.5, 0.5};
  c.particles = {left, right};
  dem::Simulation sim(c);
  struct Totals {
    Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
    double energy = 0.0;
  };
  const auto totals = [&] {
    Totals t;
    for (const dem::Body& b : sim.bodies()) {
      t.momentum += b.mass_kg * b.velocity;
      t.angular += b.angular_momentum() + b.mass_kg * dem::cross(b.position, b.velocity);
      t.energy += b.kinetic_energy_j();
    }
    return t;
  };
  const Totals before = totals();
  bool touched = false;
  while (sim.time_s() < 0.1) {
    sim.step(20);
    touched = touched || sim.contacts() > 0;
  }
  const Totals after = totals();
  const double p = sim.bodies()[0].mass_kg * 0.5;
  checks.push_back({"two clumps collide: they did touch and part",
                    touched && sim.contacts() == 0 ? 1.0 : 0.0, 1.0, 0.0});
  checks.push_back({"two clumps collide off centre: change of momentum over m v",
                    (after.momentum - before.momentum).norm() / p, 0.0, 1e-12, "",
                    Demand::at_most});
  checks.push_back({"two clumps collide off centre: change of angular momentum over m v R",
                    (after.angular - before.angular).norm() / (p * 0.01), 0.0, 1e-5, "",
                    Demand::at_most});
  checks.push_back({"two clumps collide without losses: relative change of energy",
                    std::abs(after.energy / before.energy - 1.0), 0.0, 1e-3, "", Demand::at_most});
}

}  // namespace

std::vector<Check> clumps(Extent extent) {
  std::vector<Check> checks;
  add_inertia(checks);
  add_precession(extent, checks);
  add_collision(checks);
  return checks;
}

}  // namespace repose::physics

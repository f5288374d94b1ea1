#include <algorithm>
#include <cmath>

#include "../dem_core/two_bodies.hpp"
#include "check.hpp"
#include "impact.hpp"
#include "repose/base/random.hpp"

namespace repose::physics {
namespace {

using dem::Vec3;

Vec3 momentum(const Vec3& x, const Vec3& v, double mass) {
  return mass * Vec3(x.y() * v.z() - x.z() * v.y(), x.z() * v.x() - x.x() * v.z(),
                     x.x() * v.y() - x.y() * v.x());
}

/// Orbital and spin.
Vec3 angular_momentum_of(dem::Simulation& sim) {
  Vec3 sum = Vec3::Zero();
  for (const dem::Sphere& s : sim.spheres())
    sum += momentum(s.position, s.velocity, s.mass_kg) +
           0.4 * s.mass_kg * s.radius_m * s.radius_m * s.angular_velocity;
  return sum;
}

Vec3 random_vector(RandomStream& random) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return Vec3(2.0 * x - 1.0, 2.0 * y - 1.0, 2.0 * z - 1.0);
}

}  // namespace

std::vector<Check> angular_momentum(Extent extent) {
  std::vector<Check> checks;
  for (const auto& [mode, model] : {std::pair{"keep", kept()}, std::pair{"clip", clipped()}}) {
    scene::Case c = dem::empty_case({.restitution = 0.6, .mu_s = 0.4, .mu_r = 0.1});
    c.contact = model;
    c.particles = {dem::grain(0.010, {-0.0105, 0.002, 0}, {1.5, 0.3, 0.1}, {10, -40, 25}),
                   dem::grain(0.007, {0.0075, -0.003, 0.001}, {-0.8, 0, 0}, {-90, 15, 5})};
    dem::Simulation pair(c);
    const Vec3 before = angular_momentum_of(pair);
    while (pair.time_s() < 0.01) pair.step();
    checks.push_back({std::string("two spheres of different size, tail ") + mode +
                          ": relative change of orbital and spin momentum in a collision",
                      (angular_momentum_of(pair) - before).norm() / before.norm(), 0.0, 1e-11});

    // A cloud that falls together: every sphere heads for the middle.
    scene::Case gas = dem::empty_case({.restitution = 0.8, .mu_s = 0.5, .mu_r = 0.2});
    gas.contact = model;
    RandomStream random(1);
    const int across = extent == Extent::full ? 6 : 4;
    for (int i = 0; i < across * across * across; ++i) {
      const Vec3 site(i % across, i / across % across, i / across / across);
      const Vec3 x =
          0.012 * (site - Vec3::Constant(0.5 * (across - 1))) + 0.001 * random_vector(random);
      gas.particles.push_back(dem::grain(0.003 + 0.002 * random.uniform(), x,
                                         -20.0 * x + 0.3 * random_vector(random),
                                         20.0 * random_vector(random)));
    }
    dem::Simulation cloud(gas);
    const Vec3 start = angular_momentum_of(cloud);
    const double energy = cloud.kinetic_energy_j();
    while (cloud.time_s() < 0.1) cloud.step(100);
    checks.push_back({std::string("closed cloud of ") + std::to_string(cloud.size()) +
                          " spheres, tail " + mode + ": relative change of angular momentum",
                      (angular_momentum_of(cloud) - start).norm() / start.norm(), 0.0, 1e-10});
    checks.push_back({"its kinetic energy after, of that before (it did collide)",
                      cloud.kinetic_energy_j() / energy, 0.7, 0.0, "", Demand::at_most});
  }
  return checks;
}

namespace {

/// Relative change of the kinetic energy of an elastic gas, and the share of samples in contact.
struct GasDrift {
  double energy = 0.0, touching = 0.0;
};

GasDrift gas_drift(double rayleigh_fraction, std::int64_t steps) {
  scene::Case c = dem::empty_case({.youngs_modulus = 1e7, .restitution = 1.0});
  c.time_step_rayleigh_fraction = rayleigh_fraction;
  c.lower_m.setConstant(-0.03);
  c.upper_m.setConstant(0.03);
  c.periodic = {true, true, true};
  RandomStream random(3);
  for (int i = 0; i < 27; ++i) {
    const Vec3 site(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    c.particles.push_back(dem::grain(0.005, 0.02 * site, random_vector(random)));
  }
  dem::Simulation sim(c);
  const double start = sim.kinetic_energy_j();
  double last = start;
  std::int64_t touching = 0;
  for (std::int64_t k = 0; k < steps; k += 10) {
    sim.step(10);
    if (sim.contacts() == 0) last = sim.kinetic_energy_j();
    touching += sim.contacts() > 0 ? 1 : 0;
  }
  return {last / start - 1.0, 10.0 * static_cast<double>(touching) / static_cast<double>(steps)};
}

}  // namespace

std::vector<Check> elastic_gas(Extent extent) {
  const std::int64_t steps = extent == Extent::full ? 1'000'000 : 100'000;
  const std::string after = " after " + std::to_string(steps) + " steps";
  const GasDrift fine = gas_drift(0.02, steps);
  return {{"change of the kinetic energy between contacts at 0.02 of the Rayleigh time, about 120 "
           "steps a contact," +
               after,
           fine.energy, 0.0, 1e-4},
          {"share of its samples with a contact (the gas does collide)", fine.touching, 0.2, 0.0,
           "", Demand::at_least},
          {"the same change at 0.15 of the Rayleigh time, 16 steps a contact," + after,
           gas_drift(0.15, steps).energy, 0.0, 0.0, "", Demand::report}};
}

namespace {

/// Two spheres held together by cohesion, a little twisted against each other in sliding and
/// rolling, without any loss; the whole turns with `rate` about `axis`.
dem::TwoBodies bound_pair(double rate, const Vec3& axis, const scene::ContactModel& model) {
  scene::Material material{"grain", 2500.0, 1e8, 0.25};
  scene::PairCoefficients pair;
  pair.restitution = 1.0;
  pair.mu_s = 1e3;  // sticks
  pair.mu_r = 0.3;
  pair.rolling_damping = 0.0;
  pair.cohesion_energy_density_j_m3 = 2e6;
  dem::TwoBodies two;
  two.model = model;
  two.law = dem::make_pair_law(material, material, pair, model);
  // Static overlap: Hertz's force equals cohesion; A is nearly linear in d.
  const double radius = 0.005;
  const double area_slope = std::numbers::pi * radius;  // of two equal spheres: 2 pi R* d
  const double overlap = std::pow(0.75 * pair.cohesion_energy_density_j_m3 * area_slope /
                                      (two.law.e_eff * std::sqrt(0.5 * radius)),
                                  2.0);
  const Vec3 half(radius - 0.5 * overlap, 0, 0);
  const Vec3 spin = rate * axis;
  two.set(two.a, two.wa, radius, 2500.0, -half, dem::cross(spin, -half), spin + Vec3(0, 3, 1));
  two.set(two.b, two.wb, radius, 2500.0, half, dem::cross(spin, half), spin + Vec3(0, -2, 2));
  two.dt = 0.05 * dem::rayleigh_time_s(material, radius);
  return two;
}

/// Largest change of kinetic + stored energy over `turns` turns of the pair, relative to the
/// energy of the relative spins, which the springs take up and return.
double energy_drift(dem::TwoBodies two, double rate, double turns) {
  const double own = 0.5 * (9.0 + 1.0 + 4.0 + 4.0) / two.wa.inv_inertia;
  const double time = turns * 2.0 * std::numbers::pi / rate;
  double start = 0.0, first = 0.0, last = 0.0;
  const auto steps = static_cast<std::int64_t>(time / two.dt);
  for (std::int64_t k = 0; k < steps; ++k) {
    two.step();
    const double energy = two.kinetic_j() + two.energies.stored_j();
    if (k == 0) start = energy;
    if (k < steps / 10) first += (energy - start) / static_cast<double>(steps / 10);
    if (k >= steps - steps / 10) last += (energy - start) / static_cast<double>(steps / 10);
  }
  return two.touching ? std::abs(last - first) / own : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<Check> rotating_frame(Extent extent) {
  const double turns = extent == Extent::full ? 100.0 : 10.0;
  const double rate = 200.0;
  std::vector<Check> checks;
  for (const auto& [name, axis] : {std::pair{"end over end", Vec3(0, 0, 1)},
                                   std::pair{"end over end, tilted", Vec3(0, 0.6, 0.8)}})
    checks.push_back({std::string("bound pair turning ") + name + ", " +
                          std::to_string(static_cast<int>(turns)) +
                          " turns: drift of kinetic and stored energy, of that in the springs",
                      energy_drift(bound_pair(rate, axis, kept()), rate, turns), 0.0, 0.01});
  scene::ContactModel liggghts;
  liggghts.compatibility = scene::Compatibility::liggghts;
  checks.push_back({"the same end over end under compat = liggghts (infinite: the pair came apart)",
                    energy_drift(bound_pair(rate, {0, 0, 1}, liggghts), rate, turns), 0.0, 0.0, "",
                    Demand::report});
  return checks;
}

}  // namespace repose::physics

// Two spheres, or a sphere and the plane z = 0, followed with the law alone: leapfrog in twenty
// lines, with the energies that the engine need not keep.
#pragma once

#include "contact/contact_evaluation.hpp"
#include "small_cases.hpp"

namespace repose::dem {

class TwoBodies {
 public:
  scene::ContactModel model;
  PairLaw law;
  double dt = 0.0;
  Motion a{}, b{};  ///< velocities half a step before the positions, as while forces are computed
  Spin wa{}, wb{};
  bool at_wall = false;  ///< b is the plane z = 0, below a
  Vec3 gravity = Vec3::Zero();

  ContactHistory history{};
  ContactForce force{};
  ContactEnergies energies{};
  double lost_j = 0.0;  ///< integral of energies.lost_w(), and what the contact stored at its end
  bool touching = false;

  void set(Motion& motion, Spin& spin, double radius, double density, const Vec3& x, const Vec3& v,
           const Vec3& w) const {
    const double mass = sphere_mass(radius, density);
    motion = {x, radius, v, 1.0 / mass};
    spin = {w, 2.5 / (mass * radius * radius)};
  }

  ContactKinematics kinematics() const {
    const Vec3 offset = b.x - a.x;
    return at_wall ? wall_kinematics(dt, -Vec3::UnitZ(), a.radius - a.x.z(), a, wa.w, Twist{})
                   : pair_kinematics(model, dt, offset, offset.norm(), a, b, wa.w, wb.w);
  }
  ContactBodies bodies() const {
    return at_wall ? sphere_wall(a.radius, 1.0 / a.inv_mass)
                   : sphere_sphere(a.radius, 1.0 / a.inv_mass, b.radius, 1.0 / b.inv_mass);
  }

  /// Drift, force, kick.
  void step() {
    a.x += dt * a.v;
    b.x += dt * b.v;
    force = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), 0.0};
    const double stored_j = energies.stored_j();
    energies = {};
    const ContactKinematics now = kinematics();
    touching = now.overlap > 0.0;
    if (!touching) lost_j += stored_j;
    if (touching)
      force = hertz_mindlin(model, law, bodies(), now, dt, history, energies);
    else
      history = {};
    lost_j += energies.lost_w() * dt;
    const Vec3 turning = cross(now.normal, force.tangential);
    a.v += dt * (a.inv_mass * force.force + gravity);
    wa.w +=
        (dt * wa.inv_inertia) * ((a.radius - 0.5 * now.overlap) * turning + force.rolling_torque);
    if (at_wall) return;
    b.v += dt * (gravity - b.inv_mass * force.force);
    wb.w +=
        (dt * wb.inv_inertia) * ((b.radius - 0.5 * now.overlap) * turning - force.rolling_torque);
  }

  /// With the velocities of half a step after the positions.
  double kinetic_j() const {
    const auto of = [](const Motion& m, const Spin& s) {
      return 0.5 * m.v.squaredNorm() / m.inv_mass + 0.5 * s.w.squaredNorm() / s.inv_inertia;
    };
    return of(a, wa) + (at_wall ? 0.0 : of(b, wb));
  }
};

/// A sphere of the material before the plane z = 0 or an equal sphere, about to hit it.
inline TwoBodies impact_of(const OneMaterial& m, const scene::ContactModel& model, double radius,
                           const Vec3& velocity, const Vec3& spin, double steps) {
  TwoBodies two;
  two.model = model;
  const scene::Case c = empty_case(m);
  two.law = make_pair_law(c.materials[0], c.materials[1], c.pairs[1], model);
  two.at_wall = true;
  two.set(two.a, two.wa, radius, m.density, {0, 0, radius}, velocity, spin);
  const double mass = sphere_mass(radius, m.density);
  two.dt = hertz_impact(two.law.e_eff, radius, mass, -velocity.z()).duration / steps;
  return two;
}

}  // namespace repose::dem

// What contacts of pairs and with walls share: from motion to kinematics, from kinematics to force.
#pragma once

#include "contact/contact_pool.hpp"
#include "contact/law_table.hpp"
#include "motion/rigid_motion.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// Kinematics of two spheres whose centres are `offset` apart, from i to j; `distance` is its
/// length. Velocities act at t - dt/2 along the line of centres of that time [Vyas2025].
[[gnu::always_inline]] inline ContactKinematics pair_kinematics(const scene::ContactModel& model,
                                                                double dt, const Vec3& offset,
                                                                double distance, const Motion& i,
                                                                const Motion& j, const Vec3& w_i,
                                                                const Vec3& w_j) {
  ContactKinematics now;
  const double both = i.radius + j.radius;
  now.inv_distance = 1.0 / distance;
  now.normal = offset * now.inv_distance;
  now.overlap = both - distance;
  now.velocity = i.v - j.v;
  now.spin = w_i - w_j;
  double overlap_half = now.overlap;
  now.normal_half = now.normal;
  if (model.compatibility == scene::Compatibility::none) {
    now.normal_half = offset + (0.5 * dt) * now.velocity;
    const double distance_half = now.normal_half.norm();
    now.normal_half *= 1.0 / distance_half;
    overlap_half = both - distance_half;
  }
  const Vec3 surface =
      (i.radius - 0.5 * overlap_half) * w_i + (j.radius - 0.5 * overlap_half) * w_j;
  now.velocity += cross(surface, now.normal_half);
  now.turning = 0.5 * (w_i + w_j).dot(now.normal_half);
  return now;
}

/// Kinematics of a sphere at a wall that moves with `twist` at t - dt/2: both velocities are taken
/// at that time and at the point of contact of that time, so that a sphere which the wall carries
/// along does not slip. A wall is flat or large, so that its normal is taken at t alone.
inline ContactKinematics wall_kinematics(double dt, const Vec3& normal, double overlap,
                                         const Motion& sphere, const Vec3& w, const Twist& twist) {
  const double arm = sphere.radius - 0.5 * overlap;
  const Vec3 point = sphere.x - (0.5 * dt) * sphere.v + arm * normal;
  ContactKinematics now;
  now.normal = normal;
  now.normal_half = normal;
  now.overlap = overlap;
  now.velocity = sphere.v - twist.at(point) + arm * cross(w, normal);
  now.spin = w - twist.spin;
  now.turning = twist.spin.dot(normal);
  return now;
}

/// hertz_mindlin() that adds what the contact stores and loses to `sum`, if that is
/// ContactEnergies.
template <class Energies>
[[gnu::always_inline]] inline ContactForce contact_force(const scene::ContactModel& model,
                                                         const PairLaw& law,
                                                         const ContactKinematics& now, double dt,
                                                         Contact& contact, Energies& sum) {
  Energies energies;
  const ContactForce force =
      hertz_mindlin(model, law, contact.bodies, now, dt, contact.history, energies);
  if constexpr (std::is_same_v<Energies, ContactEnergies>) {
    contact.stored_j = energies.stored_j();
    sum += energies;
  }
  return force;
}

}  // namespace repose::dem

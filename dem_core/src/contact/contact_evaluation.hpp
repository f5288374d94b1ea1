// What contacts of pairs and with walls share: from motion to kinematics, from kinematics to force.
#pragma once

#include "contact/contact_pool.hpp"
#include "contact/law_table.hpp"
#include "motion/rigid_motion.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// Kinematics of two spheres whose centres are `offset` apart, from i to j; `distance` is its
/// length. Velocities act at t - dt/2 along the line of centres of that time [Vyas2025].
inline ContactKinematics pair_kinematics(const scene::ContactModel& model, double dt,
                                         const Vec3& offset, double distance, const Motion& i,
                                         const Motion& j, const Vec3& w_i, const Vec3& w_j) {
  using detail::lanes;
  using detail::vec3;
  const detail::KinematicsLanes<double> now = detail::kinematics_of_pair<double>(
      model, dt, lanes(offset), distance, {lanes(i.v), lanes(w_i), i.radius, i.inv_mass},
      {lanes(j.v), lanes(w_j), j.radius, j.inv_mass});
  return {vec3(now.normal),   vec3(now.normal_half), now.overlap, now.inv_distance,
          vec3(now.velocity), vec3(now.spin),        now.turning};
}

/// Kinematics of a sphere at a wall that moves with `twist` at t - dt/2: both velocities are taken
/// at that time and at the point of contact of that time, so that a sphere which the wall carries
/// along does not slip. A wall is flat or large, so that its normal is taken at t alone.
inline ContactKinematics wall_kinematics(double dt, const Vec3& normal, double overlap,
                                         const Motion& sphere, const Vec3& w, const Twist& twist) {
  using detail::lanes;
  using detail::vec3;
  const detail::KinematicsLanes<double> now = detail::kinematics_at_wall<double>(
      dt, lanes(normal), overlap, lanes(sphere.x),
      {lanes(sphere.v), lanes(w), sphere.radius, sphere.inv_mass}, lanes(twist.velocity),
      lanes(twist.spin));
  return {vec3(now.normal),   vec3(now.normal_half), now.overlap, now.inv_distance,
          vec3(now.velocity), vec3(now.spin),        now.turning};
}

}  // namespace repose::dem

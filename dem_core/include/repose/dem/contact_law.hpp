// The contact law "hm1": Hertz-Mindlin with displacement history, rolling friction and cohesion.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "repose/dem/contact_energies.hpp"
#include "repose/dem/cross.hpp"
#include "repose/dem/pair_law.hpp"

namespace repose::dem {

/// What a contact remembers from step to step; both are tangential, of i relative to j.
struct ContactHistory {
  Vec3 slip = Vec3::Zero();     ///< displacement xi of the tangential spring, m
  Vec3 rolling = Vec3::Zero();  ///< torque of the rolling spring, N m
};

/// A contact at time t with the velocities of t - dt/2, as leapfrog has them. Normals point from i
/// to j.
struct ContactKinematics {
  Vec3 normal;                ///< at t
  Vec3 normal_half;           ///< at t - dt/2; `normal` at walls and under Compatibility::liggghts
  double overlap;             ///< > 0
  double inv_distance = 0.0;  ///< 1/|x_ij|; 0 at a wall
  Vec3 velocity;              ///< of i's surface relative to j's at the contact point, m/s
  Vec3 spin;                  ///< angular velocity of i relative to j (of i at a wall), rad/s
  /// Rate at which the contact as a whole turns about its normal, rad/s: half of (w_i + w_j).n of a
  /// pair, that of the wall at a wall. History turns with it, but for Compatibility::liggghts.
  double turning = 0.0;
};

struct ContactForce {
  Vec3 force;           ///< on i, all parts; on j its opposite
  Vec3 tangential;      ///< the tangential part of `force`
  Vec3 rolling_torque;  ///< on i; on j its opposite
  double normal;        ///< F_n without cohesion, positive where it pushes
};

/// A contact as statistics see it.
struct ContactState {
  double overlap_m = 0.0;
  double normal_force_n = 0.0;  ///< without cohesion
  double tangential_force_n = 0.0;
  bool sliding = false;  ///< sliding friction is mobilised; never without friction
};

/// One contact over the step dt that ends at t; `history` goes in as of the last step and comes out
/// as of now. With contact radius a = sqrt(R* d), S_n = 2 E* a, S_t = 8 G* a:
///   F_n = (4/3) E* a d + 2 sqrt(5/6) beta sqrt(S_n m*) v_n,  v_n > 0 approaching; Tail::clip cuts
///         it at 0
///   xi  is turned to the normal of t - dt/2 and about it with the contact, v_t dt added, turned to
///         the normal of t, keeping its length each time [Vyas2025]; Compatibility::liggghts adds,
///         then projects onto the plane
///   F_t = -S_t xi - 2 sqrt(5/6) beta sqrt(S_t m*) v_t     while S_t |xi| <= mu |F_n|, else
///   F_t = -mu |F_n| xi/|xi|, and xi is shortened to |F_t|/S_t; Tail::clip caps the first at mu F_n
/// Rolling: detail::rolling_spring() or rolling_resistance(). Cohesion, not in the limits:
/// cohesion_area().
/// With dt = 0 history only turns. `energies` may be a ContactEnergies, which is overwritten.
template <class Energies = NoEnergies>
ContactForce hertz_mindlin(const scene::ContactModel& model, const PairLaw& law,
                           const ContactBodies& bodies, const ContactKinematics& now, double dt,
                           ContactHistory& history, Energies&& energies = {});

/// The contact at this instant, without a change to its history.
ContactState contact_state(const scene::ContactModel& model, const PairLaw& law,
                           const ContactBodies& bodies, const ContactKinematics& now,
                           const ContactHistory& history);

/// Area of the circle in which two undeformed spheres, or a sphere and a plane, intersect, m^2.
double cohesion_area(double r_eff, double overlap, double inv_distance);

}  // namespace repose::dem

#include "repose/dem/detail/contact_law.hpp"

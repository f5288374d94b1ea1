// What contacts store and what they take from the motion.
#pragma once

namespace repose::dem {

/// What a contact stores and what it takes from the motion. Kinetic + potential + stored energy
/// plus the time integral of lost_w() is constant to the order of the time step, if what a contact
/// stored last is counted as lost when it ends. That is not always little: as k_r goes to zero with
/// the overlap, the spring of type C keeps a torque, hence energy, in a kept tail.
struct ContactEnergies {
  double normal_j = 0.0;      ///< (8/15) E* sqrt(R*) d^2.5, and minus the work of cohesion
  double tangential_j = 0.0;  ///< S_t xi^2 / 2
  double rolling_j = 0.0;     ///< M^2 / (2 k_r)
  double normal_damping_w = 0.0;
  double tangential_damping_w = 0.0;
  double sliding_w = 0.0;
  double rolling_w = 0.0;  ///< damping and yielding of the rolling spring, or the torque of type A
  /// Given or taken, of either sign, because S_t and k_r change with the overlap while xi and M
  /// stay: the price of these histories. The springs' errors of first order in dt are in it.
  double stiffness_change_w = 0.0;

  double stored_j() const { return normal_j + tangential_j + rolling_j; }
  double lost_w() const {
    return normal_damping_w + tangential_damping_w + sliding_w + rolling_w + stiffness_change_w;
  }
};

/// Stands for ContactEnergies where nobody asks.
struct NoEnergies {};

}  // namespace repose::dem

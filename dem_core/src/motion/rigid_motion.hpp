// Where a rigid wall is and how it moves.
#pragma once

#include <Eigen/Core>

#include "repose/dem/cross.hpp"

namespace repose::dem {

/// Takes points from where they were drawn to where they are: x -> turn x + shift.
struct Pose {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Vec3 shift = Vec3::Zero();
  bool is_identity = true;  ///< set with the two above, to save the arithmetic of walls at rest

  Vec3 to_world(const Vec3& drawn) const {
    return is_identity ? drawn : Vec3(turn * drawn + shift);
  }
  Vec3 to_drawn(const Vec3& world) const {
    return is_identity ? world : Vec3(turn.transpose() * (world - shift));
  }
  Vec3 direction_to_world(const Vec3& drawn) const {
    return is_identity ? drawn : Vec3(turn * drawn);
  }
};

/// Velocity of a rigid body: that of its point which is now at the origin, and its spin, rad/s.
struct Twist {
  Vec3 velocity = Vec3::Zero();
  Vec3 spin = Vec3::Zero();
  Vec3 at(const Vec3& x) const { return velocity + cross(spin, x); }
};

/// The turn by an angle about a unit axis [Rodrigues' formula].
Eigen::Matrix3d turn_about(const Vec3& axis, double angle);

}  // namespace repose::dem

// Orientation of rigid bodies: unit quaternions and one step of free rotation.
#pragma once

#include <array>
#include <cmath>

#include "repose/dem/contact_law.hpp"

namespace repose::dem {

/// Turns body axes into the world's; of length one.
struct Quaternion {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;
};

inline Quaternion normalised(const Quaternion& q) {
  const double scale = 1.0 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

inline Quaternion quaternion_of(const std::array<double, 4>& wxyz) {
  return normalised({wxyz[0], wxyz[1], wxyz[2], wxyz[3]});
}

inline Eigen::Matrix3d rotation_matrix(const Quaternion& q) {
  Eigen::Matrix3d r;
  r << 1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y - q.w * q.z),
      2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.x * q.y + q.w * q.z),
      1.0 - 2.0 * (q.x * q.x + q.z * q.z), 2.0 * (q.y * q.z - q.w * q.x),
      2.0 * (q.x * q.z - q.w * q.y), 2.0 * (q.y * q.z + q.w * q.x),
      1.0 - 2.0 * (q.x * q.x + q.y * q.y);
  return r;
}

/// Turns a body that no torque acts on for a time dt: its angular momentum (world, kg m^2/s) stays,
/// its orientation follows. Symmetric splitting of the rotational energy into its three axes
/// [Dullweber1997], each part a rotation about a body axis; second order in dt, reversible. The
/// rotations use 4 atan(angle/4) for the angle, which keeps all of that and needs no sine.
Quaternion free_rotation(const Quaternion& q, const Vec3& angular_momentum, const Vec3& inertia,
                         double dt);

/// What a step of free rotation needs of a body.
struct RotatingBody {
  Quaternion q;
  Vec3 l;        ///< angular momentum, world
  Vec3 inertia;  ///< principal moments
};
struct RotationEnd {
  Quaternion q;     ///< after dt
  Quaternion half;  ///< after half of it
  Vec3 spin;        ///< angular velocity there, world
};
inline constexpr std::size_t kRotatingTogether = 4;
/// free_rotation() of several bodies at once, the same bits as one by one.
void free_rotation(const RotatingBody (&bodies)[kRotatingTogether], double dt,
                   RotationEnd (&ends)[kRotatingTogether]);

}  // namespace repose::dem

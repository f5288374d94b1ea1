// The vector product, without the weight of Eigen/Geometry.
#pragma once

#include <Eigen/Core>

namespace repose::dem {

using Vec3 = Eigen::Vector3d;

inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
          a.x() * b.y() - a.y() * b.x()};
}

}  // namespace repose::dem

// The vector product, without the weight of Eigen/Geometry.
#pragma once

#include <Eigen/Core>

namespace repose::scene {

inline Eigen::Vector3d cross(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
          a.x() * b.y() - a.y() * b.x()};
}

}  // namespace repose::scene

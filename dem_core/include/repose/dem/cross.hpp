// Vectors of the engine and their product.
#pragma once

#include "repose/scene/cross.hpp"

namespace repose::dem {

using Vec3 = Eigen::Vector3d;
using scene::cross;

}  // namespace repose::dem

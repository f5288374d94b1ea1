// Smooth patches of a mesh: triangles that make up one surface.
#pragma once

#include <cstdint>
#include <vector>

#include "repose/scene/triangle_mesh.hpp"

namespace repose::dem {

/// For each triangle the number of its patch, from 0: two triangles are of one patch if they share
/// an edge with no third and meet there at no more than `smooth_deg`, whichever way they face, or
/// if a chain of such triangles joins them.
std::vector<std::int32_t> smooth_patches(const scene::TriangleMesh& mesh, double smooth_deg);

}  // namespace repose::dem

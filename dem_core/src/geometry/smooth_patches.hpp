// Smooth patches: facets that make up one surface.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/facet.hpp"
#include "repose/scene/triangle_mesh.hpp"

namespace repose::dem {

/// For each triangle the number of its patch, from 0: two triangles are of one patch if they share
/// an edge with no third and meet there at no more than `smooth_deg`, whichever way they face, or
/// if a chain of such triangles joins them.
std::vector<std::int32_t> smooth_patches(const scene::TriangleMesh& mesh, double smooth_deg);

/// Whether two primitives are pieces of one smooth surface: they lie in one plane, or they are
/// sections about one axis of which one begins where the other ends, in the same direction.
bool are_one_surface(const Facet& a, const Facet& b);

}  // namespace repose::dem

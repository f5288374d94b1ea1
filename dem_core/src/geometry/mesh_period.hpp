// Meshes in a periodic domain.
#pragma once

#include <string>

#include "repose/scene/case.hpp"
#include "repose/scene/triangle_mesh.hpp"

namespace repose::dem {

/// Throws InputError unless the mesh of a wall lies within each period, or spans it and is cut
/// alike at its two ends, to 1e-5 of the mesh's size: then it goes on as its images do. Cost n for
/// n triangles, and m^2 for m of them at an end of the period that the mesh spans.
void require_periodic(const scene::Case& scene, const std::string& wall,
                      const scene::LoadedMesh& mesh);

}  // namespace repose::dem

// Triangles that are no surface: without area, or the same as another.
#pragma once

#include "repose/scene/triangle_mesh.hpp"

namespace repose::scene {

struct DegenerateTriangles {
  MeshFinding zero_area;   ///< no higher over their longest side than the distance of welding
  MeshFinding duplicates;  ///< with the corners of an earlier one, in whatever order
};

/// Takes them out of the mesh; returns what was there.
DegenerateTriangles drop_degenerate(TriangleMesh& mesh);
/// The same without a change.
DegenerateTriangles find_degenerate(const TriangleMesh& mesh);

}  // namespace repose::scene

// STL files and triangles made in code, for tests of meshes.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "repose/scene/triangle_mesh.hpp"

namespace repose::scene {

/// The triangles of an axis-parallel box, facing outwards: 2 n^2 for each face.
inline std::vector<Triangle> box_triangles(const Vec3& lower, const Vec3& upper, int n = 1) {
  std::vector<Triangle> triangles;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2;
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const auto at = [&](int a, int b) {
      Vec3 x = lower;
      if (face % 2 == 1) x[axis] = upper[axis];
      x[u] = a == n ? upper[u] : lower[u] + (upper[u] - lower[u]) * a / n;
      x[v] = b == n ? upper[v] : lower[v] + (upper[v] - lower[v]) * b / n;
      return x;
    };
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        Triangle first{at(a, b), at(a + 1, b), at(a + 1, b + 1)};
        Triangle second{at(a, b), at(a + 1, b + 1), at(a, b + 1)};
        if (face % 2 == 0) {
          std::swap(first[1], first[2]);
          std::swap(second[1], second[2]);
        }
        triangles.push_back(first);
        triangles.push_back(second);
      }
  }
  return triangles;
}

/// ASCII with the given end of line; coordinates with 17 digits.
inline std::string ascii_stl(const std::vector<Triangle>& triangles,
                             const std::string& eol = "\n") {
  std::string text = "solid made by a test" + eol;
  char line[200];
  for (const Triangle& t : triangles) {
    text += "  facet normal 0 0 0" + eol + "    outer loop" + eol;
    for (const Vec3& x : t) {
      std::snprintf(line, sizeof line, "      vertex %.17g %.17g %.17g", x.x(), x.y(), x.z());
      text += line + eol;
    }
    text += "    endloop" + eol + "  endfacet" + eol;
  }
  return text + "endsolid made by a test" + eol;
}

/// Binary, in single precision.
inline std::string binary_stl(const std::vector<Triangle>& triangles,
                              const std::string& comment = "made by a test") {
  std::string bytes = comment;
  bytes.resize(80, '\0');
  const auto count = static_cast<std::uint32_t>(triangles.size());
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (const Triangle& t : triangles) {
    float values[12] = {};
    for (std::size_t k = 0; k < 3; ++k)
      for (int c = 0; c < 3; ++c)
        values[3 + 3 * k + static_cast<std::size_t>(c)] = static_cast<float>(t[k][c]);
    bytes.append(reinterpret_cast<const char*>(values), sizeof values);
    bytes.append(2, '\0');
  }
  return bytes;
}

}  // namespace repose::scene

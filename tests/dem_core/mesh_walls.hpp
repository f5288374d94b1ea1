// Walls from triangles made in code, for tests of the engine.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "../libscene/mesh_files.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "small_cases.hpp"

namespace repose::dem {

/// A wall of "wall" from triangles, by way of an STL file in the folder of the test's program.
inline scene::Wall mesh_wall(const std::string& name,
                             const std::vector<scene::Triangle>& triangles) {
  static const struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("repose_meshes_" + std::to_string(::getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
  } folder;
  static int files = 0;
  const std::filesystem::path file = folder.path / (std::to_string(files++) + ".stl");
  write_file_atomically(file, scene::ascii_stl(triangles));
  return {name, "wall", scene::Mesh{.file = file, .open = true}};
}

inline scene::Wall cone_wall(const std::string& name, const Vec3& start, const Vec3& end,
                             double start_radius, double end_radius) {
  return {name, "wall", scene::Cone{start, end, start_radius, end_radius}};
}

/// The side of a frustum about the z axis from z0 to z1: `around` strips with corners on the
/// surface, each cut into `along` pieces.
inline std::vector<scene::Triangle> frustum_triangles(double z0, double z1, double r0, double r1,
                                                      int around, int along) {
  const auto at = [&](int a, int b) {
    const double angle = 2.0 * std::numbers::pi * (a % around) / around;
    const double t = static_cast<double>(b) / along;
    const double r = r0 + t * (r1 - r0);
    return Vec3(r * std::cos(angle), r * std::sin(angle), z0 + t * (z1 - z0));
  };
  std::vector<scene::Triangle> triangles;
  for (int a = 0; a < around; ++a)
    for (int b = 0; b < along; ++b) {
      triangles.push_back({at(a, b), at(a + 1, b), at(a + 1, b + 1)});
      triangles.push_back({at(a, b), at(a + 1, b + 1), at(a, b + 1)});
    }
  return triangles;
}

/// The rectangle [x0, x1] x [y0, y1] at z = 0 in n m squares of two triangles; inner corners are
/// moved at random by up to `disorder` of a square.
inline std::vector<scene::Triangle> floor_triangles(double x0, double x1, double y0, double y1,
                                                    int n, int m, double disorder = 0.0) {
  const auto at = [&](int a, int b) {
    RandomStream random(77, static_cast<std::uint64_t>(a * (m + 1) + b));
    const bool inner = a > 0 && a < n && b > 0 && b < m;
    const double da = inner ? disorder * random.uniform(-1, 1) : 0.0;
    const double db = inner ? disorder * random.uniform(-1, 1) : 0.0;
    return Vec3(x0 + (x1 - x0) * (a + da) / n, y0 + (y1 - y0) * (b + db) / m, 0.0);
  };
  std::vector<scene::Triangle> triangles;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < m; ++b) {
      triangles.push_back({at(a, b), at(a + 1, b), at(a + 1, b + 1)});
      triangles.push_back({at(a, b), at(a + 1, b + 1), at(a, b + 1)});
    }
  return triangles;
}

}  // namespace repose::dem

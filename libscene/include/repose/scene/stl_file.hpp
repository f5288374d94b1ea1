// Triangles from STL files.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "repose/scene/grains.hpp"

namespace repose::scene {

/// Corners of a triangle in the order of the file, counter-clockwise seen from outside.
using Triangle = std::array<Vec3, 3>;

/// All triangles of an STL file, ASCII (any number of solids) or binary, in the units of the file.
/// The normals that the file states are read and ignored: corners define them. A binary file is
/// known by its size, so one that begins with "solid" is read as what it is. Throws InputError
/// with the line or the triangle where the file is damaged: a wrong count, a missing end, a
/// coordinate that is no number or beyond 1e30; StorageError if it cannot be read.
std::vector<Triangle> read_stl(const std::filesystem::path& path);
/// The same from the bytes of a file; `name` stands for it in messages.
std::vector<Triangle> parse_stl(std::string_view bytes, const std::string& name);

}  // namespace repose::scene

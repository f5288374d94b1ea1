// Files that a case names: meshes and particle tables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace repose::scene {

/// The bytes of a file that a case names. Throws StorageError if it cannot be read, InputError if
/// `content_hash` is not 0 and differs from that of the bytes: the file changed since the case was
/// read.
std::string read_input_file(const std::filesystem::path& path, std::uint64_t content_hash);

}  // namespace repose::scene

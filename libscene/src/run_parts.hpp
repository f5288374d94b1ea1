// The files of which a run folder consists while the run is under way.
#pragma once

#include <filesystem>

namespace repose::scene {

/// Throws StorageError unless the file is there.
void require_part(const std::filesystem::path& file);
/// False if there was none. Throws StorageError if it cannot be removed.
bool remove_part(const std::filesystem::path& file);
/// The same for a folder and all in it, which need not be there.
void remove_tree(const std::filesystem::path& path);
/// Removes files of this folder that a killed process had begun to write (see temporary_beside()).
/// Throws StorageError.
void remove_unfinished(const std::filesystem::path& folder);

}  // namespace repose::scene

// Files that are either written whole or not at all.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace repose {

/// The whole file as text. Throws StorageError with the reason of the operating system.
std::string read_file(const std::filesystem::path& path);

/// Writes `text` beside `path`, flushes it to disk and renames it onto `path`: after a crash at any
/// instant `path` holds either its old content or the new one. Throws StorageError.
void write_file_atomically(const std::filesystem::path& path, std::string_view text);

/// A name beside `path` that no other process or thread uses, for a file to be renamed onto it.
std::filesystem::path temporary_beside(const std::filesystem::path& path);

/// Flushes the finished file `temporary` to disk and renames it onto `path`. Throws StorageError;
/// `temporary` is removed then.
void commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// Creates a directory and its parents. Throws StorageError.
void make_directory(const std::filesystem::path& path);

}  // namespace repose

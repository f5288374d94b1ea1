// One campaign at a time in a directory, and who it is.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace repose::dem_adapter {

/// Held until destroyed or until the process ends in whatever way: the lock of a dead owner does
/// not block.
class DirectoryLock {
 public:
  /// Throws StorageError if the directory cannot be written or another process has it, naming it.
  explicit DirectoryLock(const std::filesystem::path& directory);
  ~DirectoryLock();
  DirectoryLock(const DirectoryLock&) = delete;
  DirectoryLock& operator=(const DirectoryLock&) = delete;

  /// "process 1234 on HOST" if somebody holds it.
  static std::optional<std::string> owner(const std::filesystem::path& directory);

 private:
  int lock_ = -1;
};

}  // namespace repose::dem_adapter

// One writer of a file at a time.
#pragma once

#include <filesystem>

namespace repose::table {

/// Held while a file is replaced: an advisory lock (flock) on `.NAME.lock` beside it, which is
/// removed afterwards and given back by the system if the process dies. Readers take no lock. Where
/// the file system has no locks (some network ones) nothing is locked.
class WriterLock {
 public:
  /// Throws StorageError if another process or thread holds it, or the folder cannot be written.
  explicit WriterLock(const std::filesystem::path& file);
  ~WriterLock();
  WriterLock(const WriterLock&) = delete;
  WriterLock& operator=(const WriterLock&) = delete;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
};

}  // namespace repose::table

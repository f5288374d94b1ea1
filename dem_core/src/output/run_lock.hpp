// One process at a time in a run folder.
#pragma once

#include <filesystem>

namespace repose::dem {

/// Holds RUN_DIR/.running, locked, while it lives; a process that is killed lets go of it.
class RunLock {
 public:
  /// Creates the folder. Throws StorageError if another process runs there and goes on for two
  /// seconds: one that was killed may take a moment to end.
  explicit RunLock(const std::filesystem::path& run_dir);
  ~RunLock();
  RunLock(const RunLock&) = delete;
  RunLock& operator=(const RunLock&) = delete;
  const std::filesystem::path& file() const { return file_; }

 private:
  enum class Attempt { early, last };
  /// Locks the open file, or closes it. Throws StorageError if another process holds it to the
  /// last.
  bool take(Attempt attempt);

  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace repose::dem

#include "output/run_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"

namespace repose::dem {
namespace {

constexpr auto kPatience = std::chrono::seconds(2);
constexpr auto kPoll = std::chrono::milliseconds(20);

/// Whether the locked file is still the one of this name: its last holder may have removed it.
bool is_current(int descriptor, const std::filesystem::path& file) {
  struct stat locked {};
  struct stat named {};
  return ::fstat(descriptor, &locked) == 0 && ::stat(file.c_str(), &named) == 0 &&
         locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
}

}  // namespace

RunLock::RunLock(const std::filesystem::path& run_dir) : file_(run_dir / ".running") {
  const auto begin = std::chrono::steady_clock::now();
  for (;;) {
    make_directory(run_dir);
    const bool is_late = std::chrono::steady_clock::now() - begin >= kPatience;
    descriptor_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    const bool is_gone = descriptor_ < 0 && errno == ENOENT;  // its last holder removed the folder
    if (descriptor_ < 0 && (is_late || !is_gone))
      throw StorageError("cannot write in '" + run_dir.string() + "': " + std::strerror(errno));
    if (!is_gone && take(is_late ? Attempt::last : Attempt::early)) return;
    std::this_thread::sleep_for(kPoll);
  }
}

bool RunLock::take(Attempt attempt) {
  const bool is_locked = ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0;
  const bool is_held = !is_locked && errno == EWOULDBLOCK;
  // Where a file system knows no locks, the run goes without; and where a file has another number
  // by its name than by its descriptor, as may be over a network, nothing tells whether it is
  // current.
  if (!is_held && (!is_locked || attempt == Attempt::last || is_current(descriptor_, file_)))
    return true;
  ::close(descriptor_);
  if (attempt == Attempt::last)
    throw StorageError("another process is running in '" + file_.parent_path().string() +
                       "'; wait for it, end it or choose another folder");
  return false;
}

RunLock::~RunLock() {
  ::unlink(file_.c_str());  // before the lock is given back: nobody removes another's
  ::close(descriptor_);
}

}  // namespace repose::dem

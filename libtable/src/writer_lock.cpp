#include "writer_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "repose/base/error.hpp"

namespace repose::table {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, int code) {
  const std::filesystem::path folder = file.parent_path();
  throw StorageError(
      code == ENOENT
          ? fmt::format("cannot write {}: there is no directory {}", file.string(), folder.string())
          : fmt::format("cannot write {}: {}", file.string(), std::strerror(code)));
}

/// Whether the locked file is still the one that `path` names: its last holder may have removed it.
bool is_current(int descriptor, const std::filesystem::path& path) {
  struct stat locked {};
  struct stat named {};
  return ::fstat(descriptor, &locked) == 0 && ::stat(path.c_str(), &named) == 0 &&
         locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
}

bool has_no_locks(int code) {
  return code == ENOLCK || code == ENOSYS || code == EOPNOTSUPP || code == EINVAL;
}

}  // namespace

WriterLock::WriterLock(const std::filesystem::path& file)
    : path_(file.parent_path() / fmt::format(".{}.lock", file.filename().string())) {
  for (;;) {
    descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) refuse(file, errno);
    int result = 0;
    do {
      result = ::flock(descriptor_, LOCK_EX | LOCK_NB);
    } while (result != 0 && errno == EINTR);
    const int code = errno;
    if (result != 0 && has_no_locks(code)) return;
    if (result == 0 && is_current(descriptor_, path_)) return;
    ::close(descriptor_);
    if (result == 0) continue;
    if (code != EWOULDBLOCK) refuse(file, code);
    throw StorageError(
        fmt::format("cannot write {}: another process or thread is writing it; try again when it "
                    "is done",
                    file.string()));
  }
}

WriterLock::~WriterLock() {
  ::unlink(path_.c_str());  // before the lock is given back: nobody removes another's
  ::close(descriptor_);
}

}  // namespace repose::table

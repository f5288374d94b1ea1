#include "directory_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"

namespace repose::dem_adapter {
namespace {

constexpr auto kPatience = std::chrono::seconds(2);

std::filesystem::path file_of(const std::filesystem::path& directory) {
  return directory / ".lock";
}

std::string host_name() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return host.data();
}

struct Owner {
  std::string text;  ///< "process 1234 on HOST"
  /// A process that it had just forked may hold the lock for an instant longer.
  bool is_dead = false;
};

Owner owner_named_in(int lock) {
  std::array<char, 512> text{};
  const ssize_t n = ::pread(lock, text.data(), text.size() - 1, 0);
  Owner owner{.text = std::string(text.data(), n > 0 ? static_cast<std::size_t>(n) : 0)};
  owner.text.erase(owner.text.find_last_not_of('\n') + 1);
  int process = 0;
  if (std::sscanf(owner.text.c_str(), "process %d on ", &process) == 1 &&
      owner.text.ends_with(" on " + host_name()))
    owner.is_dead = ::kill(process, 0) != 0 && errno == ESRCH;
  if (owner.text.empty()) owner.text = "another process";
  return owner;
}

/// Whether the lock was taken; waits only for one whose owner is dead.
bool take(int lock) {
  const auto begin = std::chrono::steady_clock::now();
  while (::flock(lock, LOCK_EX | LOCK_NB) != 0) {
    const int code = errno;
    const bool is_late = std::chrono::steady_clock::now() - begin > kPatience;
    errno = code;
    if (code != EINTR && (code != EWOULDBLOCK || is_late || !owner_named_in(lock).is_dead)) {
      errno = code;
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace

DirectoryLock::DirectoryLock(const std::filesystem::path& directory) {
  make_directory(directory);
  const auto file = file_of(directory);
  lock_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock_ < 0)
    throw StorageError(
        fmt::format("cannot write in '{}': {}", directory.string(), std::strerror(errno)));
  if (!take(lock_)) {
    const int code = errno;
    const auto owner = owner_named_in(lock_);
    ::close(lock_);
    throw StorageError(
        code == EWOULDBLOCK
            ? fmt::format("{} is working in '{}'; wait for it, end it or choose another directory",
                          owner.text, directory.string())
            : fmt::format("cannot lock '{}': {}", file.string(), std::strerror(code)));
  }
  const auto name = fmt::format("process {} on {}\n", ::getpid(),
                                host_name());  // only for messages: a full disk does not matter
  static_cast<void>(!::ftruncate(lock_, 0));
  static_cast<void>(!::pwrite(lock_, name.data(), name.size(), 0));
}

DirectoryLock::~DirectoryLock() {
  ::close(lock_);
}

std::optional<std::string> DirectoryLock::owner(const std::filesystem::path& directory) {
  const int lock = ::open(file_of(directory).c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) return std::nullopt;
  std::optional<std::string> owner;
  if (::flock(lock, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    if (const auto named = owner_named_in(lock); !named.is_dead) owner = named.text;
  ::close(lock);
  return owner;
}

}  // namespace repose::dem_adapter

#include "repose/base/file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>

#include "repose/base/error.hpp"

namespace repose {
namespace {

[[noreturn]] void storage_error(const std::filesystem::path& path, const char* action) {
  const int code = errno;
  throw StorageError(fmt::format("cannot {} '{}': {}", action, path.string(), std::strerror(code)));
}

/// A file descriptor that closes itself.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags, mode_t mode = 0)
      : value_(::open(path.c_str(), flags | O_CLOEXEC, mode)) {}
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  bool valid() const { return value_ >= 0; }
  int get() const { return value_; }

 private:
  int value_;
};

std::filesystem::path parent_of(const std::filesystem::path& path) {
  const auto parent = path.parent_path();
  return parent.empty() ? std::filesystem::path(".") : parent;
}

}  // namespace

std::string read_file(const std::filesystem::path& path) {
  const Descriptor file(path, O_RDONLY);
  if (!file.valid()) storage_error(path, "read");
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) storage_error(path, "read");
  if (S_ISDIR(status.st_mode))
    throw StorageError(fmt::format("cannot read '{}': it is a directory", path.string()));
  std::string text;
  char buffer[65536];
  for (;;) {
    const ssize_t n = ::read(file.get(), buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) storage_error(path, "read");
    if (n == 0) return text;
    text.append(buffer, static_cast<std::size_t>(n));
  }
}

std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  static std::atomic<unsigned> counter{0};
  return parent_of(path) /
         fmt::format(".{}.{}.{}.tmp", path.filename().string(), ::getpid(), counter++);
}

void commit_file(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  const auto give_up = [&](const char* action) {
    const int code = errno;
    ::unlink(temporary.c_str());
    errno = code;
    storage_error(path, action);
  };
  {
    const Descriptor file(temporary, O_RDONLY);
    if (!file.valid() || ::fsync(file.get()) != 0) give_up("flush to disk");
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) give_up("write");
  const Descriptor directory(parent_of(path), O_RDONLY | O_DIRECTORY);
  if (directory.valid())
    ::fsync(directory.get());  // some file systems refuse this; the data is safe
}

void write_file_atomically(const std::filesystem::path& path, std::string_view text) {
  const auto temporary = temporary_beside(path);
  {
    const Descriptor file(temporary, O_WRONLY | O_CREAT | O_TRUNC, 0644);
    if (!file.valid()) storage_error(path, "write");
    for (std::size_t done = 0; done < text.size();) {
      const ssize_t n = ::write(file.get(), text.data() + done, text.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) {
        const int code = errno;
        ::unlink(temporary.c_str());
        errno = code;
        storage_error(path, "write");
      }
      done += static_cast<std::size_t>(n);
    }
  }
  commit_file(temporary, path);
}

void make_directory(const std::filesystem::path& path) {
  std::error_code code;
  std::filesystem::create_directories(path, code);
  if (code || !std::filesystem::is_directory(path))
    throw StorageError(
        fmt::format("cannot create the directory '{}': {}", path.string(),
                    code ? code.message() : std::string("a file of this name is in the way")));
}

}  // namespace repose

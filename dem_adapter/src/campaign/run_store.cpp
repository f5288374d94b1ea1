#include "repose/dem_adapter/run_store.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "outcome_json.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/submission.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void storage_error(const fs::path& path, const char* action, int code) {
  throw StorageError(fmt::format("cannot {} '{}': {}", action, path.string(), std::strerror(code)));
}

fs::path index_file(const fs::path& directory) {
  return directory / "index.jsonl";
}

/// A lock on an open file for as long as it lives; none where the file system has no locks.
class ShortLock {
 public:
  explicit ShortLock(int descriptor) : descriptor_(descriptor) {
    while (::flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) continue;
  }
  ~ShortLock() { ::flock(descriptor_, LOCK_UN); }
  ShortLock(const ShortLock&) = delete;
  ShortLock& operator=(const ShortLock&) = delete;

 private:
  int descriptor_;
};

/// 0 or what went wrong.
int write_at_end(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(descriptor, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return 0;
}

}  // namespace

std::string run_key(const std::string& engine, const std::string& case_text) {
  return fmt::format("{:016x}", content_hash(engine + '\n' + case_text));
}

RunStore::RunStore(fs::path directory, StoreAccess access)
    : directory_(std::move(directory)), access_(access) {
  if (access_ == StoreAccess::write)
    make_directory(directory_ / "runs");
  else if (!fs::is_directory(directory_ / "runs"))
    throw StorageError(fmt::format(
        "'{}' holds no runs; name the folder of a campaign or calibration", directory_.string()));
  try {
    open_index();
    read_index();
    look_into_folders();
  } catch (...) {
    if (index_ >= 0) ::close(index_);
    throw;
  }
}

RunStore::~RunStore() {
  if (index_ >= 0) ::close(index_);
}

void RunStore::open_index() const {
  const auto file = index_file(directory_);
  const bool writes = access_ == StoreAccess::write;
  const int index = ::open(
      file.c_str(), writes ? O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC : O_RDONLY | O_CLOEXEC, 0644);
  if (index < 0 && (writes || errno != ENOENT))
    storage_error(file, writes ? "write" : "read", errno);
  if (index_ >= 0) ::close(index_);
  index_ = index;
}

/// Not if another process has written a shorter one in its place.
bool RunStore::is_current_index() const {
  struct stat ours {
  }, there{};
  return ::fstat(index_, &ours) == 0 && ::stat(index_file(directory_).c_str(), &there) == 0 &&
         ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
}

void RunStore::read_index() const {
  if (index_ < 0) return;
  std::ifstream in(fmt::format("/proc/self/fd/{}", index_), std::ios::binary);
  std::int64_t offset = 0;
  for (std::string line; std::getline(in, line);) {
    const auto length = static_cast<std::int64_t>(line.size());
    const auto head = head_of(line);
    if (head.is_forgotten)
      places_.erase(head.key);
    else if (!head.key.empty())
      places_[head.key] = {.offset = offset, .length = length};
    offset += length + 1;
  }
}

/// Takes in runs that the index lacks, whose process died before it had written there, or that
/// somebody copied here, and leaves out those whose folder is gone. What cannot be read is told
/// when that run is wanted.
void RunStore::look_into_folders() {
  std::map<std::string, Place> there;
  for (const auto& entry : fs::directory_iterator(directory_ / "runs")) {
    const auto key = entry.path().filename().string();
    if (const auto known = places_.find(key); known != places_.end())
      there.insert(*known);
    else if (fs::exists(entry.path() / "outcome.json"))
      there[key] = {};
  }
  places_ = std::move(there);
  if (access_ == StoreAccess::read) return;
  std::vector<std::string> lacking;
  for (const auto& [key, place] : places_)
    if (place.offset < 0) lacking.push_back(key);
  for (const auto& key : lacking) {
    try {
      if (const auto outcome = read_folder(key)) append(key, outcome_line(*outcome));
    } catch (const StorageError&) {
      places_.erase(key);
    }
  }
}

std::optional<RunOutcome> RunStore::read_folder(const std::string& key) const {
  const auto file = folder(key) / "outcome.json";
  if (!fs::exists(file)) return std::nullopt;
  std::string reason = "it is of another run";
  try {
    auto outcome = parse_outcome(read_file(file));
    if (outcome.key == key) return outcome;
  } catch (const nlohmann::json::exception& error) {
    reason = error.what();
  } catch (const InputError& error) {
    reason = error.what();
  }
  throw StorageError(fmt::format(
      "'{}' is damaged ({}); remove that file to have the run done again", file.string(), reason));
}

std::optional<RunOutcome> RunStore::find(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto it = places_.find(key);
  if (it != places_.end() && it->second.offset >= 0) {
    std::string line(static_cast<std::size_t>(it->second.length), '\0');
    if (::pread(index_, line.data(), line.size(), it->second.offset) ==
        static_cast<ssize_t>(line.size())) {
      try {
        auto outcome = parse_outcome(line);
        if (outcome.key == key) return outcome;
      } catch (const nlohmann::json::exception&) {  // the folder has it whole
      } catch (const InputError&) {
      }
    }
  }
  auto outcome = read_folder(key);
  if (outcome)
    places_.try_emplace(key);
  else
    places_.erase(key);
  return outcome;
}

std::optional<RunOutcome> RunStore::find_in_folder(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  places_.erase(key);
  auto outcome = read_folder(key);
  if (outcome) places_.try_emplace(key);
  return outcome;
}

/// One write under a lock, on a line of its own whatever a process that died left behind.
void RunStore::append(const std::string& key, const std::string& line) const {
  REPOSE_ASSERT(access_ == StoreAccess::write, "the store was opened for reading");
  auto lock = std::make_unique<ShortLock>(index_);
  while (!is_current_index()) {  // it was compacted, or somebody deleted it
    lock.reset();
    open_index();
    places_.clear();
    read_index();
    lock = std::make_unique<ShortLock>(index_);
  }
  struct stat status {};
  if (::fstat(index_, &status) != 0) storage_error(index_file(directory_), "read", errno);
  char last = '\n';
  if (status.st_size > 0 && ::pread(index_, &last, 1, status.st_size - 1) != 1)
    storage_error(index_file(directory_), "read", errno);
  const std::string begin = last == '\n' ? "" : "\n";
  if (const int code = write_at_end(index_, begin + line + "\n"); code != 0) {
    static_cast<void>(!::ftruncate(index_, status.st_size));
    storage_error(index_file(directory_), "write", code);
  }
  places_[key] = {.offset = status.st_size + static_cast<std::int64_t>(begin.size()),
                  .length = static_cast<std::int64_t>(line.size())};
}

void RunStore::record(const RunOutcome& outcome) const {
  write_file_atomically(folder(outcome.key) / "outcome.json", outcome_text(outcome));
  const std::lock_guard lock(mutex_);
  append(outcome.key, outcome_line(outcome));
}

/// The index first: if we die in between, the run still has its outcome, in its folder.
void RunStore::forget(const std::string& key) const {
  forget_submission(folder(key));  // else its job would be taken for one that is still to be done
  const std::lock_guard lock(mutex_);
  append(key, forgotten_line(key));
  places_.erase(key);
  if (::fdatasync(index_) != 0) storage_error(index_file(directory_), "flush to disk", errno);
  const auto file = folder(key) / "outcome.json";
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) storage_error(file, "remove", errno);
}

std::size_t RunStore::size() const {
  const std::lock_guard lock(mutex_);
  return places_.size();
}

std::vector<std::string> RunStore::keys() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> keys;
  for (const auto& [key, place] : places_) keys.push_back(key);
  return keys;
}

std::vector<std::string> RunStore::unfinished() const {
  std::vector<std::string> result;
  for (const auto& entry : fs::directory_iterator(directory_ / "runs")) {
    const auto key = entry.path().filename().string();
    const std::lock_guard lock(mutex_);
    if (entry.is_directory() && places_.count(key) == 0) result.push_back(key);
  }
  std::sort(result.begin(), result.end());
  return result;
}

/// Another process that wants to write waits, and then sees that the index is another file.
void RunStore::compact_index() const {
  const ShortLock lock(index_);
  std::string text;
  for (const auto& key : keys())
    if (const auto outcome = find_in_folder(key)) text += outcome_line(*outcome) + '\n';
  write_file_atomically(index_file(directory_), text);
}

std::optional<RunClaim> RunClaim::take(const fs::path& folder,
                                       const std::function<bool()>& given_up) {
  make_directory(folder);
  const auto file = folder / ".claim";
  const int lock = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock < 0) storage_error(file, "write", errno);
  RunClaim claim(lock);
  while (::flock(lock, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK && errno != EINTR) break;  // no locks here: the engine has its own
    if (given_up()) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return claim;
}

bool RunClaim::is_taken(const fs::path& folder) {
  const int lock = ::open((folder / ".claim").c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) return false;
  const bool is_free = ::flock(lock, LOCK_SH | LOCK_NB) == 0 || errno != EWOULDBLOCK;
  ::close(lock);
  return !is_free;
}

RunClaim::RunClaim(RunClaim&& other) noexcept : lock_(std::exchange(other.lock_, -1)) {}

RunClaim::~RunClaim() {
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace repose::dem_adapter

#include "programs.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <initializer_list>
#include <sstream>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

bool is_executable(const std::filesystem::path& path) {
  return ::access(path.c_str(), X_OK) == 0 && !std::filesystem::is_directory(path);
}

/// The last line that says something, for the reason of a failure.
std::string last_line(const std::filesystem::path& log, std::size_t from) {
  if (log.empty()) return "see its message above";
  std::istringstream text(read_file(log).substr(from));
  std::string last;
  for (std::string line; std::getline(text, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  constexpr std::size_t kLongest = 400;
  return last.size() > kLongest ? last.substr(0, kLongest) + "..." : last;
}

/// The signal that ended the program, or one of its processes: a launcher or a shell says so by the
/// code 128 + signal.
int signal_of(const CommandEnd& end) {
  return end.signal != 0 ? end.signal : end.exit_code - 128;
}

bool is_one_of(int signal, std::initializer_list<int> signals) {
  return std::find(signals.begin(), signals.end(), signal) != signals.end();
}

/// Whether it ended by a fault of its own.
bool crashed(const CommandEnd& end) {
  return end.signal != 0 || is_one_of(signal_of(end), {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL});
}

}  // namespace

std::filesystem::path find_program(const std::string& name, const std::string& remedy) {
  std::error_code code;
  const auto own = std::filesystem::read_symlink("/proc/self/exe", code);
  if (!code && is_executable(own.parent_path() / name)) return own.parent_path() / name;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty() && is_executable(std::filesystem::path(folder) / name))
      return std::filesystem::path(folder) / name;
  throw StorageError(
      fmt::format("{} is neither beside this program nor on PATH; {}", name, remedy));
}

void check_executable(const std::filesystem::path& program) {
  if (!is_executable(program))
    throw StorageError(
        fmt::format("the engine {} cannot be run; check the path", program.string()));
}

std::string content_of(const std::filesystem::path& program) {
  return fmt::format("{:016x}", content_hash(read_file(program)));
}

std::size_t size_of(const std::filesystem::path& file) {
  std::error_code code;
  const auto size = std::filesystem::file_size(file, code);
  return code ? 0 : static_cast<std::size_t>(size);
}

bool was_killed(const CommandEnd& end) {
  return is_one_of(signal_of(end), {SIGKILL, SIGTERM, SIGINT, SIGHUP});
}

EngineExit exit_of(const CommandEnd& end, const Command& command, std::size_t said_before) {
  EngineExit exit{.status = EngineStatus::failed, .message = "", .resources = end.resources};
  if (end.exit_code == 0 && end.signal == 0) {
    exit.status = EngineStatus::finished;  // even if it was about to be told to end
  } else if (end.ended == CommandEnded::at_time_limit) {
    exit.status = EngineStatus::timed_out;
    exit.message =
        fmt::format("it exceeded the time limit of {}", duration_text(command.time_limit_s));
  } else if (end.ended == CommandEnded::when_cancelled) {
    exit.status = EngineStatus::cancelled;
    exit.message = "stopped by the user";
  } else if (was_killed(end)) {
    exit.status = EngineStatus::killed;
    exit.message =
        fmt::format("it was killed by signal {}, not by us (out of memory?)", signal_of(end));
  } else if (crashed(end)) {
    exit.failure = Outcome::crash;
    exit.message = fmt::format("the engine crashed with signal {}", signal_of(end));
  } else if (end.exit_code == 127) {
    throw StorageError(fmt::format("{} could not be executed", command.words.front()));
  } else {
    exit.message = last_line(command.log, said_before);
    if (exit.message.empty())
      exit.message = fmt::format("the engine ended with code {}", end.exit_code);
  }
  return exit;
}

}  // namespace repose::dem_adapter

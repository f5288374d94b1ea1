#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/engine.hpp"

namespace repose::dem_adapter {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPoll = std::chrono::milliseconds(5);

bool is_executable(const std::filesystem::path& path) {
  return ::access(path.c_str(), X_OK) == 0 && !std::filesystem::is_directory(path);
}

std::filesystem::path find_program(const std::string& name) {
  std::error_code code;
  const auto own = std::filesystem::read_symlink("/proc/self/exe", code);
  if (!code && is_executable(own.parent_path() / name)) return own.parent_path() / name;
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (!folder.empty() && is_executable(std::filesystem::path(folder) / name))
      return std::filesystem::path(folder) / name;
  throw StorageError(fmt::format(
      "the bundled engine {} is neither beside this program nor on PATH; build or install it",
      name));
}

/// Starts the program with stdout and stderr in a file (inherited if `log` is empty); -1 and errno
/// if that fails. Between fork and exec only async-signal-safe calls are made, since other threads
/// are running.
pid_t start(const std::filesystem::path& program, const std::vector<std::string>& arguments,
            const std::filesystem::path& log) {
  std::vector<char*> argv;
  const std::string name = program.string();
  argv.push_back(const_cast<char*>(name.c_str()));
  for (const auto& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const int out =
      log.empty() ? -1 : ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (!log.empty() && out < 0) return -1;
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(127);  // the parent died before the line above
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO);
    if (out >= 0) {
      ::dup2(out, STDOUT_FILENO);
      ::dup2(out, STDERR_FILENO);
    }
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  const int code = errno;
  if (out >= 0) ::close(out);
  if (child > 0) ::setpgid(child, child);
  errno = code;
  return child;
}

/// The last line of a log that says something, for the reason of a failure.
std::string last_line(const std::filesystem::path& log) {
  if (log.empty()) return "see its message above";
  std::istringstream text(read_file(log));
  std::string last;
  for (std::string line; std::getline(text, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  constexpr std::size_t kLongest = 400;
  return last.size() > kLongest ? last.substr(0, kLongest) + "..." : last;
}

/// A code that says nothing about this run but that no run can succeed: bad input, a full disk, a
/// program that cannot start. The study must stop then, not record failures.
void throw_if_not_the_run(int code, const std::string& message,
                          const std::filesystem::path& program) {
  const auto text = fmt::format("{}: {}", program.filename().string(), message);
  if (code == static_cast<int>(ErrorKind::input)) throw InputError(text);
  if (code == static_cast<int>(ErrorKind::storage)) throw StorageError(text);
  if (code == 127) throw StorageError(fmt::format("{} could not be executed", program.string()));
  if (code == static_cast<int>(ErrorKind::internal) || code == static_cast<int>(ErrorKind::usage))
    throw Error(ErrorKind::internal, text);
}

/// Somebody ended the engine: the machine shutting down, the kernel out of memory, a user. That too
/// says nothing about the run, which is done again when the study goes on.
void throw_if_killed(int status, const std::filesystem::path& program) {
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status) - 128;
  for (const int from_outside : {SIGKILL, SIGTERM, SIGINT, SIGHUP})
    if (signal == from_outside)
      throw SimulationError(
          fmt::format("{} was killed by signal {}, not by us (out of memory? a shutdown?); nothing "
                      "is lost, the same "
                      "command goes on",
                      program.filename().string(), signal));
}

/// Names a build of the engine: two builds may differ in physics under the same version.
std::string content_of(const std::filesystem::path& program) {
  return fmt::format("{:016x}", content_hash(read_file(program)));
}

}  // namespace

BundledEngine::BundledEngine(std::filesystem::path program, double grace_s)
    : program_(program.empty() ? find_program("repose-dem") : std::move(program)),
      grace_s_(grace_s) {
  if (!(grace_s_ >= 0.0))
    throw InputError(fmt::format(
        "the grace of an engine is {} s; give 0 or more, enough for a checkpoint", grace_s_));
  if (!is_executable(program_))
    throw StorageError(
        fmt::format("the engine {} cannot be run; check the path", program_.string()));
  name_ = fmt::format("bundled {} build {}", version(), content_of(program_));
}

std::string BundledEngine::name() const {
  return name_;
}

EngineExit BundledEngine::run(const EngineJob& job) const {
  const bool to_log = job.streams == EngineStreams::to_log;
  const auto log = to_log ? job.directory / "engine.log" : std::filesystem::path();
  const auto began = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
  std::vector<std::string> arguments{(job.directory / "case.toml").string(), "-o",
                                     (job.directory / "output").string()};
  if (to_log) arguments.emplace_back("--quiet");
  const pid_t child = start(program_, arguments, log);
  if (child < 0)
    throw StorageError(fmt::format("cannot start {}: {}", program_.string(), std::strerror(errno)));

  EngineExit result;
  int status = 0;
  double ended_at = -1.0;  // when we asked it to end
  for (;;) {
    const pid_t waited = ::waitpid(child, &status, WNOHANG);
    if (waited == child) break;
    if (waited < 0 && errno != EINTR) {
      result.message = fmt::format("lost track of the engine: {}", std::strerror(errno));
      return result;
    }
    const double now = elapsed();
    if (ended_at < 0.0) {
      const bool cancelled = job.cancelled && job.cancelled();
      const bool late = job.time_limit_s > 0.0 && now > job.time_limit_s;
      if (cancelled || late) {
        result.status = cancelled ? EngineStatus::cancelled : EngineStatus::timed_out;
        ::kill(-child, SIGTERM);
        ended_at = now;
      }
    } else if (now - ended_at > grace_s_) {
      ::kill(-child, SIGKILL);
    }
    std::this_thread::sleep_for(kPoll);
  }
  ::kill(-child, SIGKILL);  // whatever it may have left behind in its group
  result.wall_time_s = elapsed();
  if (ended_at < 0.0 && job.cancelled && job.cancelled())
    result.status = EngineStatus::cancelled;  // both of us were told to stop, the engine was faster
  if (ended_at >= 0.0 || result.status == EngineStatus::cancelled) {
    result.message =
        result.status == EngineStatus::timed_out
            ? fmt::format("it exceeded the time limit of {}", duration_text(job.time_limit_s))
            : "stopped by the user";
  } else if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    result.status = EngineStatus::finished;
  } else {
    throw_if_killed(status, program_);
    if (WIFEXITED(status)) throw_if_not_the_run(WEXITSTATUS(status), last_line(log), program_);
    result.message = WIFEXITED(status)
                         ? last_line(log)
                         : fmt::format("the engine was killed by signal {}", WTERMSIG(status));
    if (result.message.empty())
      result.message = fmt::format("the engine ended with code {}", WEXITSTATUS(status));
  }
  return result;
}

}  // namespace repose::dem_adapter

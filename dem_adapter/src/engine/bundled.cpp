#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
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
      log.empty() ? -1 : ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
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

std::size_t size_of(const std::filesystem::path& file) {
  std::error_code code;
  const auto size = std::filesystem::file_size(file, code);
  return code ? 0 : static_cast<std::size_t>(size);
}

/// The last line that says something from byte `from` of a log, for the reason of a failure.
std::string last_line(const std::filesystem::path& log, std::size_t from) {
  if (log.empty()) return "see its message above";
  std::istringstream text(read_file(log).substr(from));
  std::string last;
  for (std::string line; std::getline(text, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  constexpr std::size_t kLongest = 400;
  return last.size() > kLongest ? last.substr(0, kLongest) + "..." : last;
}

/// The failures of repose-dem that have a name, by what only their messages contain.
Outcome outcome_of(const std::string& message) {
  struct Sign {
    const char* words;
    Outcome outcome;
  };
  static constexpr Sign kSigns[] = {{"left the domain", Outcome::particles_lost},
                                    {"has the position", Outcome::non_finite},
                                    {"raise youngs_modulus_pa", Outcome::unphysical},
                                    {"lower the time step", Outcome::unphysical}};
  for (const auto& sign : kSigns)
    if (message.find(sign.words) != std::string::npos) return sign.outcome;
  return Outcome::engine_failed;
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

/// The signal by which somebody ended the engine, 0 if nobody did: the machine shutting down, the
/// kernel out of memory, a user.
int killed_by(int status) {
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status) - 128;
  for (const int from_outside : {SIGKILL, SIGTERM, SIGINT, SIGHUP})
    if (signal == from_outside) return signal;
  return 0;
}

Resources resources_of(const rusage& usage, double wall_time_s, int ranks) {
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {.wall_time_s = wall_time_s,
          .cpu_time_s = seconds(usage.ru_utime) + seconds(usage.ru_stime),
          .peak_memory_bytes = std::int64_t{1024} * usage.ru_maxrss,
          .ranks = ranks};
}

/// A running engine until it has ended, by itself or told to.
struct Ending {
  int status = 0;
  EngineStatus asked = EngineStatus::finished;  ///< timed_out or cancelled if it was told to end
  rusage usage{};
  double wall_time_s = 0.0;
};

Ending wait_for(pid_t child, const EngineJob& job, double grace_s) {
  const auto began = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
  Ending ending;
  double asked_at = 0.0;
  for (;;) {
    const pid_t waited = ::wait4(child, &ending.status, WNOHANG, &ending.usage);
    if (waited == child) break;
    if (waited < 0 && errno != EINTR)
      throw Error(ErrorKind::internal,
                  fmt::format("lost track of the engine: {}", std::strerror(errno)));
    const double now = elapsed();
    const bool cancelled = job.cancelled && job.cancelled();
    if (ending.asked == EngineStatus::finished) {
      const bool late = job.time_limit_s > 0.0 && now > job.time_limit_s;
      if (cancelled || late) {
        ending.asked = cancelled ? EngineStatus::cancelled : EngineStatus::timed_out;
        ::kill(-child, SIGTERM);
        asked_at = now;
      }
    } else if (now - asked_at > grace_s) {
      ::kill(-child, SIGKILL);
    }
    std::this_thread::sleep_for(kPoll);
  }
  ::kill(-child, SIGKILL);  // whatever it may have left behind in its group
  if (ending.asked == EngineStatus::finished && job.cancelled && job.cancelled() &&
      killed_by(ending.status) != 0)
    ending.asked = EngineStatus::cancelled;  // both of us were told to stop, the engine was faster
  ending.wall_time_s = elapsed();
  return ending;
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
  const auto said_before = size_of(log);
  std::vector<std::string> arguments{(job.directory / "case.toml").string(), "-o",
                                     (job.directory / "output").string()};
  if (to_log) arguments.emplace_back("--quiet");
  if (job.ranks > 1) {
    arguments.emplace_back("--ranks");
    arguments.push_back(std::to_string(job.ranks));
  }
  const pid_t child = start(program_, arguments, log);
  if (child < 0)
    throw StorageError(fmt::format("cannot start {}: {}", program_.string(), std::strerror(errno)));
  const auto ending = wait_for(child, job, grace_s_);
  const int status = ending.status;
  EngineExit result{.status = ending.asked,
                    .message = "",
                    .resources = resources_of(ending.usage, ending.wall_time_s, job.ranks)};
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    result.status = EngineStatus::finished;  // even if it was about to be told to end
  } else if (ending.asked == EngineStatus::timed_out) {
    result.message =
        fmt::format("it exceeded the time limit of {}", duration_text(job.time_limit_s));
  } else if (ending.asked == EngineStatus::cancelled) {
    result.message = "stopped by the user";
  } else if (const int signal = killed_by(status); signal != 0) {
    result.status = EngineStatus::killed;
    result.message = fmt::format("it was killed by signal {}, not by us (out of memory?)", signal);
  } else if (WIFSIGNALED(status)) {
    result.status = EngineStatus::failed;
    result.failure = Outcome::crash;
    result.message = fmt::format("the engine crashed with signal {}", WTERMSIG(status));
  } else {
    result.status = EngineStatus::failed;
    result.message = last_line(log, said_before);
    throw_if_not_the_run(WEXITSTATUS(status), result.message, program_);
    result.failure = outcome_of(result.message);
    if (result.message.empty())
      result.message = fmt::format("the engine ended with code {}", WEXITSTATUS(status));
  }
  return result;
}

}  // namespace repose::dem_adapter

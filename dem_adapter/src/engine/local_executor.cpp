#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "programs.hpp"
#include "repose/base/error.hpp"
#include "repose/dem_adapter/executor.hpp"
#include "repose/dem_adapter/submission.hpp"

namespace repose::dem_adapter {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPoll = std::chrono::milliseconds(5);

/// Starts the program; -1 and errno if that fails. Between fork and exec only async-signal-safe
/// calls are made, since other threads are running.
pid_t start(const Command& command) {
  std::vector<char*> argv;
  for (const auto& word : command.words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const int out = command.log.empty() ? -1
                                      : ::open(command.log.c_str(),
                                               O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (!command.log.empty() && out < 0) return -1;
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
    if (!command.folder.empty() && ::chdir(command.folder.c_str()) != 0) ::_exit(127);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  const int code = errno;
  if (out >= 0) ::close(out);
  if (child > 0) ::setpgid(child, child);
  errno = code;
  return child;
}

Resources resources_of(const rusage& usage, double wall_time_s, int processes) {
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {.wall_time_s = wall_time_s,
          .cpu_time_s = seconds(usage.ru_utime) + seconds(usage.ru_stime),
          .peak_memory_bytes = std::int64_t{1024} * usage.ru_maxrss,
          .ranks = processes};
}

}  // namespace

CommandEnd LocalExecutor::run(const Command& command) const {
  if (const auto place = command.home.empty() ? std::nullopt : submission_of(command.home))
    throw StorageError(fmt::format(
        "the run in '{}' stands in the queue of SLURM; wait for it with [compute] executor = "
        "\"slurm\", or end it (scancel --name={}) and call repose campaign clean",
        command.home.string(), place->array.filename().string()));
  const auto began = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - began).count(); };
  const auto cancelled = [&] { return command.cancelled && command.cancelled(); };
  const pid_t child = start(command);
  if (child < 0)
    throw StorageError(
        fmt::format("cannot start {}: {}", command.words.front(), std::strerror(errno)));
  CommandEnd end;
  rusage usage{};
  int status = 0;
  for (double told_at = 0.0;;) {
    const pid_t waited = ::wait4(child, &status, WNOHANG, &usage);
    if (waited == child) break;
    if (waited < 0 && errno != EINTR)
      throw Error(ErrorKind::internal,
                  fmt::format("lost track of {}: {}", command.words.front(), std::strerror(errno)));
    const double now = elapsed();
    if (end.ended != CommandEnded::by_itself) {
      if (now - told_at > command.grace_s) ::kill(-child, SIGKILL);
    } else if (const bool by_user = cancelled();
               by_user || (command.time_limit_s > 0.0 && now > command.time_limit_s)) {
      end.ended = by_user ? CommandEnded::when_cancelled : CommandEnded::at_time_limit;
      ::kill(-child, SIGTERM);
      told_at = now;
    }
    std::this_thread::sleep_for(kPoll);
  }
  ::kill(-child, SIGKILL);  // whatever it may have left behind in its group
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 0;
  end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (end.ended == CommandEnded::by_itself && was_killed(end) && cancelled())
    end.ended = CommandEnded::when_cancelled;  // both of us were told, it was faster
  end.resources = resources_of(usage, elapsed(), command.processes);
  return end;
}

}  // namespace repose::dem_adapter

#include "parallel/launcher.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

volatile sig_atomic_t launcher = 0;
volatile sig_atomic_t stopped_by = 0;

/// On SIGINT and SIGTERM mpirun ends its ranks by force; others it passes on.
void pass_on(int number) {
  if (number != SIGUSR1) stopped_by = number;
  const int of_ranks = number == SIGUSR1 ? SIGUSR1 : kStopRanks;
  if (launcher != 0) ::kill(static_cast<pid_t>(launcher), of_ranks);
}

/// What mpirun says between rows of dashes is kept to itself; everything else is passed on.
class Messages {
 public:
  void take(const std::string& line) {
    if (line.starts_with("repose-dem:")) {
      fmt::print(stderr, "{}\n", line);
      return;
    }
    if (line.starts_with("----------")) {
      is_inside_ = !is_inside_;
      return;
    }
    if (is_inside_)
      said_ += line + '\n';
    else if (line.find("mpirun") == std::string::npos)
      fmt::print(stderr, "{}\n", line);
    else
      said_ += line + '\n';
  }
  const std::string& said() const { return said_; }

 private:
  bool is_inside_ = false;
  std::string said_;
};

void read_lines(int from, Messages& messages) {
  std::string line;
  std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t n = ::read(from, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    for (ssize_t k = 0; k < n; ++k) {
      const char c = buffer[static_cast<std::size_t>(k)];
      if (c != '\n') {
        line += c;
        continue;
      }
      messages.take(line);
      line.clear();
    }
  }
  if (!line.empty()) messages.take(line);
}

struct DeadRank {
  int rank = 0, signal = 0;
};
/// By the words of mpirun, whose own exit code says less: it is that of any rank.
std::optional<DeadRank> dead_rank(const std::string& said) {
  std::string text;
  for (const char c : said) text += c == '\n' ? ' ' : c;
  static const std::regex pattern(R"(process rank (\d+) .*exited on signal +(\d+))");
  std::smatch match;
  if (!std::regex_search(text, match, pattern)) return std::nullopt;
  return DeadRank{std::stoi(match[1]), std::stoi(match[2])};
}

std::vector<std::string> command_line(int ranks, int argc, char** argv) {
  std::vector<std::string> words{"mpirun",
                                 "--allow-run-as-root",
                                 "--oversubscribe",
                                 "--bind-to",
                                 "none",
                                 "--mca",
                                 "mpi_yield_when_idle",
                                 "1",
                                 "-np",
                                 std::to_string(ranks),
                                 std::filesystem::read_symlink("/proc/self/exe").string()};
  for (int k = 1; k < argc; ++k) words.emplace_back(argv[k]);
  return words;
}

}  // namespace

int launch_ranks(int ranks, int argc, char** argv) {
  const std::vector<std::string> words = command_line(ranks, argc, argv);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  int from_ranks[2];
  if (::pipe2(from_ranks, O_CLOEXEC) != 0)
    throw StorageError(fmt::format("cannot start mpirun: {}", std::strerror(errno)));
  sigset_t ours, before;  // a signal waits until it can be passed on
  ::sigemptyset(&ours);
  for (const int number : {SIGINT, SIGTERM, SIGUSR1}) ::sigaddset(&ours, number);
  ::sigprocmask(SIG_BLOCK, &ours, &before);
  for (const int number : {SIGINT, SIGTERM, SIGUSR1}) ::signal(number, pass_on);
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    for (const int number : {SIGUSR1, kStopRanks}) ::signal(number, SIG_IGN);  // until it listens
    ::sigprocmask(SIG_SETMASK, &before, nullptr);
    ::setpgid(0, 0);  // the terminal's Ctrl-C reaches it through us
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(127);
    const int nothing = ::open("/dev/null", O_RDONLY);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(from_ranks[1], STDERR_FILENO);
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(from_ranks[1]);
  if (child < 0) throw StorageError(fmt::format("cannot start mpirun: {}", std::strerror(errno)));
  launcher = child;
  ::sigprocmask(SIG_SETMASK, &before, nullptr);
  Messages messages;
  read_lines(from_ranks[0], messages);
  ::close(from_ranks[0]);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  launcher = 0;

  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (code == 128 + SIGTERM)
    return 128 + (stopped_by != 0 ? static_cast<int>(stopped_by) : SIGTERM);
  if (code == 127)
    throw StorageError("mpirun could not be started; install openmpi-bin or run with --ranks 1");
  if (const auto dead = dead_rank(messages.said())) {
    fmt::print(
        stderr,
        "repose-dem: rank {} of {} died by signal {}{}; the same command goes on from the last "
        "checkpoint\n",
        dead->rank, ranks, dead->signal,
        dead->signal == SIGKILL ? " (out of memory? ended by somebody?)" : "");
    return 128 + dead->signal;
  }
  if (WIFSIGNALED(status)) {
    fmt::print(stderr,
               "repose-dem: mpirun died by signal {}; the same command goes on from the last "
               "checkpoint\n",
               WTERMSIG(status));
    return code;
  }
  const bool is_ours = code >= 0 && code <= static_cast<int>(ErrorKind::storage);
  if (!is_ours) fmt::print(stderr, "{}", messages.said());
  return is_ours ? code : static_cast<int>(ErrorKind::simulation);
}

}  // namespace repose::dem

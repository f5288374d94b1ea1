// repose-dem as a child process.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

namespace repose::dem {

struct HowToStart {
  /// No file that it writes may become larger, as if the disk were full.
  rlim_t largest_file = RLIM_INFINITY;
  std::filesystem::path messages = "/dev/null";  ///< takes stderr
  std::vector<std::string> options{};
};

inline pid_t start(const std::filesystem::path& case_file, const std::filesystem::path& output,
                   const HowToStart& how = {}) {
  const std::string bin = std::string(REPOSE_BIN) + "/repose-dem";
  std::vector<std::string> words{bin, case_file.string(), "-o", output.string(), "--quiet"};
  words.insert(words.end(), how.options.begin(), how.options.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit limit{how.largest_file, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    if (std::freopen("/dev/null", "w", stdout) == nullptr) ::_exit(126);
    if (std::freopen(how.messages.c_str(), "w", stderr) == nullptr) ::_exit(126);
    ::execv(bin.c_str(), arguments.data());
    ::_exit(127);
  }
  return child;
}

/// Exit code, or minus the number of the signal that ended the child.
inline int end_of(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

inline bool is_running(pid_t child) {
  siginfo_t info{};
  return ::waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         info.si_pid == 0;
}

/// Until the file is there or the program has ended.
inline void wait_for(const std::filesystem::path& file, pid_t child) {
  while (!std::filesystem::exists(file) && is_running(child))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace repose::dem

#include "stop_signal.hpp"

#include <unistd.h>

#include <csignal>
#include <string_view>

namespace repose::cli {
namespace {

using dem_adapter::Stop;

std::atomic<Stop> requested{Stop::no};
std::atomic<bool> may_let_runs_end{false};
static_assert(std::atomic<bool>::is_always_lock_free, "needed inside a signal handler");

void say(std::string_view words) {
  static_cast<void>(!::write(STDERR_FILENO, words.data(), words.size()));
}

void on_signal(int signal) {
  if (signal == SIGINT && may_let_runs_end && requested == Stop::no) {
    requested = Stop::when_runs_end;
    say("\nrepose: no more runs are begun; those under way may end. Ctrl-C again stops them, too; "
        "they go on from a checkpoint later\n");
    return;
  }
  requested = Stop::now;
  say("\nrepose: stopping the runs under way, each writes a checkpoint first\n");
  std::signal(signal, SIG_DFL);
}

}  // namespace

const std::atomic<Stop>& stop_requested(FirstInterrupt first) {
  may_let_runs_end = first == FirstInterrupt::lets_runs_end;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  return requested;
}

}  // namespace repose::cli

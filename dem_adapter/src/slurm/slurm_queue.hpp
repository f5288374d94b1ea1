// The one thread of a SlurmExecutor that speaks with SLURM, for all the threads that wait.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "slurm_commands.hpp"
#include "slurm_files.hpp"

namespace repose::dem_adapter {

class SlurmQueue {
 public:
  SlurmQueue(SlurmOptions options, std::filesystem::path folder);
  CommandEnd run(const Command& command);

 private:
  using Clock = std::chrono::steady_clock;

  /// A run that somebody waits for. `place` is where it stands in the queue, or may stand.
  struct Ticket {
    Command command;
    std::optional<Submission> place;
    double limit_s = 0.0;  ///< with which it was submitted
    Clock::time_point wanted_at = Clock::now();
    std::optional<Clock::time_point> missed_at;  ///< SLURM has not known it since
    bool cancel_sent = false;
    std::atomic<bool> cancel_wanted{false};
    std::condition_variable over;
    std::optional<CommandEnd> end;  ///< this and `error` under mutex_
    std::exception_ptr error;
  };
  using Tickets = std::vector<std::shared_ptr<Ticket>>;

  void work(const std::stop_token& stop);
  void step(const Tickets& tickets);
  void submit_waiting(const Tickets& tickets);
  void submit_array(const Tickets& batch, const TaskNeeds& needs);
  void collect(const Tickets& tickets);
  void take_end(Ticket& ticket);
  void compare_with_queue(const Tickets& tickets);
  void judge_missing(Ticket& ticket, const ArrayFiles& files);
  void cancel(const Tickets& tickets);
  const std::string& content_of(const Command& command);
  void warn_of_reason(const QueuedTask& task);
  void silent(const std::string& client, const std::string& said);
  void answered();

  static bool is_open(const Ticket& ticket) { return !ticket.end && !ticket.error; }
  void finish(Ticket& ticket, CommandEnd end);
  void fail(Ticket& ticket, std::exception_ptr error);

  SlurmOptions options_;
  std::filesystem::path folder_;
  std::size_t array_limit_;
  bool is_swept_ = false;
  std::stop_token stop_;
  Clock::time_point submit_again_{}, ask_again_{}, warn_again_{};
  std::optional<Clock::time_point> silent_since_;
  std::set<std::string> reasons_told_;
  std::map<std::filesystem::path, std::string> contents_;  ///< of programs

  std::mutex mutex_;
  std::condition_variable_any wanted_;
  std::list<std::shared_ptr<Ticket>> tickets_;
  std::jthread thread_;  // the last member: it uses the others
};

}  // namespace repose::dem_adapter

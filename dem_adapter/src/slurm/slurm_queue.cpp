#include "slurm_queue.hpp"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr auto kStep = 200ms;                // between looks at the files of arrays
constexpr auto kSignalStep = 100ms;          // between questions whether a run is given up
constexpr std::size_t kLargestArray = 1000;  // SLURM's default MaxArraySize is 1001
constexpr double kFullQueueFactor = 6.0;     // so much longer than between two looks at the queue
constexpr auto kSoon = 1s;
constexpr auto kWarnAgain = 10min;

std::chrono::steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(s));
}

bool is_longer(double limit_s, double other_s) {
  return other_s > 0.0 && (limit_s == 0.0 || limit_s > other_s);
}

/// As seen from any other folder and machine.
Command absolute(const Command& command) {
  auto c = command;
  c.home = fs::absolute(c.home);
  c.folder = c.folder.empty() ? fs::current_path() : fs::absolute(c.folder);
  if (!c.log.empty()) c.log = fs::absolute(c.log);
  return c;
}

}  // namespace

SlurmQueue::SlurmQueue(SlurmOptions options, fs::path folder)
    : options_(std::move(options)),
      folder_(fs::absolute(std::move(folder))),
      array_limit_(std::min(kLargestArray, static_cast<std::size_t>(options_.max_jobs))),
      thread_([this](const std::stop_token& stop) { work(stop); }) {}

CommandEnd SlurmQueue::run(const Command& command) {
  if (command.home.empty())
    throw InputError(fmt::format(
        "'{}' belongs to an engine whose runs are several programs, which the queue of SLURM does "
        "not take; choose another engine, or [compute] executor = \"local\"",
        command.words.front()));
  const auto ticket = std::make_shared<Ticket>();
  ticket->command = absolute(command);
  if (const auto earlier = read_submission(ticket->command.home)) {
    ticket->place = earlier->place;
    ticket->limit_s = earlier->command.time_limit_s;
  }
  std::unique_lock lock(mutex_);
  tickets_.push_back(ticket);
  wanted_.notify_one();
  while (is_open(*ticket)) {
    ticket->over.wait_for(lock, kSignalStep);
    lock.unlock();
    if (command.cancelled && command.cancelled()) ticket->cancel_wanted = true;
    lock.lock();
  }
  tickets_.remove(ticket);
  if (ticket->error) std::rethrow_exception(ticket->error);
  return *ticket->end;
}

void SlurmQueue::finish(Ticket& ticket, CommandEnd end) {
  const std::lock_guard lock(mutex_);
  end.resources.ranks = ticket.command.processes;
  ticket.end = std::move(end);
  ticket.over.notify_one();
}

void SlurmQueue::fail(Ticket& ticket, std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  ticket.error = std::move(error);
  ticket.over.notify_one();
}

void SlurmQueue::work(const std::stop_token& stop) {
  stop_ = stop;
  while (!stop.stop_requested()) {
    Tickets open;
    {
      std::unique_lock lock(mutex_);
      if (!wanted_.wait(lock, stop, [&] { return !tickets_.empty(); })) return;
      for (const auto& ticket : tickets_)
        if (is_open(*ticket)) open.push_back(ticket);
    }
    try {
      step(open);
    } catch (...) {
      for (const auto& ticket : open)
        if (is_open(*ticket)) fail(*ticket, std::current_exception());
    }
    std::unique_lock lock(mutex_);
    wanted_.wait_for(lock, stop, kStep, [] { return false; });
  }
}

void SlurmQueue::step(const Tickets& tickets) {
  if (!std::exchange(is_swept_, true)) remove_leftovers(folder_);
  submit_waiting(tickets);
  collect(tickets);
  cancel(tickets);
  if (Clock::now() >= ask_again_) compare_with_queue(tickets);
}

void SlurmQueue::submit_waiting(const Tickets& tickets) {
  Tickets waiting;
  std::size_t in_queue = 0;
  for (const auto& ticket : tickets) {
    if (ticket->place) {
      ++in_queue;
    } else if (ticket->cancel_wanted) {
      finish(*ticket, {.ended = CommandEnded::when_cancelled, .signal = SIGTERM});
    } else {
      waiting.push_back(ticket);
    }
  }
  const auto most = static_cast<std::size_t>(options_.max_jobs);
  const auto now = Clock::now();
  if (waiting.empty() || in_queue >= most || now < submit_again_) return;
  const auto limit = std::min(array_limit_, most - in_queue);
  if (now - waiting.front()->wanted_at < seconds(options_.gather_s) && waiting.size() < limit)
    return;
  const auto needs = needs_of(waiting.front()->command);
  Tickets batch;
  for (const auto& ticket : waiting)
    if (batch.size() < limit && needs_of(ticket->command) == needs) batch.push_back(ticket);
  submit_array(batch, needs);
}

/// In this order: the array's folder, the runs' notes, sbatch, the number of the job. If we die or
/// lose the answer in between, the notes name an array that squeue either knows by its name or not;
/// and in that case its runs are submitted under a new name, which keeps the old tasks from them.
void SlurmQueue::submit_array(const Tickets& batch, const TaskNeeds& needs) {
  const auto array = folder_ / new_array_name();
  std::vector<fs::path> homes;
  for (const auto& ticket : batch) homes.push_back(ticket->command.home);
  make_array(array, homes);
  write_file_atomically(array / "job.sh", job_script(options_, array));
  for (std::size_t i = 0; i < batch.size(); ++i) {
    batch[i]->place = Submission{array, static_cast<int>(i)};
    batch[i]->limit_s = batch[i]->command.time_limit_s;
    batch[i]->missed_at.reset();
    const auto old = submission_of(homes[i]);
    write_submission({*batch[i]->place, batch[i]->command, content_of(batch[i]->command)});
    if (old) remove_task(*old);
  }
  const auto answer = submit(sbatch_words(options_, needs, array, batch.size()));
  switch (answer.answer) {
    case Answer::accepted:
      answered();
      write_file_atomically(job_file(array), answer.job + "\n");
      array_limit_ =
          std::min({2 * array_limit_, kLargestArray, static_cast<std::size_t>(options_.max_jobs)});
      return;
    case Answer::silent:
      silent("sbatch", answer.said);
      ask_again_ = Clock::now() + kSoon;
      return;
    default:
      break;
  }
  for (const auto& ticket : batch) {
    forget_submission(ticket->command.home);
    ticket->place.reset();
  }
  if (answer.answer == Answer::queue_full) {
    if (batch.size() == 1)
      submit_again_ = Clock::now() + seconds(kFullQueueFactor * options_.ask_every_s);
    array_limit_ = std::max<std::size_t>(1, batch.size() / 2);
    return;
  }
  const auto key = key_refused(answer.said);
  throw InputError(fmt::format("sbatch refuses the runs: \"{}\"; {}", answer.said,
                               key.empty() ? "see [slurm] and [compute]" : "see " + key));
}

void SlurmQueue::collect(const Tickets& tickets) {
  std::map<fs::path, ArrayFiles> arrays;
  for (const auto& ticket : tickets) {
    if (!is_open(*ticket) || !ticket->place) continue;
    const auto [it, is_new] = arrays.try_emplace(ticket->place->array);
    if (is_new) it->second = look_into(it->first);
    if (it->second.ended.count(ticket->place->task) > 0) take_end(*ticket);
  }
}

void SlurmQueue::take_end(Ticket& ticket) {
  auto end = read_end(*ticket.place);
  if (end.error) {
    forget_submission(ticket.command.home);
    fail(ticket, std::make_exception_ptr(Error(*end.error, end.message)));
    return;
  }
  if (end.end.ended == CommandEnded::at_time_limit &&
      is_longer(ticket.command.time_limit_s, ticket.limit_s)) {
    ticket.place.reset();  // it was submitted by a campaign that gave it less time
    return;
  }
  if (end.end.ended == CommandEnded::when_cancelled && !ticket.cancel_sent &&
      (end.end.exit_code != 0 || end.end.signal != 0)) {
    end.end.ended = CommandEnded::by_itself;  // somebody else, or SLURM, has told it to end
    end.end.exit_code = 0;
    end.end.signal = SIGTERM;
  }
  finish(ticket, std::move(end.end));
}

void SlurmQueue::compare_with_queue(const Tickets& tickets) {
  const bool is_any = std::any_of(tickets.begin(), tickets.end(), [](const auto& ticket) {
    return is_open(*ticket) && ticket->place;
  });
  if (!is_any) return;
  const auto queue = ask_queue([this] { return stop_.stop_requested(); });
  ask_again_ = Clock::now() + seconds(options_.ask_every_s);
  if (!queue.answered) return silent("squeue", queue.said);
  answered();
  std::map<std::pair<std::string, int>, const QueuedTask*> known;
  for (const auto& task : queue.tasks) known[{task.array, task.task}] = &task;
  std::map<fs::path, ArrayFiles> arrays;
  for (const auto& ticket : tickets) {
    if (!is_open(*ticket) || !ticket->place) continue;
    const auto& array = ticket->place->array;
    const auto it = known.find({array.filename().string(), ticket->place->task});
    if (it == known.end()) {
      const auto [files, is_new] = arrays.try_emplace(array);
      if (is_new) files->second = look_into(array);  // after squeue: an end written before is seen
      judge_missing(*ticket, files->second);
      continue;
    }
    ticket->missed_at.reset();
    warn_of_reason(*it->second);
    if (job_of(array).empty() && fs::exists(array))
      write_file_atomically(job_file(array),
                            it->second->job.substr(0, it->second->job.find('_')) + "\n");
  }
}

/// SLURM does not know a task (any more) of which we have no end.
void SlurmQueue::judge_missing(Ticket& ticket, const ArrayFiles& files) {
  const int task = ticket.place->task;
  if (files.ended.count(task) > 0) return;  // it has just come
  const bool has_begun = files.begun.count(task) > 0;
  if (!has_begun && ticket.cancel_wanted)
    return finish(ticket, {.ended = CommandEnded::when_cancelled, .signal = SIGTERM});
  if (!has_begun && !files.has_job) return ticket.place.reset();  // it was never submitted
  const auto now = Clock::now();
  if (!ticket.missed_at) ticket.missed_at = now;
  if (now - *ticket.missed_at < seconds(options_.file_patience_s)) return;
  const auto words = last_words(*ticket.place);
  const auto what = fmt::format(
      "job {}_{} of SLURM ended without a word of what came of it{}", job_of(ticket.place->array),
      task, words.empty() ? "" : fmt::format("; its last line is \"{}\"", words));
  if (!has_begun && !words.empty()) {
    forget_submission(ticket.command.home);
    throw StorageError(fmt::format(
        "{}, before it began its run; check [slurm] setup, and that nodes see '{}' and '{}'", what,
        options_.program.string(), folder_.string()));
  }
  if (!ticket.command.log.empty()) std::ofstream(ticket.command.log, std::ios::app) << what << '\n';
  finish(ticket,
         {.ended = ticket.cancel_sent ? CommandEnded::when_cancelled : CommandEnded::by_itself,
          .signal = SIGKILL});
}

void SlurmQueue::cancel(const Tickets& tickets) {
  std::vector<std::string> jobs;
  Tickets told;
  for (const auto& ticket : tickets) {
    if (!is_open(*ticket) || !ticket->cancel_wanted || ticket->cancel_sent || !ticket->place)
      continue;
    const auto job = job_of(ticket->place->array);
    if (job.empty()) continue;  // until squeue has told whether there is one
    jobs.push_back(fmt::format("{}_{}", job, ticket->place->task));
    told.push_back(ticket);
  }
  if (jobs.empty()) return;
  for (const auto& ticket : told) ticket->cancel_sent = true;
  if (!cancel_jobs(jobs)) {
    for (const auto& ticket : told) ticket->cancel_sent = false;
    silent("scancel", "no answer");
  }
  ask_again_ = std::min(ask_again_, Clock::now() + kSoon);
}

const std::string& SlurmQueue::content_of(const Command& command) {
  const auto [it, is_new] = contents_.try_emplace(command.folder / command.words.front());
  if (is_new) it->second = content_of_program(command);
  return it->second;
}

/// Tells once of a reason for which a job stays pending until somebody changes something.
void SlurmQueue::warn_of_reason(const QueuedTask& task) {
  static const std::set<std::string> kHopeless{"AccountNotAllowed",
                                               "BadConstraints",
                                               "PartitionDown",
                                               "PartitionInactive",
                                               "PartitionNodeLimit",
                                               "PartitionTimeLimit",
                                               "QOSNotAllowed",
                                               "QOSMaxWallDurationPerJobLimit",
                                               "QOSMaxMemoryPerJob",
                                               "QOSMaxCpuPerJobLimit",
                                               "AssocMaxWallDurationPerJobLimit"};
  if (task.phase != JobPhase::pending || kHopeless.count(task.reason) == 0 || !options_.warn ||
      !reasons_told_.insert(task.reason).second)
    return;
  options_.warn(fmt::format(
      "SLURM has job {} pending because of {}, which does not pass by itself; Ctrl-C twice and "
      "change [slurm] or [compute], or ask who runs the cluster",
      task.job, task.reason));
}

void SlurmQueue::silent(const std::string& client, const std::string& said) {
  const auto now = Clock::now();
  if (!silent_since_) {
    silent_since_ = now;
    warn_again_ = now + seconds(options_.silence_s);
  }
  if (now < warn_again_) return;
  warn_again_ = now + kWarnAgain;
  if (options_.warn)
    options_.warn(fmt::format(
        "SLURM has not answered for {}; {} says \"{}\". Jobs go on without us; we ask again",
        duration_text(std::chrono::duration<double>(now - *silent_since_).count()), client, said));
}

void SlurmQueue::answered() {
  silent_since_.reset();
}

}  // namespace repose::dem_adapter

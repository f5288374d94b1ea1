#include <fmt/format.h>

#include <map>
#include <set>

#include "repose/base/error.hpp"
#include "repose/dem_adapter/slurm.hpp"
#include "slurm_commands.hpp"
#include "slurm_files.hpp"
#include "slurm_queue.hpp"

namespace repose::dem_adapter {

namespace fs = std::filesystem;

SlurmExecutor::SlurmExecutor(SlurmOptions options, fs::path folder) {
  check_slurm_is_installed();
  if (options.program.empty()) options.program = fs::read_symlink("/proc/self/exe");
  queue_ = std::make_shared<SlurmQueue>(std::move(options), std::move(folder));
}

CommandEnd SlurmExecutor::run(const Command& command) const {
  return queue_->run(command);
}

void run_slurm_task(const fs::path& array, int task, const std::function<bool()>& told_to_end) {
  const Submission place{fs::absolute(array), task};
  const auto home = home_of(place);
  const auto is_ours = [&] { return submission_of(home) == place; };
  auto submitted = read_submission(home);
  if (!submitted || submitted->place != place) return;  // the run was given to another task
  write_begun(place);
  auto& command = submitted->command;
  command.cancelled = told_to_end;
  command.home.clear();  // it stands in a queue: that of this job
  TaskEnd end;
  try {
    if (content_of_program(command) != submitted->content)
      throw StorageError(
          fmt::format("'{}' was replaced while a run that needs it stood in the queue; call again",
                      command.words.front()));
    end.end = LocalExecutor().run(command);
  } catch (const Error& error) {
    end.error = error.kind();
    end.message = error.what();
  }
  if (is_ours()) write_end(place, end);
}

QueueState queue_state(const std::vector<fs::path>& homes) {
  std::map<std::pair<std::string, int>, fs::path> submitted;
  for (const auto& home : homes)
    if (const auto place = submission_of(home))
      submitted[{place->array.filename().string(), place->task}] = home;
  QueueState state;
  if (submitted.empty()) return state;
  Queue queue;
  try {
    queue = ask_queue();
  } catch (const StorageError& error) {
    queue.said = error.what();
  }
  if (!queue.answered) state.silence = queue.said;
  std::set<std::string> reasons;
  for (const auto& task : queue.tasks) {
    const auto it = submitted.find({task.array, task.task});
    if (it == submitted.end()) continue;
    const bool is_pending = task.phase == JobPhase::pending;
    (is_pending ? state.pending : state.running).push_back(it->second);
    if (is_pending && task.reason != "None") reasons.insert(task.reason);
  }
  state.reasons.assign(reasons.begin(), reasons.end());
  return state;
}

}  // namespace repose::dem_adapter

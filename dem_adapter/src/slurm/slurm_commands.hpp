// sbatch, squeue and scancel: what we say to them and what their answers mean.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/slurm.hpp"

namespace repose::dem_adapter {

/// Throws StorageError naming the Debian package if one of the three is missing.
void check_slurm_is_installed();

enum class Answer {
  accepted,
  refused,     ///< will be refused again
  queue_full,  ///< a limit on jobs in the queue
  silent       ///< no answer, or none that can be relied on: it may have been accepted
};

struct SubmitAnswer {
  Answer answer = Answer::silent;
  std::string job;   ///< its number, if accepted
  std::string said;  ///< the words of sbatch on one line, otherwise
};
/// What is asked for each task of an array.
struct TaskNeeds {
  int processes = 1;
  int minutes = 0;  ///< 0: SLURM's default
  bool operator==(const TaskNeeds&) const = default;
};
/// With time for the grace and for the start of the job.
TaskNeeds needs_of(const Command& command);
std::vector<std::string> sbatch_words(const SlurmOptions& options, const TaskNeeds& needs,
                                      const std::filesystem::path& array, std::size_t tasks);
SubmitAnswer submit(const std::vector<std::string>& words);
/// What an sbatch that ended with this code and these words means.
SubmitAnswer meaning_of_sbatch(int exit_code, const std::string& said);
/// The key of ours that made sbatch refuse, by its words; empty if they do not tell.
std::string key_refused(const std::string& said);

enum class JobPhase { pending, running };
struct QueuedTask {
  std::string array;  ///< name of the job
  int task = 0;
  std::string job;  ///< "12_3", as scancel wants it
  JobPhase phase = JobPhase::pending;
  std::string reason;  ///< why it is pending
};
struct Queue {
  std::vector<QueuedTask> tasks;  ///< of all our arrays, those that are not over
  bool answered = false;
  std::string said;  ///< by squeue, where it did not answer
};
Queue ask_queue(const std::function<bool()>& given_up = {});
Queue parse_queue(const std::string& text);

/// False if it did not answer.
bool cancel_jobs(const std::vector<std::string>& jobs);

/// The text of the batch script.
std::string job_script(const SlurmOptions& options, const std::filesystem::path& array);
/// A name that no other array has, on any machine.
std::string new_array_name();

}  // namespace repose::dem_adapter

// What a run's folder says about its job in a queue, for as long as what came of it is not stored.
//
// RUN/submitted.json names the job array, a folder, and its task. It is written before the array is
// submitted and read again by the task: only the one that it names does the run, so that a job
// which a lost answer has hidden from us can do no harm. The folder of an array holds for each task
// i the files i.task (the run's folder), i.begun, i.end (what came of it) and i.txt (what the job
// itself said), and job, the number that SLURM gave it (docs/decisions/0013).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace repose::dem_adapter {

/// Which task of which array does a run; the array's folder has the name of its job.
struct Submission {
  std::filesystem::path array;  ///< absolute
  int task = 0;
  bool operator==(const Submission&) const = default;
};

/// Of the run in this folder; empty if it stands in no queue. Throws StorageError if the note is
/// damaged.
std::optional<Submission> submission_of(const std::filesystem::path& home);

/// To be called once the end of a run is stored: it is then no longer in a queue, and the files of
/// its task go. Throws StorageError if the note cannot be removed.
void forget_submission(const std::filesystem::path& home);

/// Where runs are in the queue. A run that SLURM does not know (any more) is in neither list.
struct QueueState {
  std::vector<std::filesystem::path> pending, running;  ///< folders of runs
  std::vector<std::string> reasons;                     ///< why some are pending, each once
  std::string silence;                                  ///< why the queue could not be asked, if so
};
/// Of those of the runs that have a submission; does not ask the queue if there are none.
QueueState queue_state(const std::vector<std::filesystem::path>& homes);

}  // namespace repose::dem_adapter

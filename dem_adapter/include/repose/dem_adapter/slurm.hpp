// Programs run by SLURM: many submitted together as one job array, found again after we ended.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "repose/dem_adapter/executor.hpp"

namespace repose::dem_adapter {

/// What sbatch is told, and how patient we are.
struct SlurmOptions {
  std::string partition{}, account{};        ///< empty: SLURM's default
  int max_jobs = 100;                        ///< runs in the queue at once, pending or running
  double memory_per_run_gb = 0.0;            ///< 0: SLURM's default
  std::vector<std::string> extra_options{};  ///< of sbatch, e.g. "--constraint=avx2"
  std::string setup{};                       ///< shell lines of the job before the program
  std::filesystem::path program{};           ///< `repose` on the nodes; empty: the running program
  double gather_s = 1.0;                     ///< runs wanted within this time are one job array
  double ask_every_s = 5.0;                  ///< of squeue, for all runs in one call
  double file_patience_s = 15.0;             ///< until a file from a node must be visible here
  double silence_s = 60.0;                   ///< a controller that is silent longer is told of
  std::function<void(std::string)> warn =
      {};  ///< told of trouble that may pass, from a thread of ours
};

/// An ExecutorLike value whose copies share one queue. run() waits from submission to end, however
/// long the run is pending; call it from as many threads as runs are wanted in the queue. When the
/// process dies the jobs go on, and run() of a command with the same `home` waits for that job in
/// place of a new one.
///
/// run() throws StorageError without sbatch or where jobs end before our program, InputError with
/// the words of an sbatch that refuses. A controller that does not answer is waited for.
class SlurmExecutor {
 public:
  /// Job arrays are noted below `folder`, which the nodes see under the same path. Throws
  /// StorageError if there is no sbatch, squeue or scancel on PATH.
  SlurmExecutor(SlurmOptions options, std::filesystem::path folder);
  CommandEnd run(const Command& command) const;

 private:
  std::shared_ptr<class SlurmQueue> queue_;
};

/// What a task of a job array does on its node: runs the program of its run, unless the run belongs
/// to another task by now, and notes its end atomically. `told_to_end`: SLURM, or who cancels the
/// job, wants it to end; the program then has its grace. Throws InputError if there is no such
/// task, StorageError if its end cannot be noted.
void run_slurm_task(const std::filesystem::path& array, int task,
                    const std::function<bool()>& told_to_end);

}  // namespace repose::dem_adapter

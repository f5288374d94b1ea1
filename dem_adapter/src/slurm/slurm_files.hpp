// The files by which a campaign and the tasks of its job arrays know of each other.
#pragma once

#include <exception>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/dem_adapter/executor.hpp"
#include "repose/dem_adapter/submission.hpp"

namespace repose::dem_adapter {

/// A submission with the command that its task runs; paths are absolute.
struct SubmittedCommand {
  Submission place;
  Command command;
  std::string content;  ///< content_of() its program: another build is another engine
};
/// Empty if the program cannot be read.
std::string content_of_program(const Command& command);
/// RUN/submitted.json. Throws StorageError if it cannot be written or is damaged.
void write_submission(const SubmittedCommand& submitted);
std::optional<SubmittedCommand> read_submission(const std::filesystem::path& home);

/// Makes the folder of an array with the task files of these runs.
void make_array(const std::filesystem::path& array,
                const std::vector<std::filesystem::path>& homes);
/// The run of a task. Throws InputError if there is no such task.
std::filesystem::path home_of(const Submission& place);
/// Removes what belongs to one task, and the folder with the last of them.
void remove_task(const Submission& place);
/// Removes from the arrays below `folder` every task that its run does not name.
void remove_leftovers(const std::filesystem::path& folder);

/// What came of a task: an end, or an error that kept it from beginning.
struct TaskEnd {
  CommandEnd end;
  std::optional<ErrorKind> error;
  std::string message;  ///< of the error
};
void write_begun(const Submission& place);
void write_end(const Submission& place, const TaskEnd& end);
/// Throws StorageError if it is damaged.
TaskEnd read_end(const Submission& place);

/// What is in the folder of an array: one look at a folder, however many tasks there are.
struct ArrayFiles {
  std::set<int> begun, ended;
  bool has_job = false;  ///< sbatch said that it has taken it
};
ArrayFiles look_into(const std::filesystem::path& array);

std::filesystem::path job_file(const std::filesystem::path& array);  ///< the number of its job
std::string job_of(const std::filesystem::path& array);  ///< that number; empty: unknown
/// What the job of a task said itself, on its last line; empty if nothing.
std::string last_words(const Submission& place);

}  // namespace repose::dem_adapter

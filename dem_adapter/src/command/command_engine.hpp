// The engine that a command of the user's own is.
#pragma once

#include <regex>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/dem_adapter/engine.hpp"

namespace repose::dem_adapter {

/// What is done with a file before the command runs.
enum class FileUse { copied, filled_in };

struct CommandFile {
  std::string name;  ///< relative to the folder where the command runs
  std::string content;
  FileUse use = FileUse::copied;
  bool is_executable = false;
};

/// Words in the log of a command that failed, and what they mean.
struct FailureSign {
  Outcome outcome;
  std::string pattern;
  std::regex compiled;
};

struct UserCommand {
  std::vector<std::string> words;  ///< the program, then its arguments, which may have placeholders
  std::vector<CommandFile> files;
  std::string version;  ///< what the user says of what else there is
  std::vector<FailureSign> signs;
};

/// What a run of a command starts from: its case.toml.
struct CommandInput {
  std::uint64_t seed = 0;
  ParameterValues values;
};
std::string command_input_text(const CommandInput& input);
/// Throws InputError or StorageError.
CommandInput read_command_input(const std::filesystem::path& file);

/// Placeholders that need no parameter: seed; seed_31, made from it, in [1, 2^31 - 1); ranks.
const std::vector<std::string>& built_in_placeholders();

class CommandEngine {
 public:
  /// Throws StorageError if the program is not there.
  CommandEngine(std::string title, UserCommand command, Executor executor);
  std::string name() const { return name_; }
  /// Throws InputError for several ranks if nothing has the placeholder ${ranks}.
  EngineExit run(const EngineJob& job) const;

 private:
  UserCommand command_;
  Executor executor_;
  std::string program_;
  std::string name_;
};

}  // namespace repose::dem_adapter

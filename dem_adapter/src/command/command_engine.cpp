#include "command_engine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "engine/programs.hpp"
#include "placeholders.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/base/toml.hpp"
#include "repose/dem_adapter/submission.hpp"
#include "run_folder.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;
constexpr std::uint64_t kLargest31 = 2147483646;  // below the largest of a signed 32-bit integer

/// A program with a "/" in its name lies where the command runs, or is absolute.
bool is_in_folder(const std::string& program) {
  return program.find('/') != std::string::npos && !fs::path(program).is_absolute();
}

std::string program_of(const std::string& word) {
  if (is_in_folder(word)) return word;
  const fs::path path(word);
  if (!path.is_absolute())
    return find_program(word, "install it, or give its path in command").string();
  check_executable(path);
  return word;
}

std::string name_of(const std::string& title, const UserCommand& command,
                    const std::string& program) {
  std::string all = command.version + '\n';
  const auto add = [&](const std::string& part) {
    all += fmt::format("{}:{}\n", part.size(), part);
  };
  for (const auto& word : command.words) add(word);
  for (const auto& file : command.files) {
    add(file.name);
    all += file.use == FileUse::filled_in ? 't' : 'f';
    add(file.content);
  }
  if (!is_in_folder(program)) add(content_of(program));
  return fmt::format("command {} {:016x}", title, content_hash(all));
}

void write_files(const UserCommand& command, const std::map<std::string, std::string>& values,
                 const fs::path& folder) {
  for (const auto& file : command.files) {
    const auto path = folder / file.name;
    make_directory(path.parent_path());
    write_file_atomically(
        path, file.use == FileUse::filled_in ? filled_in(file.content, values) : file.content);
    std::error_code code;
    if (file.is_executable)
      fs::permissions(path, fs::perms::owner_exec, fs::perm_options::add, code);
    if (code)
      throw StorageError(
          fmt::format("cannot make '{}' executable: {}", path.string(), code.message()));
  }
}

bool uses_ranks(const UserCommand& command) {
  const auto has = [](const std::string& text) {
    const auto all = placeholders_of(text);
    return std::any_of(all.begin(), all.end(), [](const auto& p) { return p.name == "ranks"; });
  };
  return std::any_of(command.words.begin(), command.words.end(), has) ||
         std::any_of(command.files.begin(), command.files.end(), [&](const CommandFile& file) {
           return file.use == FileUse::filled_in && has(file.content);
         });
}

/// What the log says of a command that failed, by the first sign that it shows.
Outcome outcome_of(const std::vector<FailureSign>& signs, const std::string& log) {
  constexpr std::size_t kLongestLine = 4000;  // the library's matcher recurses once a character
  for (const auto& sign : signs) {
    std::istringstream lines(log);
    for (std::string line; std::getline(lines, line);)
      if (std::regex_search(line.substr(0, kLongestLine), sign.compiled)) return sign.outcome;
  }
  return Outcome::engine_failed;
}

}  // namespace

std::string command_input_text(const CommandInput& input) {
  auto text = fmt::format(
      "# What a command of the user's own was given.\nseed = {}\n\n[parameters]\n", input.seed);
  for (const auto& [name, value] : input.values)
    text += fmt::format("{} = {}\n", name, shortest(value));
  return text;
}

CommandInput read_command_input(const fs::path& file) {
  const auto root = TomlTable::read_file(file);
  CommandInput input{.seed = static_cast<std::uint64_t>(root.integer("seed", kNonNegative)),
                     .values = {}};
  const auto parameters = root.table("parameters");
  for (const auto& name : parameters.keys()) input.values[name] = parameters.number(name);
  root.refuse_unknown_keys();
  return input;
}

const std::vector<std::string>& built_in_placeholders() {
  static const std::vector<std::string> kNames{"seed", "seed_31", "ranks"};
  return kNames;
}

CommandEngine::CommandEngine(std::string title, UserCommand command, Executor executor)
    : command_(std::move(command)),
      executor_(std::move(executor)),
      program_(program_of(command_.words.front())),
      name_(name_of(title, command_, program_)) {}

EngineExit CommandEngine::run(const EngineJob& job) const {
  if (job.ranks > 1 && !uses_ranks(command_))
    throw InputError(fmt::format(
        "ranks = {}, but neither command nor templates have the placeholder ${{ranks}}; put it "
        "where the number of processes stands, or leave ranks out",
        job.ranks));
  const auto output = job.directory / "output";
  const auto log = job.directory / "engine.log";
  const bool is_submitted = submission_of(job.directory).has_value();  // it may be at work there
  if (!is_submitted) {
    remove_whole(output);
    remove_whole(log);
    make_directory(output);
    write_file_atomically(output / "case.toml", read_file(job.directory / "case.toml"));
  }
  const auto input = read_command_input(output / "case.toml");
  std::map<std::string, std::string> values{
      {"seed", std::to_string(input.seed)},
      {"seed_31", std::to_string(1 + input.seed % kLargest31)},
      {"ranks", std::to_string(job.ranks)}};
  for (const auto& [name, value] : input.values) values[name] = shortest(value);
  if (!is_submitted) write_files(command_, values, output);
  Command command{.words = {program_},
                  .folder = output,
                  .log = log,
                  .processes = job.ranks,
                  .time_limit_s = job.time_limit_s,
                  .cancelled = job.cancelled,
                  .home = job.directory};
  for (std::size_t i = 1; i < command_.words.size(); ++i)
    command.words.push_back(filled_in(command_.words[i], values));
  const auto end = executor_.run(command);
  auto exit = exit_of(end, command, 0);
  if (exit.status == EngineStatus::failed && exit.failure != Outcome::crash)
    exit.failure = outcome_of(command_.signs, read_file(log));
  return exit;
}

}  // namespace repose::dem_adapter

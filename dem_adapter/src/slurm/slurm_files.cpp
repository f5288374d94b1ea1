#include "slurm_files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/programs.hpp"
#include "outcome_json.hpp"
#include "repose/base/file.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path note_file(const fs::path& home) {
  return home / "submitted.json";
}

fs::path file_of(const Submission& place, const char* kind) {
  return place.array / fmt::format("{}.{}", place.task, kind);
}

/// "12.end" is (12, "end"); nothing for other names.
std::optional<std::pair<int, std::string>> task_and_kind(const std::string& name) {
  int task = -1;
  const char* end = name.data() + name.size();
  const auto [stop, code] = std::from_chars(name.data(), end, task);
  if (code != std::errc{} || stop == end || *stop != '.') return std::nullopt;
  return std::pair(task, std::string(stop + 1, end));
}

const char* to_string(CommandEnded ended) {
  switch (ended) {
    case CommandEnded::at_time_limit:
      return "at-time-limit";
    case CommandEnded::when_cancelled:
      return "when-cancelled";
    default:
      return "by-itself";
  }
}

CommandEnded ended_named(const std::string& name) {
  for (const auto ended : {CommandEnded::at_time_limit, CommandEnded::when_cancelled})
    if (name == to_string(ended)) return ended;
  return CommandEnded::by_itself;
}

/// Parses a file of ours with `parse`. Throws StorageError if it is damaged.
template <class Parse>
auto parsed(const fs::path& file, const std::string& remedy, const Parse& parse) {
  try {
    return parse(Json::parse(read_file(file)));
  } catch (const nlohmann::json::exception& error) {
    throw StorageError(
        fmt::format("'{}' is damaged ({}); {}", file.string(), error.what(), remedy));
  }
}

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

void write_submission(const SubmittedCommand& submitted) {
  const auto& c = submitted.command;
  write_file_atomically(note_file(c.home), text_of({{"array", submitted.place.array.string()},
                                                    {"task", submitted.place.task},
                                                    {"words", c.words},
                                                    {"folder", c.folder.string()},
                                                    {"log", c.log.string()},
                                                    {"processes", c.processes},
                                                    {"time_limit_s", c.time_limit_s},
                                                    {"grace_s", c.grace_s},
                                                    {"content", submitted.content}}));
}

std::string content_of_program(const Command& command) {
  try {
    return content_of(command.folder / command.words.front());
  } catch (const StorageError&) {
    return "";
  }
}

std::optional<SubmittedCommand> read_submission(const fs::path& home) {
  const auto file = note_file(home);
  if (!fs::exists(file)) return std::nullopt;
  return parsed(file, "end its job, if it has one, and remove that file", [&](const Json& json) {
    return std::optional<SubmittedCommand>(
        {.place = {.array = json.at("array").get<std::string>(),
                   .task = json.at("task").get<int>()},
         .command = {.words = json.at("words").get<std::vector<std::string>>(),
                     .folder = json.at("folder").get<std::string>(),
                     .log = json.at("log").get<std::string>(),
                     .processes = json.at("processes").get<int>(),
                     .time_limit_s = json.at("time_limit_s").get<double>(),
                     .grace_s = json.at("grace_s").get<double>(),
                     .home = home},
         .content = json.at("content").get<std::string>()});
  });
}

std::optional<Submission> submission_of(const fs::path& home) {
  const auto submitted = read_submission(home);
  return submitted ? std::optional(submitted->place) : std::nullopt;
}

/// The note first: without it the task's files are leftovers, the other way round the run would
/// seem to wait for ever.
void forget_submission(const fs::path& home) {
  const auto place = submission_of(home);
  if (!place) return;
  const auto file = note_file(home);
  if (::unlink(file.c_str()) != 0 && errno != ENOENT)
    throw StorageError(fmt::format("cannot remove '{}': {}", file.string(), std::strerror(errno)));
  remove_task(*place);
}

void make_array(const fs::path& array, const std::vector<fs::path>& homes) {
  make_directory(array);
  for (std::size_t i = 0; i < homes.size(); ++i) {
    const auto file = file_of({array, static_cast<int>(i)}, "task");
    std::ofstream out(file);
    out << homes[i].string() << std::flush;
    if (!out) throw StorageError(fmt::format("cannot write '{}'", file.string()));
  }
}

fs::path home_of(const Submission& place) {
  const auto file = file_of(place, "task");
  if (!fs::exists(file))
    throw InputError(
        fmt::format("task {} of the job array '{}': there is no '{}'; the run is no longer wanted",
                    place.task, place.array.string(), file.filename().string()));
  return read_file(file);
}

void remove_task(const Submission& place) {
  std::error_code code;
  for (const char* kind : {"begun", "end", "txt", "task"}) fs::remove(file_of(place, kind), code);
  for (const auto& entry : fs::directory_iterator(place.array, code))
    if (entry.path().extension() == ".task") return;
  fs::remove_all(place.array, code);
}

void remove_leftovers(const fs::path& folder) {
  std::error_code code;
  for (const auto& array : fs::directory_iterator(folder, code)) {
    std::vector<int> tasks;
    for (const auto& entry : fs::directory_iterator(array.path(), code))
      if (const auto file = task_and_kind(entry.path().filename()); file && file->second == "task")
        tasks.push_back(file->first);
    if (tasks.empty()) fs::remove_all(array.path(), code);
    for (const int task : tasks)
      if (const Submission place{fs::absolute(array.path()), task};
          submission_of(home_of(place)) != place)
        remove_task(place);
  }
}

void write_begun(const Submission& place) {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  std::ofstream(file_of(place, "begun")) << host.data() << '\n';
}

void write_end(const Submission& place, const TaskEnd& end) {
  Json json{{"ended", to_string(end.end.ended)},
            {"exit_code", end.end.exit_code},
            {"signal", end.end.signal},
            {"resources", Json::parse(resources_text(end.end.resources))}};
  if (end.error) json["error"] = {{"kind", static_cast<int>(*end.error)}, {"message", end.message}};
  write_file_atomically(file_of(place, "end"), text_of(json));
}

TaskEnd read_end(const Submission& place) {
  return parsed(file_of(place, "end"), "remove that file to have the run done again",
                [](const Json& json) {
                  TaskEnd end{.end = {.ended = ended_named(json.at("ended").get<std::string>()),
                                      .exit_code = json.at("exit_code").get<int>(),
                                      .signal = json.at("signal").get<int>(),
                                      .resources = parse_resources(json.at("resources").dump())}};
                  if (json.contains("error")) {
                    end.error = static_cast<ErrorKind>(json.at("error").at("kind").get<int>());
                    end.message = json.at("error").at("message").get<std::string>();
                  }
                  return end;
                });
}

ArrayFiles look_into(const fs::path& array) {
  ArrayFiles files;
  std::error_code code;
  for (const auto& entry : fs::directory_iterator(array, code)) {
    const auto name = entry.path().filename().string();
    if (name == "job") files.has_job = true;
    const auto file = task_and_kind(name);
    if (!file) continue;
    if (file->second == "begun") files.begun.insert(file->first);
    if (file->second == "end") files.ended.insert(file->first);
  }
  return files;
}

fs::path job_file(const fs::path& array) {
  return array / "job";
}

std::string job_of(const fs::path& array) {
  std::string job;
  std::ifstream(job_file(array)) >> job;
  return job;
}

std::string last_words(const Submission& place) {
  std::ifstream in(file_of(place, "txt"));
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  return last;
}

}  // namespace repose::dem_adapter

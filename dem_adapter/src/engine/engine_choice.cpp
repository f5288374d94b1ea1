#include "repose/dem_adapter/engine_choice.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "programs.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/liggghts.hpp"

namespace repose::dem_adapter {

const std::vector<std::string>& engine_names() {
  static const std::vector<std::string> kNames{"bundled", "liggghts"};
  return kNames;
}

EngineChoice read_engine_choice(const TomlTable& root, const std::filesystem::path& folder) {
  EngineChoice choice;
  const auto t = root.table_if_present("engine");
  if (!t) return choice;
  choice.name = t->choice("name", engine_names());
  const auto read = [&](const char* key) -> std::filesystem::path {
    if (!t->has(key)) return {};
    const std::filesystem::path program = t->text(key);
    if (program.empty()) t->fail(key, "it is empty; name a program, or leave it out");
    return program.has_parent_path() ? folder / program : program;
  };
  choice.program = read("program");
  if (choice.name == "liggghts") choice.mpirun = read("mpirun");
  return choice;
}

EngineChoice parse_engine_choice(const std::string& word) {
  if (word.find('/') != std::string::npos) return {.name = "bundled", .program = word};
  const auto& known = engine_names();
  if (std::find(known.begin(), known.end(), word) == known.end())
    throw InputError(fmt::format(
        "there is no engine {}; choose {}, or give the path of a program that is called as "
        "repose-dem is",
        word, listed(known)));
  return {.name = word, .program = {}};
}

Engine make_engine(const Scenario& scenario, const EngineChoice& choice, const Executor& executor) {
  if (auto own = scenario.own_engine(executor)) {
    if (!choice.name.empty() || !choice.program.empty())
      throw InputError(fmt::format(
          "the scenario {} runs a command of its own; leave the engine {} out", scenario.name(),
          choice.name.empty() ? choice.program.string() : choice.name));
    return *own;
  }
  const auto found = [](const std::filesystem::path& program) {
    return program.empty() || program.has_parent_path()
               ? program
               : find_program(program.string(), "install it, or give its path");
  };
  if (choice.name == "liggghts")
    return LiggghtsEngine({.liggghts = found(choice.program), .mpirun = found(choice.mpirun)},
                          executor);
  return BundledEngine(found(choice.program), 10.0, executor);
}

}  // namespace repose::dem_adapter

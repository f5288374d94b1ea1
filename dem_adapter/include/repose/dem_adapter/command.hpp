// A user's own simulation: a command, the files that it reads, and where its KPIs stand. Any engine
// with any input can be campaigned and calibrated so; docs/how-to/own_engine.md has the keys.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/base/toml.hpp"
#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/scenario.hpp"

namespace repose::dem_adapter {

/// `scenario = "command"`. Of each run case.toml holds the values of all parameters and the seed.
/// Its engine writes the files into the output folder, placeholders filled in, and runs the command
/// there; KPIs and echoes are read from what it leaves.
class CommandScenario {
 public:
  /// Files are read here and now, so that a campaign under way does not see them change. Throws
  /// InputError with file and line: a placeholder without parameter, a parameter without
  /// placeholder, a number that cannot be looked for; StorageError for a file that is not there.
  static CommandScenario read(const TomlTable& table);

  std::string name() const;
  std::vector<std::string> parameter_names() const;
  std::vector<std::string> kpi_names() const;
  /// Throws InputError for a value that is not finite.
  RunInput make_input(const ParameterValues& values, std::uint64_t seed) const;
  /// A value that the command repeats otherwise than it was given is Outcome::engine_failed. Throws
  /// InputError naming the KPI or the parameter whose number is not there, or there twice.
  Measurement measure(const std::filesystem::path& output) const;
  /// Where KPIs and echoes are found: another text, another measurement.
  std::string kpi_definition() const;
  /// Named by the content of command, files and program. What the command says always goes to
  /// engine.log, and a run always begins anew. Throws StorageError if its program is not installed.
  Engine make_engine(const Executor& executor) const;

 private:
  struct Definition;
  explicit CommandScenario(std::shared_ptr<const Definition> definition);
  std::shared_ptr<const Definition> definition_;
};

}  // namespace repose::dem_adapter

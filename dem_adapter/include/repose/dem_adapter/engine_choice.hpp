// Which engine runs the simulations of a study or campaign: [engine].
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "repose/base/toml.hpp"
#include "repose/dem_adapter/engine.hpp"
#include "repose/dem_adapter/scenario.hpp"

namespace repose::dem_adapter {

struct EngineChoice {
  std::string name{};               ///< one of engine_names(); empty: what the scenario needs
  std::filesystem::path program{};  ///< in place of the one that is found; empty: find it
  std::filesystem::path mpirun{};   ///< likewise, of liggghts with several ranks
};

/// Engines that run cases.
const std::vector<std::string>& engine_names();

/// Reads [engine], optional: name, program, mpirun. A relative program with a "/" is relative to
/// `folder`. Throws InputError with file and line.
EngineChoice read_engine_choice(const TomlTable& root, const std::filesystem::path& folder);

/// The same from a word: the name of an engine, or the path, with a "/", of a program that is
/// called as repose-dem is. Throws InputError.
EngineChoice parse_engine_choice(const std::string& word);

/// The engine chosen, the bundled one by default; a scenario that has an engine of its own gets
/// that. Throws InputError if something else is chosen for such a scenario, StorageError if the
/// program is not installed.
Engine make_engine(const Scenario& scenario, const EngineChoice& choice,
                   const Executor& executor = LocalExecutor());

}  // namespace repose::dem_adapter

#include "repose/dem_adapter/scenario.hpp"

#include "repose/dem_adapter/command.hpp"
#include "repose/dem_adapter/drawdown.hpp"
#include "repose/dem_adapter/rig.hpp"
#include "repose/dem_adapter/shipped_scenarios.hpp"

namespace repose::dem_adapter {

RunInput input_of(const scene::Case& scene) {
  scene::validate(scene);
  return {.seed = scene.seed, .text = scene::case_text(scene)};
}

Scenario read_scenario(const TomlTable& table) {
  std::vector<std::string> known{"rig", "command"};
  for (const auto& shipped : shipped_scenarios()) known.push_back(shipped.name);
  const auto name = table.choice("scenario", known);
  if (name == "rig") return Rig::read(table);
  if (name == "command") return CommandScenario::read(table);
  if (name == "drawdown") return Drawdown::read(table);
  return Rig::read_shipped(name, table);
}

Scenario read_scenario_file(const std::filesystem::path& path) {
  const auto root = TomlTable::read_file(path);
  auto scenario = read_scenario(root);
  root.refuse_unknown_keys();
  return scenario;
}

Scenario read_scenario_key(const TomlTable& root, const std::filesystem::path& folder) {
  if (root.has("scenario") && !root.is_table("scenario"))
    return read_scenario_file(folder / root.text("scenario"));
  return read_scenario(root.table("scenario"));
}

}  // namespace repose::dem_adapter

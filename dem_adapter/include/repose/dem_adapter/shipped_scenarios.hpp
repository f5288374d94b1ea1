// The scenarios that come with repose, as files to start from.
#pragma once

#include <string>
#include <vector>

namespace repose::dem_adapter {

struct ShippedScenario {
  std::string name;     ///< for `scenario = "NAME"`
  std::string text;     ///< a scenario file that works as it is
  std::string summary;  ///< its first line
};

/// In alphabetical order.
const std::vector<ShippedScenario>& shipped_scenarios();
/// Throws InputError that lists the names there are.
const ShippedScenario& shipped_scenario(const std::string& name);

}  // namespace repose::dem_adapter

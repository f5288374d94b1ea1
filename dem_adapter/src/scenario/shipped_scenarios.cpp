#include "repose/dem_adapter/shipped_scenarios.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "scenario/shipped_texts.hpp"

namespace repose::dem_adapter {

const std::vector<ShippedScenario>& shipped_scenarios() {
  static const std::vector<ShippedScenario> kShipped = [] {
    std::vector<ShippedScenario> all;
    for (const auto& [name, text] : shipped_texts()) {
      const auto line = text.substr(0, text.find('\n'));
      all.push_back(
          {.name = name, .text = text, .summary = line.substr(line.find_first_not_of("# "))});
    }
    return all;
  }();
  return kShipped;
}

const ShippedScenario& shipped_scenario(const std::string& name) {
  std::vector<std::string> known;
  for (const auto& scenario : shipped_scenarios()) {
    if (scenario.name == name) return scenario;
    known.push_back(scenario.name);
  }
  throw InputError(
      fmt::format("there is no scenario \"{}\"; those shipped are {}", name, listed(known)));
}

}  // namespace repose::dem_adapter

// repose scenario list|show: the scenarios that come with repose.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/scenario.hpp"
#include "repose/dem_adapter/shipped_scenarios.hpp"

namespace repose::cli {
namespace {

struct ScenarioOptions {
  CommonOptions list_common, show_common;
  std::string name, output;
};

dem_adapter::Scenario scenario_of(const dem_adapter::ShippedScenario& shipped) {
  return dem_adapter::read_scenario(TomlTable::parse(shipped.text, shipped.name));
}

nlohmann::json json_of(const dem_adapter::ShippedScenario& shipped) {
  const auto scenario = scenario_of(shipped);
  return {{"name", shipped.name},
          {"summary", shipped.summary},
          {"parameters", scenario.parameter_names()},
          {"kpis", scenario.kpi_names()}};
}

void list_scenarios(const ScenarioOptions& options) {
  if (options.list_common.json) {
    auto all = nlohmann::json::array();
    for (const auto& shipped : dem_adapter::shipped_scenarios()) all.push_back(json_of(shipped));
    fmt::print("{}\n", all.dump(2));
    return;
  }
  for (const auto& shipped : dem_adapter::shipped_scenarios()) {
    fmt::print("{:<16}  {}\n", shipped.name, shipped.summary);
    fmt::print("{:<16}  KPIs {}\n", "", listed(scenario_of(shipped).kpi_names()));
  }
}

void show_scenario(const ScenarioOptions& options) {
  const auto& shipped = dem_adapter::shipped_scenario(options.name);
  if (!options.output.empty()) {
    if (std::filesystem::exists(options.output))
      throw StorageError(
          fmt::format("'{}' exists; name another file or remove it", options.output));
    write_file_atomically(options.output, shipped.text);
    return;
  }
  if (options.show_common.json) {
    auto json = json_of(shipped);
    json["text"] = shipped.text;
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}", shipped.text);
}

}  // namespace

void add_scenario(CLI::App& app) {
  auto o = std::make_shared<ScenarioOptions>();
  auto* scenario = app.add_subcommand("scenario", "Scenarios that come with repose, to start from");
  scenario->require_subcommand(1);
  scenario->footer("Example: repose scenario show hopper -o hopper.toml");
  auto* list = add_command(*scenario, "list", "Their names, what they are and what they measure",
                           "repose scenario list", o->list_common);
  list->callback([o] { list_scenarios(*o); });
  auto* show = add_command(*scenario, "show", "The file of one, which works as it is",
                           "repose scenario show hopper -o hopper.toml\n"
                           "then: repose simulate hopper.toml --set outlet_m=0.04 -o run",
                           o->show_common);
  show->add_option("NAME", o->name, "as `repose scenario list` gives it")->required();
  show->add_option("-o,--output", o->output, "file to write; it must not exist");
  show->callback([o] { show_scenario(*o); });
}

}  // namespace repose::cli

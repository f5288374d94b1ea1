// repose simulate: one run of a scenario, with its KPIs.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "measurement_text.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/campaign.hpp"
#include "repose/dem_adapter/engine_choice.hpp"
#include "repose/dem_adapter/scenario.hpp"
#include "repose/scene/run_output.hpp"
#include "stop_signal.hpp"

namespace repose::cli {
namespace {

struct SimulateOptions {
  CommonOptions common;
  std::string scenario;
  std::vector<std::string> settings;
  std::string output;
  std::string engine;
  std::uint64_t seed = 1;
  double time_limit_s = 0.0;
};

/// NAME=VALUE pairs; names must be parameters of the scenario.
ParameterValues parse_settings(const std::vector<std::string>& settings,
                               const dem_adapter::Scenario& scenario) {
  const auto known = scenario.parameter_names();
  ParameterValues values;
  for (const auto& setting : settings) {
    const auto equals = setting.find('=');
    const auto name = setting.substr(0, equals);
    if (equals == std::string::npos)
      throw UsageError(fmt::format("--set {}: write NAME=VALUE, e.g. mu_s_pp=0.5", setting));
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      const auto similar = closest_name(name, known);
      throw UsageError(fmt::format(
          "--set {}: the scenario has no parameter {}; {}", setting, name,
          similar.empty() ? "it has " + listed(known) : "did you mean " + similar + "?"));
    }
    double value = 0.0;
    const char* end = setting.data() + setting.size();
    const auto [stop, code] = std::from_chars(setting.data() + equals + 1, end, value);
    if (code != std::errc{} || stop != end)
      throw UsageError(
          fmt::format("--set {}: {} is not a number", setting, setting.substr(equals + 1)));
    values[name] = value;
  }
  return values;
}

void print_result(const SimulateOptions& options, const dem_adapter::Measurement& m,
                  double seconds) {
  auto json = measurement_json(m);
  json["wall_time_s"] = seconds;
  write_file_atomically(std::filesystem::path(options.output) / "kpis.json", json.dump(2) + "\n");
  if (options.common.json) {
    fmt::print("{}\n", json.dump(2));
    return;
  }
  print_measurement(m);
  fmt::print("\n{} in {}\n", duration_text(seconds), options.output);
}

/// A folder may be new, empty, or hold the same run unfinished, which then goes on from its
/// checkpoint or, without one, begins anew.
void claim(const std::filesystem::path& directory, const std::string& case_text) {
  if (!std::filesystem::exists(directory)) return;
  const bool folder = std::filesystem::is_directory(directory);
  if (folder && std::filesystem::is_empty(directory)) return;
  const auto case_file = directory / "case.toml";
  if (folder && std::filesystem::exists(case_file) && read_file(case_file) == case_text &&
      !std::filesystem::exists(directory / "output" / "run.h5") &&
      !std::filesystem::exists(directory / "kpis.json"))
    return;
  throw StorageError(fmt::format("'{}' exists and is not empty; name another folder or remove it",
                                 directory.string()));
}

void simulate(const SimulateOptions& options) {
  const auto scenario = dem_adapter::read_scenario_file(options.scenario);
  const auto input = scenario.make_input(parse_settings(options.settings, scenario), options.seed);
  const std::filesystem::path directory = options.output;
  claim(directory, input.text);
  const auto engine = dem_adapter::make_engine(
      scenario, options.engine.empty() ? dem_adapter::EngineChoice{}
                                       : dem_adapter::parse_engine_choice(options.engine));
  make_directory(directory);
  write_file_atomically(directory / "case.toml", input.text);
  const auto& stop = stop_requested(FirstInterrupt::ends_runs);
  const auto exit = engine.run({.directory = directory,
                                .time_limit_s = options.time_limit_s,
                                .cancelled = [&] { return stop != dem_adapter::Stop::no; },
                                .streams = options.common.quiet || options.common.json
                                               ? dem_adapter::EngineStreams::to_log
                                               : dem_adapter::EngineStreams::inherited});
  if (exit.status == dem_adapter::EngineStatus::cancelled) throw dem_adapter::Interrupted();
  if (exit.status != dem_adapter::EngineStatus::finished) throw SimulationError(exit.message);
  const auto measurement = scenario.measure(directory / "output");
  print_result(options, measurement, exit.resources.wall_time_s);
  if (is_failure(measurement.outcome)) throw SimulationError(measurement.failure);
}

}  // namespace

void add_simulate(CLI::App& app) {
  auto o = std::make_shared<SimulateOptions>();
  auto* command =
      add_command(app, "simulate", "Runs a scenario once and measures its KPIs",
                  "repose simulate scenario.toml --set mu_s_pp=0.5 --set mu_r_pp=0.2 -o run\n"
                  "with scenario.toml:\n  scenario = \"drawdown\"\n  preset = \"quick\"\n"
                  "The scenario becomes the case OUTPUT/case.toml, whose keys, units and defaults\n"
                  "repose-dem --help lists.",
                  o->common);
  command->add_option("SCENARIO", o->scenario, "TOML file of the scenario")->required();
  command->add_option("--set", o->settings,
                      "NAME=VALUE in place of the scenario's value; may be repeated");
  command->add_option("--seed", o->seed, "of the packing")
      ->capture_default_str()
      ->check(CLI::Range(0L, 9223372036854775807L));
  command->add_option("--engine", o->engine,
                      "its name, or the path of a program that is called as repose-dem\n"
                      "is; default: bundled");
  command->add_option("--time-limit", o->time_limit_s, "s of wall time; 0: none")
      ->check(CLI::NonNegativeNumber);
  command->add_option("-o,--output", o->output, "folder to write, new or empty")->required();
  command->callback([o] { simulate(*o); });
}

}  // namespace repose::cli

// repose calibrate: from a study to calibrated parameters and their proof.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "command.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/dem_adapter/calibration.hpp"
#include "stop_signal.hpp"
#include "warning.hpp"

namespace repose::cli {
namespace {

using namespace dem_adapter;

struct CalibrateOptions {
  CommonOptions common;
  std::string study;
  std::string output;
  unsigned workers = 0;
  std::optional<std::uint64_t> seed;
  bool dry_run = false;
};

nlohmann::json as_json(const Calibration& result) {
  nlohmann::json json{{"values", result.values},
                      {"expected_weighted_error", result.predicted_error},
                      {"verified_weighted_error", result.verified_error},
                      {"best_screening_point_weighted_error", result.baseline_error},
                      {"runs", result.data.observations.size()},
                      {"failed_runs", result.data.failed()},
                      {"stopped_because", result.stop_reason},
                      {"remarks", result.remarks},
                      {"parameters", nlohmann::json::array()},
                      {"kpis", nlohmann::json::array()}};
  for (const auto& p : result.parameters)
    json["parameters"].push_back({{"name", p.name},
                                  {"value", p.value},
                                  {"calibrated", p.selected},
                                  {"indistinguishable_from", p.lowest},
                                  {"indistinguishable_to", p.highest}});
  for (const auto& k : result.kpis)
    json["kpis"].push_back({{"name", k.target.target.name},
                            {"target", k.target.target.value},
                            {"predicted", k.predicted.mean},
                            {"verified", k.verified.mean},
                            {"verified_standard_deviation", k.verified.deviation},
                            {"verified_relative_error", k.verified_relative_error()},
                            {"reached", k.reached()}});
  return json;
}

/// Shows one progress display after another, and sentences between them.
class Terminal {
 public:
  explicit Terminal(const CommonOptions& options) : options_(options) {}
  CalibrationObserver observer() {
    return {.say =
                [this](const std::string& sentence) {
                  display_.reset();
                  if (!options_.quiet) fmt::print(stderr, "{}", sentence);
                },
            .progress =
                [this](const std::string& label) {
                  display_ = std::make_shared<ProgressDisplay>(label, options_.progress_style());
                  return [display = display_](double done, double total, std::string_view note) {
                    display->update(done, total, note);
                  };
                }};
  }
  void end() { display_.reset(); }

 private:
  CommonOptions options_;
  std::shared_ptr<ProgressDisplay> display_;
};

void calibrate_study(const CalibrateOptions& options) {
  auto study = read_study(options.study);
  if (options.seed) study.seed = *options.seed;
  if (options.workers > 0) study.compute.workers = options.workers;
  study.compute.workers = runs_at_once(study.compute);
  const std::filesystem::path directory = options.output;
  const auto& store = study.compute.store.empty() ? directory : study.compute.store;
  const auto plan = plan_text(study, study.compute.workers, mean_wall_time_s(store));
  if (options.dry_run) {
    fmt::print("{}", plan);
    return;
  }
  if (!options.common.quiet) fmt::print(stderr, "{}\n", plan);
  const Campaign campaign(directory,
                          make_engine(study.scenario, study.engine,
                                      executor_of(study.compute, directory, print_warning)),
                          measure_of(study.scenario),
                          {.compute = study.compute,
                           .failures = study.failures,
                           .stop = &stop_requested(FirstInterrupt::lets_runs_end)});
  Terminal terminal(options.common);
  const auto result = calibrate(study, campaign, terminal.observer());
  terminal.end();
  write_results(directory, study, result, command_line());
  write_file_atomically(directory / "study_as_run.toml", read_file(options.study));
  if (options.common.json)
    fmt::print("{}\n", as_json(result).dump(2));
  else
    fmt::print("{}\nReport: {}\n", result_text(study, result),
               (directory / "report.html").string());
  if (!std::isfinite(result.verified_error))
    throw SimulationError(
        "every run at the calibrated point failed, so nothing is proven; see the remarks above");
}

}  // namespace

void add_calibrate(CLI::App& app) {
  auto o = std::make_shared<CalibrateOptions>();
  auto* command =
      add_command(app, "calibrate", "Calibrates a study end to end; goes on where it was stopped",
                  "repose calibrate examples/01_drawdown_quick/study.toml -o quick", o->common);
  command->add_option("STUDY", o->study, "TOML file of the study")->required();
  command->add_option("-o,--output", o->output, "folder of the runs and results")->required();
  command->add_option("--workers", o->workers, "runs at once; 0: one for each processor")
      ->check(CLI::Range(0, 4096));
  command->add_option("--seed", o->seed, "in place of the study's")
      ->check(CLI::Range(0L, 9223372036854775807L));
  command->add_flag("--dry-run", o->dry_run, "print the plan and its cost, run nothing");
  command->callback([o] { calibrate_study(*o); });
}

}  // namespace repose::cli

// repose compare: every model of the zoo on the same folds of a table, best first.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <tuple>

#include "command.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "repose/plot/figure.hpp"
#include "validation.hpp"

namespace repose::cli {
namespace {

struct CompareOptions {
  CommonOptions common;
  TrainingColumns columns;
  ValidationOptions validation;
  int folds = 5;
  int repetitions = 1;
  int inner = 5;
  int optimise = 50;
  std::string figures;
};

/// A model with what became of it.
struct Contestant {
  std::string name;
  surrogate::CrossValidation validation;
  std::string description;  ///< of the model fitted to all rows
  std::string failure;      ///< of that fit
  double fit_seconds = std::nan("");
  double predictions_per_second = std::nan("");
};

/// What is reported of a model besides its error: the fit to all rows, its time and speed.
void fit_to_all_rows(Contestant& c, const TrainingTable& table, const CompareOptions& options) {
  using Clock = std::chrono::steady_clock;
  try {
    const auto trainer = trainer_of(c.name, table, options.validation.search);
    const auto start = Clock::now();
    const auto model =
        trainer.fit(table.data, derive_seed(options.validation.seed, c.validation.folds.size()));
    c.fit_seconds = std::chrono::duration<double>(Clock::now() - start).count();
    c.description = model.describe();
    c.predictions_per_second = surrogate::prediction_rate(model, table.data.x);
  } catch (const Error& error) {
    c.failure = error.what();
  }
}

/// Why a model ranks last, or nothing.
std::string failure_of(const Contestant& c) {
  if (c.validation.failed_folds > 0)
    for (const auto& fold : c.validation.folds)
      if (!fold.failure.empty())
        return fmt::format("{} of {} folds failed, {}: {}", c.validation.failed_folds,
                           c.validation.folds.size(), fold.name, fold.failure);
  return c.failure;
}

void sort_best_first(std::vector<Contestant>& contestants) {
  const auto rank = [](const Contestant& c) {
    const double rmse = c.validation.metrics.rmse;
    return std::tuple(c.validation.failed_folds > 0,
                      std::isnan(rmse) ? std::numeric_limits<double>::infinity() : rmse);
  };
  std::stable_sort(contestants.begin(), contestants.end(),
                   [&rank](const Contestant& a, const Contestant& b) { return rank(a) < rank(b); });
}

std::vector<Contestant> run_all(const CompareOptions& options, const TrainingTable& table,
                                const std::vector<surrogate::Fold>& folds) {
  auto results = validate(table, folds, options.validation, options.common.progress_style());
  std::vector<Contestant> contestants;
  for (std::size_t i = 0; i < results.size(); ++i)
    contestants.push_back({.name = options.validation.models[i],
                           .validation = std::move(results[i]),
                           .description = {},
                           .failure = {}});
  ProgressDisplay display("models fitted to all rows", options.common.progress_style());
  for (std::size_t i = 0; i < contestants.size(); ++i) {
    fit_to_all_rows(contestants[i], table, options);
    display.update(static_cast<double>(i + 1), static_cast<double>(contestants.size()),
                   contestants[i].name);
  }
  sort_best_first(contestants);
  return contestants;
}

plot::Figure figure_of(const Contestant& c, const TrainingTable& table,
                       const std::string& response) {
  plot::Figure figure(fmt::format("{}: predicted against actual", c.name),
                      {.label = fmt::format("{}, actual", response)},
                      {.label = fmt::format("{}, predicted without the row's fold", response)});
  for (Eigen::Index r = 0; r < c.validation.predicted.cols(); ++r) {
    const Vector predicted = c.validation.predicted.col(r);
    figure.scatter({table.data.y.data(), static_cast<std::size_t>(table.data.y.size())},
                   {predicted.data(), static_cast<std::size_t>(predicted.size())},
                   c.validation.predicted.cols() == 1 ? "" : fmt::format("repetition {}", r + 1));
  }
  const auto& m = c.validation.metrics;
  figure.diagonal();
  figure.note(fmt::format("RMSE {}, R2 {}", cell(m.rmse), cell(m.r2, "{:.3f}")));
  return figure;
}

void write_figures(const CompareOptions& options, const std::vector<Contestant>& contestants,
                   const TrainingTable& table) {
  if (options.figures.empty()) return;
  for (const auto& c : contestants)
    if (c.validation.metrics.rows > 0)
      write_file_atomically(std::filesystem::path(options.figures) / (c.name + ".svg"),
                            figure_of(c, table, options.columns.response).svg());
  if (!options.common.json) fmt::print("\nfigures written to {}\n", options.figures);
}

void print_text(const CompareOptions& options, const std::vector<Contestant>& contestants,
                std::size_t folds) {
  const auto& first = contestants.front().validation;
  fmt::print("{}: {} rows, {} folds{}\n\n", options.columns.response, first.predicted.rows(), folds,
             options.columns.group.empty()
                 ? ""
                 : fmt::format(", each a {} left out", options.columns.group));
  fmt::print("{:<25}{:>11}{:>9}{:>9}{:>11}{:>9}{:>10}{:>14}\n", "model", "RMSE", "R2", "corr^2",
             "MAE", "NLPD", "fit s", "predictions/s");
  for (const auto& c : contestants) {
    const auto& m = c.validation.metrics;
    fmt::print("{:<25}{:>11}{:>9}{:>9}{:>11}{:>9}{:>10}{:>14}\n", c.name, cell(m.rmse),
               cell(m.r2, "{:.3f}"), cell(m.squared_correlation, "{:.3f}"), cell(m.mae),
               cell(m.negative_log_density, "{:.3f}"), cell(c.fit_seconds, "{:.3g}"),
               cell(c.predictions_per_second, "{:.2g}"));
    if (const auto failure = failure_of(c); !failure.empty()) fmt::print("    {}\n", failure);
  }
  fmt::print("\nfitted to all rows:\n");
  for (const auto& c : contestants)
    if (c.failure.empty()) fmt::print("{}", described(c.name, c.description));
}

nlohmann::json json_of(const CompareOptions& options, const std::vector<Contestant>& contestants) {
  nlohmann::json models = nlohmann::json::array();
  for (const auto& c : contestants) {
    nlohmann::json model = to_json(c.validation.metrics);
    nlohmann::json folds = nlohmann::json::array();
    for (const auto& fold : c.validation.folds) folds.push_back(to_json(fold));
    model["model"] = c.name;
    model["failure"] = failure_of(c);
    model["fitted"] = c.description;
    model["fit_seconds"] =
        std::isfinite(c.fit_seconds) ? nlohmann::json(c.fit_seconds) : nlohmann::json();
    model["predictions_per_second"] = std::isfinite(c.predictions_per_second)
                                          ? nlohmann::json(c.predictions_per_second)
                                          : nlohmann::json();
    model["folds"] = std::move(folds);
    models.push_back(std::move(model));
  }
  return {{"response", options.columns.response}, {"models", std::move(models)}};
}

void compare(CompareOptions options) {
  const TrainingTable table = read_training_table(options.columns);
  const auto folds = options.columns.group.empty()
                         ? surrogate::k_folds(table.data, {.folds = options.folds,
                                                           .repetitions = options.repetitions,
                                                           .seed = options.validation.seed})
                         : surrogate::leave_group_out(table.data, table.group_names);
  if (options.validation.models.empty())
    for (const auto& preset : surrogate::model_presets())
      options.validation.models.push_back(preset.name);
  options.validation.search = {.evaluations = options.optimise,
                               .initial_points = std::min(4, options.optimise),
                               .folds = options.inner};
  if (!options.figures.empty()) make_directory(options.figures);
  const auto contestants = run_all(options, table, folds);
  if (options.common.json)
    fmt::print("{}\n", json_of(options, contestants).dump(2));
  else
    print_text(options, contestants, folds.size());
  write_figures(options, contestants, table);
  if (std::all_of(contestants.begin(), contestants.end(),
                  [](const Contestant& c) { return c.validation.metrics.rows == 0; }))
    throw InputError("no model could be fitted and predicted in any fold");
}

}  // namespace

void add_compare(CLI::App& app) {
  auto o = std::make_shared<CompareOptions>();
  auto* command =
      add_command(app, "compare", "Every model on the same folds of a table, best first",
                  "repose compare runs.h5 --response shear_angle_deg --figures figures", o->common);
  add_training_columns(command, &o->columns);
  add_replicate_column(command, &o->columns);
  command->add_option("--group", o->columns.group, "column: each of its groups is left out once");
  command->add_option("--model", o->validation.models, "names; else all ('?' lists them)")
      ->delimiter(',');
  auto* folds = command->add_option("--folds", o->folds, "rows by chance; without --group")
                    ->capture_default_str()
                    ->check(CLI::Range(2, 100000));
  auto* repetitions =
      command->add_option("--repetitions", o->repetitions, "of the folds, divided anew")
          ->capture_default_str()
          ->check(CLI::Range(1, 1000));
  for (auto* option : {folds, repetitions}) option->excludes("--group");
  command->add_option("--optimise", o->optimise, "settings tried by optimisable models")
      ->capture_default_str()
      ->check(CLI::Range(2, 100000));
  command->add_option("--inner", o->inner, "folds in which they are tried")
      ->capture_default_str()
      ->check(CLI::Range(2, 100000));
  command->add_option("--figures", o->figures, "folder for predicted against actual, in SVG");
  command->add_option("--threads", o->validation.threads, "0: one for each processor")
      ->capture_default_str();
  command->add_option("--seed", o->validation.seed)->capture_default_str();
  command->callback([o] { compare(*o); });
}

}  // namespace repose::cli

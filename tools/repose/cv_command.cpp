// repose cv: the error of models in nested cross-validation.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "validation.hpp"

namespace repose::cli {
namespace {

struct CvOptions {
  CommonOptions common;
  TrainingColumns columns;
  ValidationOptions validation;
  std::string outer = "kfold:5";
  std::string inner = "kfold:5";
  int optimise = 0;  ///< 0: 50, and models are meant as they are called
};

int whole_number(std::string_view text, const std::string& option) {
  int value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size())
    throw InputError(fmt::format("{}: '{}' is not a whole number", option, text));
  return value;
}

/// "kfold:10" or "kfold:10x3".
surrogate::KFoldOptions parse_k_folds(const std::string& text, const std::string& option) {
  constexpr std::string_view kPrefix = "kfold:";
  if (!text.starts_with(kPrefix))
    throw InputError(fmt::format("{} {}: write kfold:10, or kfold:10x3 to repeat it{}", option,
                                 text, option == "--outer" ? ", or leave-group-out:COLUMN" : ""));
  const std::string_view rest = std::string_view(text).substr(kPrefix.size());
  const auto times = rest.find('x');
  surrogate::KFoldOptions folds{.folds = whole_number(rest.substr(0, times), option)};
  if (times != std::string_view::npos)
    folds.repetitions = whole_number(rest.substr(times + 1), option);
  return folds;
}

/// The column of leave-group-out:COLUMN, else empty.
std::string group_column(const std::string& outer) {
  constexpr std::string_view kPrefix = "leave-group-out:";
  return outer.starts_with(kPrefix) ? outer.substr(kPrefix.size()) : std::string();
}

std::vector<surrogate::Fold> outer_folds(const CvOptions& options, const TrainingTable& table) {
  if (!options.columns.group.empty())
    return surrogate::leave_group_out(table.data, table.group_names);
  surrogate::KFoldOptions folds = parse_k_folds(options.outer, "--outer");
  folds.seed = options.validation.seed;
  return surrogate::k_folds(table.data, folds);
}

/// Mean and standard deviation over the folds that have a value.
std::string spread(const surrogate::CrossValidation& result, double surrogate::Metrics::*figure) {
  std::vector<double> values;
  for (const auto& fold : result.folds)
    if (std::isfinite(fold.metrics.*figure)) values.push_back(fold.metrics.*figure);
  if (values.size() < 2) return "-";
  const Eigen::Map<const Vector> v(values.data(), static_cast<Eigen::Index>(values.size()));
  const double sd =
      std::sqrt((v.array() - v.mean()).square().sum() / static_cast<double>(v.size() - 1));
  return fmt::format("{:.4g} ± {:.2g}", v.mean(), sd);
}

void print_row(const std::string& name, const surrogate::Metrics& m, const std::string& seconds) {
  fmt::print("{:<24}{:>6}{:>11}{:>9}{:>12}{:>11}{:>10}{:>9}\n", name.substr(0, 23), m.rows,
             cell(m.rmse), cell(m.r2, "{:.3f}"), cell(m.squared_correlation, "{:.3f}"), cell(m.mae),
             cell(m.negative_log_density, "{:.3f}"), seconds);
}

void print_text(const CvOptions& options, const std::vector<surrogate::CrossValidation>& results) {
  for (std::size_t m = 0; m < results.size(); ++m) {
    const auto& result = results[m];
    fmt::print("{}{}: {} by {}\n\n", m == 0 ? "" : "\n", options.columns.response,
               options.validation.models[m], options.outer);
    fmt::print("{:<24}{:>6}{:>11}{:>9}{:>12}{:>11}{:>10}{:>9}\n", "left out", "rows", "RMSE", "R2",
               "corr^2", "MAE", "NLPD", "fit s");
    for (const auto& fold : result.folds) {
      if (fold.failure.empty())
        print_row(fold.name, fold.metrics, fmt::format("{:.3g}", fold.training_seconds));
      else
        fmt::print("{:<24}failed: {}\n", fold.name.substr(0, 23), fold.failure);
    }
    print_row("all rows together", result.metrics, "");
    fmt::print("{:<24}RMSE {}, R2 {}, MAE {}\n", "mean ± sd over folds",
               spread(result, &surrogate::Metrics::rmse), spread(result, &surrogate::Metrics::r2),
               spread(result, &surrogate::Metrics::mae));
    fmt::print("\n");
    for (const auto& fold : result.folds) {
      if (fold.failure.empty()) fmt::print("{}", described(fold.name, fold.description));
      if (!fold.note.empty()) fmt::print("{}", described(fold.name, fold.note));
    }
  }
}

nlohmann::json json_of(const CvOptions& options,
                       const std::vector<surrogate::CrossValidation>& results) {
  nlohmann::json models = nlohmann::json::array();
  for (std::size_t m = 0; m < results.size(); ++m) {
    nlohmann::json folds = nlohmann::json::array();
    for (const auto& fold : results[m].folds) folds.push_back(to_json(fold));
    nlohmann::json model = to_json(results[m].metrics);
    model["model"] = options.validation.models[m];
    model["failed_folds"] = results[m].failed_folds;
    model["folds"] = std::move(folds);
    models.push_back(std::move(model));
  }
  return {{"response", options.columns.response},
          {"outer", options.outer},
          {"inner", options.inner},
          {"models", std::move(models)}};
}

/// With --optimise, "gpr", "svm", ... mean the search of that kind.
void name_searched_models(CvOptions& options) {
  for (auto& model : options.validation.models)
    for (const auto& preset : surrogate::model_presets())
      if (preset.searched && preset.name == "optimisable-" + model) model = preset.name;
}

void cross_validate(CvOptions options) {
  options.columns.group = group_column(options.outer);
  if (options.optimise > 0) name_searched_models(options);
  const auto inner = parse_k_folds(options.inner, "--inner");
  if (inner.repetitions != 1) throw InputError("--inner takes no repetitions: write kfold:10");
  options.validation.search.folds = inner.folds;
  if (options.optimise > 0) {
    options.validation.search.evaluations = options.optimise;
    options.validation.search.initial_points = std::min(4, options.optimise);
  }
  const TrainingTable table = read_training_table(options.columns);
  const auto results = validate(table, outer_folds(options, table), options.validation,
                                options.common.progress_style());
  if (options.common.json)
    fmt::print("{}\n", json_of(options, results).dump(2));
  else
    print_text(options, results);
  if (std::all_of(results.begin(), results.end(),
                  [](const auto& r) { return r.failed_folds == static_cast<int>(r.folds.size()); }))
    throw InputError("no fold could be fitted and predicted");
}

}  // namespace

void add_cv(CLI::App& app) {
  auto o = std::make_shared<CvOptions>();
  auto* command = add_command(app, "cv", "The error of models at rows left out, search included",
                              "repose cv runs.h5 --response rsd --model gpr --optimise 50\n"
                              "           --outer leave-group-out:layering --inner kfold:10",
                              o->common);
  add_training_columns(command, &o->columns);
  add_replicate_column(command, &o->columns);
  command
      ->add_option("--model", o->validation.models,
                   "names, as in repose compare; with --optimise also svm, tree, ...")
      ->delimiter(',')
      ->required();
  command->add_option("--outer", o->outer, "leave-group-out:COLUMN, kfold:N or kfold:NxTIMES")
      ->capture_default_str();
  command->add_option("--inner", o->inner, "folds in which settings are searched")
      ->capture_default_str();
  command->add_option("--optimise", o->optimise, "settings tried in each search; else 50")
      ->check(CLI::Range(2, 100000));
  command->add_option("--threads", o->validation.threads, "0: one for each processor")
      ->capture_default_str();
  command->add_option("--seed", o->validation.seed)->capture_default_str();
  command->callback([o] { cross_validate(*o); });
}

}  // namespace repose::cli

// repose fit: a surrogate of one column of a table.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "fit_trees.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/presets.hpp"
#include "repose/surrogate/selection.hpp"
#include "repose/surrogate/tuning.hpp"
#include "training_data.hpp"

namespace repose::cli {
namespace {

using surrogate::GaussianProcess;
using surrogate::GaussianProcessOptions;

constexpr std::string_view kNoiseColumn = "column:";

struct FitOptions {
  CommonOptions common;
  TrainingColumns columns;
  std::vector<std::string> bounds;
  std::string model = "gpr";
  std::string kernel = "ard-matern52";
  std::string basis = "constant";
  std::string noise = "estimated";
  std::string estimator = "reml";
  std::string prior;
  std::string parameter_uncertainty = "first-order";
  std::string response_scale = "linear";
  std::string output;
  bool select = false;
  int optimise = 0;
  int starts = 5;
  TreeFitOptions trees;
  std::uint64_t seed = 1;
};

Vector vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void set_noise(GaussianProcessOptions& gp, const std::string& text, const table::Table& table) {
  if (text.starts_with(kNoiseColumn)) {
    gp.noise = surrogate::Noise::known;
    gp.noise_variances = vector_of(table.numbers(text.substr(kNoiseColumn.size())));
  } else {
    gp.noise = text == "none"       ? surrogate::Noise::none
               : text == "by-point" ? surrogate::Noise::by_point
                                    : surrogate::Noise::estimated;
  }
}

/// NAME=VALUE fixes, NAME=LOWER:UPPER bounds; the name of an input is that of its length scale.
surrogate::ParameterBounds parse_bounds(const std::string& text,
                                        const std::vector<std::string>& inputs) {
  const auto equals = text.find('=');
  const auto colon = text.find(':', equals == std::string::npos ? 0 : equals);
  surrogate::ParameterBounds b{.name = text.substr(0, equals)};
  const auto number = [&text](std::size_t begin, std::size_t end) {
    double value = 0.0;
    const char* last = text.data() + std::min(end, text.size());
    const auto read = std::from_chars(text.data() + begin, last, value);
    if (read.ec != std::errc() || read.ptr != last)
      throw InputError(
          fmt::format("--bound {}: write NAME=VALUE or NAME=LOWER:UPPER, e.g. alpha=1", text));
    return value;
  };
  const auto first = equals == std::string::npos ? text.size() : equals + 1;
  b.lower = number(first, colon);
  b.upper = colon == std::string::npos ? b.lower : number(colon + 1, text.size());
  for (std::size_t k = 0; k < inputs.size(); ++k)
    if (inputs[k] == b.name) b.name = fmt::format("length_scale_{}", k + 1);
  return b;
}

GaussianProcessOptions model_options(const FitOptions& options, const table::Table& table,
                                     const std::vector<std::string>& inputs) {
  using namespace surrogate;
  GaussianProcessOptions gp;
  gp.kernel = kernel_named(options.kernel);
  gp.basis = basis_named(options.basis);
  set_noise(gp, options.noise, table);
  gp.response_scale = named(options.response_scale,
                            {ResponseScale::linear, ResponseScale::log, ResponseScale::logit});
  gp.estimator = named(options.estimator, {Estimator::ml, Estimator::reml, Estimator::loo});
  const bool jointly_robust =
      options.prior.empty() ? gp.estimator == Estimator::reml : options.prior == "jointly-robust";
  gp.prior = jointly_robust ? Prior::jointly_robust : Prior::none;
  gp.parameter_uncertainty =
      named(options.parameter_uncertainty,
            {ParameterUncertainty::ignored, ParameterUncertainty::first_order});
  for (const auto& text : options.bounds) gp.bounds.push_back(parse_bounds(text, inputs));
  gp.starts = options.starts;
  gp.seed = options.seed;
  gp.threads = 0;
  return gp;
}

struct Fitted {
  surrogate::NamedModel named;
  std::vector<surrogate::Candidate> candidates;
  std::vector<Eigen::Index> groups;
  std::vector<surrogate::TuningTrial> trials = {};
  std::size_t best_trial = 0;
};

TrainingTable read_data(const FitOptions& options) {
  TrainingColumns columns = options.columns;
  if (options.noise.starts_with(kNoiseColumn))
    columns.noise = options.noise.substr(kNoiseColumn.size());
  TrainingTable data = read_training_table(columns);
  if (data.group_names.size() == 1)
    throw InputError(fmt::format(
        "column {} has one value in all rows; leaving a group out needs two", columns.group));
  return data;
}

Fitted tune(const TrainingTable& table, const GaussianProcessOptions& gp,
            const FitOptions& options) {
  ProgressDisplay display("settings tried", options.common.progress_style());
  const auto& [x, y, inputs, weights, groups, replicates] = table.data;
  surrogate::TuningOptions tuning{.evaluations = options.optimise,
                                  .initial_points = std::min(4, options.optimise),
                                  .groups = groups,
                                  .seed = options.seed,
                                  .threads = 0,
                                  .progress = display.callback()};
  if (!groups.empty()) {
    const auto last = *std::max_element(groups.begin(), groups.end());
    tuning.folds = std::min(tuning.folds, static_cast<int>(last) + 1);
  }
  auto tuned = surrogate::tune_model(x, y, inputs, gp, tuning);
  return {{tuned.model, table.inputs, options.columns.response},
          {},
          groups,
          std::move(tuned.trials),
          tuned.best};
}

Fitted fit_model(const TrainingTable& table, const FitOptions& options) {
  const auto& [x, y, inputs, weights, groups, replicates] = table.data;
  const auto gp = model_options(options, table.rows, table.inputs);
  if (options.optimise > 0) return tune(table, gp, options);
  if (!options.select)
    return {{GaussianProcess::fit(x, y, inputs, gp), table.inputs, options.columns.response},
            {},
            groups};
  auto selection = surrogate::select_model(x, y, inputs, gp, {.groups = groups, .threads = 0});
  return {{selection.model, table.inputs, options.columns.response},
          std::move(selection.candidates),
          groups};
}

/// What a parameter is, in words of the table.
std::string label(const std::string& parameter, const std::vector<std::string>& inputs) {
  constexpr std::string_view kScale = "length_scale_";
  if (!parameter.starts_with(kScale)) return parameter;
  std::size_t end = 0;
  const std::string rest = parameter.substr(kScale.size());
  const auto k = static_cast<std::size_t>(std::stoul(rest, &end)) - 1;
  const std::string level = end < rest.size() ? ", level " + rest.substr(end + 1) : "";
  return "length scale of " + inputs.at(k) + level;
}

nlohmann::json to_json(const Fitted& fitted, const surrogate::LeftOut& out,
                       const std::string& file) {
  const auto& model = fitted.named.model;
  const auto& report = model.report();
  nlohmann::json parameters = nlohmann::json::array();
  for (const auto& p : report.parameters)
    parameters.push_back({{"name", p.name},
                          {"meaning", label(p.name, fitted.named.inputs)},
                          {"value", p.value},
                          {"lower", p.lower},
                          {"upper", p.upper},
                          {"state", to_string(p.state)},
                          {"relevance", p.relevance}});
  nlohmann::json candidates = nlohmann::json::array();
  for (const auto& c : fitted.candidates)
    candidates.push_back({{"kernel", to_string(c.kernel)},
                          {"basis", to_string(c.basis)},
                          {"log_density", c.log_density},
                          {"q2", c.q2},
                          {"rmse", c.rmse},
                          {"coverage95", c.coverage95},
                          {"negative_log_likelihood", c.negative_log_likelihood},
                          {"seconds", c.seconds},
                          {"failure", c.failure}});
  nlohmann::json trials = nlohmann::json::array();
  for (const auto& t : fitted.trials)
    trials.push_back({{"kernel", to_string(t.kernel)},
                      {"basis", to_string(t.basis)},
                      {"noise_standard_deviation", t.noise_standard_deviation},
                      {"kernel_scale", t.kernel_scale},
                      {"standardised", t.standardised},
                      {"rmse", t.rmse},
                      {"failure", t.failure}});
  const auto hyper = model.hyperparameters();
  return {{"response", fitted.named.response},
          {"inputs", fitted.named.inputs},
          {"rows", model.rows()},
          {"kernel", to_string(model.kernel())},
          {"basis", to_string(model.basis())},
          {"estimator", to_string(model.estimator())},
          {"negative_log_likelihood", model.negative_log_likelihood()},
          {"parameters", parameters},
          {"process_variance", hyper.process_variance},
          {"noise_standard_deviation", std::sqrt(hyper.noise_variance)},
          {"loo_q2", out.q2},
          {"loo_rmse", out.rmse},
          {"loo_coverage95", out.coverage95},
          {"loo_log_density", out.log_density},
          {"left_out", fitted.groups.empty() ? "points" : "groups"},
          {"candidates", candidates},
          {"trials", trials},
          {"jitter", report.jitter},
          {"evaluations", report.evaluations},
          {"seconds", report.seconds},
          {"instruction_set", report.instruction_set},
          {"message", report.message},
          {"file", file}};
}

void print_text(const Fitted& fitted, const surrogate::LeftOut& out, const std::string& file) {
  const auto& model = fitted.named.model;
  const auto& report = model.report();
  if (!fitted.candidates.empty()) {
    fmt::print("{:<24} {:<10} {:>12} {:>8} {:>11} {:>6}\n", "kernel", "basis", "log density", "Q2",
               "rmse", "in 95%");
    for (const auto& c : fitted.candidates) {
      if (!c.failure.empty())
        fmt::print("{:<24} {:<10} {}\n", to_string(c.kernel), to_string(c.basis), c.failure);
      else
        fmt::print("{:<24} {:<10} {:>12.3f} {:>8.4f} {:>11.5g} {:>5.0f}%\n", to_string(c.kernel),
                   to_string(c.basis), c.log_density, c.q2, c.rmse, 100.0 * c.coverage95);
    }
    fmt::print("\n");
  }
  if (!fitted.trials.empty()) {
    const auto& best = fitted.trials[fitted.best_trial];
    fmt::print(
        "best of {} settings: {}, basis {}, noise {:.4g}{}{};\n"
        "error in cross-validation {:.5g}\n\n",
        fitted.trials.size(), to_string(best.kernel), to_string(best.basis),
        best.noise_standard_deviation,
        best.kernel.length_scales == surrogate::LengthScales::shared
            ? fmt::format(", length scale {:.4g}", best.kernel_scale)
            : "",
        best.kernel.length_scales == surrogate::LengthScales::shared && best.standardised
            ? ", inputs standardised"
            : "",
        best.rmse);
  }
  fmt::print("{} of {} rows and {} inputs, {}, basis {}, {:.2f} s\n\n", fitted.named.response,
             model.rows(), fitted.named.inputs.size(), to_string(model.kernel()),
             to_string(model.basis()), report.seconds);
  for (const auto& p : report.parameters)
    fmt::print("  {:<40} {:>12.5g}  {}\n", label(p.name, fitted.named.inputs), p.value,
               to_string(p.state));
  const char* what = fitted.groups.empty() ? "left-out rows" : "left-out groups";
  const auto line = [](const std::string& name, const std::string& value) {
    fmt::print("  {:<40} {:>12}\n", name, value);
  };
  line("standard deviation of the noise", fmt::format("{:.5g}", std::sqrt(model.noise_variance())));
  line("negative log likelihood", fmt::format("{:.5g}", model.negative_log_likelihood()));
  line(fmt::format("{}: Q2", what), fmt::format("{:.4f}", out.q2));
  line(fmt::format("{}: root mean square error", what), fmt::format("{:.5g}", out.rmse));
  line(fmt::format("{}: inside their 95 % interval", what),
       fmt::format("{:.0f}%", 100.0 * out.coverage95));
  line(fmt::format("{}: log density", what), fmt::format("{:.3f}", out.log_density));
  fmt::print("\nwritten to {}\n", file);
}

/// Of any model but the Gaussian process with its options.
surrogate::Trainer chosen_trainer(const FitOptions& options, unsigned threads) {
  if (is_tree_model(options.model))
    return tree_model_trainer(options.model, options.trees, threads);
  surrogate::SettingsSearchOptions search{.threads = threads};
  if (options.optimise > 0) {
    search.evaluations = options.optimise;
    search.initial_points = std::min(4, options.optimise);
  }
  return surrogate::preset_trainer(options.model, search);
}

FitMethod chosen_method(const FitOptions& options) {
  FitMethod method{.of_all_rows = chosen_trainer(options, 0), .of_folds = {}};
  if (!options.model.starts_with("optimisable-")) method.of_folds = chosen_trainer(options, 1);
  return method;
}

void fit(const FitOptions& options) {
  const TrainingTable table = read_data(options);
  if (options.model != "gpr")
    return fit_regressor(chosen_method(options), table.data, table.inputs, options.columns.response,
                         options.seed, options.output, options.common);
  const Fitted fitted = fit_model(table, options);
  surrogate::save_model(options.output, fitted.named);
  const auto& model = fitted.named.model;
  const auto out =
      fitted.groups.empty() ? model.leave_one_out() : model.leave_groups_out(fitted.groups);
  if (options.common.json)
    fmt::print("{}\n", to_json(fitted, out, options.output).dump(2));
  else
    print_text(fitted, out, options.output);
}

void add_model_options(CLI::App* command, FitOptions* o) {
  std::vector<std::string> kernels;
  for (const auto kernel : surrogate::all_kernels()) kernels.emplace_back(to_string(kernel));
  command
      ->add_option("--model", o->model,
                   "gpr, tree, bagged-trees, boosted-trees, or a name of repose compare")
      ->capture_default_str();
  command
      ->add_option("--kernel", o->kernel,
                   "correlation; ard-: a scale for each input; a wrong name lists all")
      ->capture_default_str()
      ->check(CLI::IsMember(kernels).description(""));
  command->add_option("--basis", o->basis, "trend")
      ->capture_default_str()
      ->check(CLI::IsMember({"none", "constant", "linear", "quadratic"}));
  command->add_flag("--select", o->select,
                    "try all kernels and bases, keep the best at predicting rows left out");
  command
      ->add_option("--optimise", o->optimise,
                   "tune kernel, basis, noise and scaling by that many cross-validations")
      ->check(CLI::Range(2, 100000));
  command->add_option("--group", o->columns.group, "column whose groups are left out together");
  command
      ->add_option("--noise", o->noise,
                   "estimated, none, by-point (repeats), column:NAME (variances)")
      ->capture_default_str()
      ->check(CLI::Validator(
          [](const std::string& s) {
            const bool known = s == "estimated" || s == "none" || s == "by-point";
            return known || s.starts_with(kNoiseColumn)
                       ? std::string()
                       : "'" + s + "' is not estimated, none, by-point or column:NAME";
          },
          "NOISE"));
  command->add_option("--estimator", o->estimator, "what is maximised")
      ->capture_default_str()
      ->check(CLI::IsMember({"reml", "ml", "loo"}));
  command->add_option("--prior", o->prior, "jointly-robust (with reml) or none (else)")
      ->check(CLI::IsMember({"jointly-robust", "none"}));
  command
      ->add_option("--parameter-uncertainty", o->parameter_uncertainty,
                   "first-order: variances know that these are estimates (not loo)")
      ->capture_default_str()
      ->check(CLI::IsMember({"first-order", "ignored"}));
  command->add_option("--bound", o->bounds,
                      "NAME=VALUE or NAME=LOWER:UPPER of a parameter; an input: its scale");
  command->add_option("--response-scale", o->response_scale, "model y, log y or log(y/(1-y))")
      ->capture_default_str()
      ->check(CLI::IsMember({"linear", "log", "logit"}));
}

}  // namespace

void add_fit(CLI::App& app) {
  auto o = std::make_shared<FitOptions>();
  auto* command =
      add_command(app, "fit", "Fits a surrogate of one column of a table",
                  "repose fit quick/runs.h5 --response shear_angle_deg -o shear.h5", o->common);
  add_training_columns(command, &o->columns);
  add_model_options(command, o.get());
  add_tree_options(command, &o->trees);
  command->add_option("--starts", o->starts, "of the likelihood's search")
      ->capture_default_str()
      ->check(CLI::Range(1, 10000));
  command->add_option("--seed", o->seed)->capture_default_str();
  command->add_option("-o,--output", o->output, "model file to write")->required();
  command->callback([o, command] {
    refuse_options_of_other_models(*command, o->model);
    if (o->optimise > 0)
      refuse_options(
          *command,
          {"--select", "--bound", "--prior", "--kernel", "--basis", "--noise", "--estimator"},
          "with --optimise, which searches or sets it itself");
    fit(*o);
  });
}

}  // namespace repose::cli

// repose transfer: a model of known configurations adapted to a new one.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "model_columns.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/surrogate/transfer_validation.hpp"
#include "repose/table/io.hpp"
#include "validation.hpp"

namespace repose::cli {
namespace {

using Order = surrogate::TransferValidationOptions::Order;

struct TransferCliOptions {
  CommonOptions common;
  TrainingColumns columns;
  surrogate::TransferValidationOptions validation;
  std::vector<std::string> methods;  ///< empty: by what is done
  std::string order = "random";
  int optimise = 50;
  std::string target;  ///< a group: adapt to it, instead of trying out
  std::string output;
  int next = 0;
  std::string next_table;
};

std::string with_deviation(const surrogate::Spread& s, int decimals) {
  if (std::isnan(s.mean)) return "-";
  if (std::isnan(s.deviation)) return fmt::format("{:.{}f}", s.mean, decimals);
  return fmt::format("{:.{}f} ± {:.{}f}", s.mean, decimals, s.deviation, decimals);
}

/// So many that the smallest error shown has three digits.
int decimals_of(const surrogate::TransferValidation& v) {
  double smallest = v.all_seen.rmse.mean;
  for (const auto& s : v.means)
    if (s.unseen.rmse.mean > 0.0) smallest = std::fmin(smallest, s.unseen.rmse.mean);
  if (!(smallest > 0.0)) return 4;
  return std::clamp(2 - static_cast<int>(std::floor(std::log10(smallest))), 0, 9);
}

/// Characters of UTF-8.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; }));
}

/// A figure's column.
std::string right(const std::string& text) {
  constexpr std::size_t kWidth = 20;
  const std::size_t width = width_of(text);
  return std::string(width < kWidth ? kWidth - width : 1, ' ') + text;
}

/// The columns before the figures: a name and a number of rows.
class Margin {
 public:
  explicit Margin(const TrainingTable& table) {
    for (const auto& name : table.group_names) width_ = std::max(width_, width_of(name) + 1);
  }
  std::string operator()(const std::string& name, const std::string& rows = "") const {
    return name + std::string(width_ - std::min(width_, width_of(name)), ' ') +
           fmt::format("{:>5}", rows);
  }

 private:
  std::size_t width_ = 14;  // "all were seen"
};

std::string name_of(const surrogate::TransferScore& score, const TrainingTable& table) {
  return score.group < 0 ? "mean" : table.group_names[static_cast<std::size_t>(score.group)];
}

void print_errors(const std::vector<const surrogate::TransferScore*>& scores,
                  const surrogate::SpreadMetrics& all_seen, const TrainingTable& table,
                  int decimals) {
  const Margin margin(table);
  fmt::print("{}{}{}{}{}\n", margin("unseen", "rows"), right("RMSE validation"),
             right("RMSE unseen"), right("MAE validation"), right("MAE unseen"));
  fmt::print("{}{}{}{}\n", margin("all were seen"), right(with_deviation(all_seen.rmse, decimals)),
             right(""), right(with_deviation(all_seen.mae, decimals)));
  for (const auto* s : scores)
    fmt::print("{}{}{}{}{}\n", margin(name_of(*s, table), std::to_string(s->samples)),
               right(with_deviation(s->validation.rmse, decimals)),
               right(with_deviation(s->unseen.rmse, decimals)),
               right(with_deviation(s->validation.mae, decimals)),
               right(with_deviation(s->unseen.mae, decimals)));
}

void print_agreement(const std::vector<const surrogate::TransferScore*>& scores,
                     const surrogate::SpreadMetrics& all_seen, const TrainingTable& table) {
  const Margin margin(table);
  fmt::print("{}{}{}{}{}\n", margin("unseen", "rows"), right("R2 validation"), right("R2 unseen"),
             right("corr^2 unseen"), right("correlation"));
  fmt::print("{}{}\n", margin("all were seen"), right(with_deviation(all_seen.r2, 2)));
  for (const auto* s : scores)
    fmt::print("{}{}{}{}{}\n", margin(name_of(*s, table), std::to_string(s->samples)),
               right(with_deviation(s->validation.r2, 2)), right(with_deviation(s->unseen.r2, 2)),
               right(with_deviation(s->unseen.squared_correlation, 2)),
               right(with_deviation(s->correlation, 2)));
}

void print_text(const TransferCliOptions& options, const TrainingTable& table,
                const surrogate::TransferValidation& v) {
  const int decimals = decimals_of(v);
  for (const auto method : options.validation.methods) {
    std::vector<const surrogate::TransferScore*> scores;
    for (const auto* all : {&v.scores, &v.means})
      for (const auto& s : *all)
        if (s.method == method) scores.push_back(&s);
    fmt::print("{}: {} transferred by {}, mean ± deviation over {} seeds\n\n",
               options.columns.response, options.validation.model, to_string(method),
               options.validation.seeds);
    print_errors(scores, v.all_seen, table, decimals);
    fmt::print("\n");
    print_agreement(scores, v.all_seen, table);
    fmt::print("\n");
    for (const auto* s : scores)
      if (!s->failure.empty())
        fmt::print("{}", described(fmt::format("{}, {} rows", name_of(*s, table), s->samples),
                                   s->failure));
  }
  if (!v.all_seen_failure.empty())
    fmt::print("{}", described("all were seen, validation", v.all_seen_failure));
  fmt::print(
      "validation: rows left out in {} folds of those it was fitted to; unseen: rows of the group\n"
      "that were not given. R2 is negative where the mean would be better; corr^2 forgives a "
      "shift\n"
      "and a factor. correlation: estimated, of the group's function and the others'.\n",
      options.validation.folds);
}

nlohmann::json to_json(const surrogate::Spread& s) {
  return {{"mean", number_or_null(s.mean)}, {"deviation", number_or_null(s.deviation)}};
}

nlohmann::json to_json(const surrogate::SpreadMetrics& m) {
  return {{"rmse", to_json(m.rmse)},
          {"r2", to_json(m.r2)},
          {"squared_correlation", to_json(m.squared_correlation)},
          {"mae", to_json(m.mae)},
          {"negative_log_density", to_json(m.negative_log_density)}};
}

nlohmann::json to_json(const surrogate::TransferScore& s, const TrainingTable& table) {
  return {{"group", s.group < 0 ? nlohmann::json() : nlohmann::json(name_of(s, table))},
          {"samples", s.samples},
          {"method", to_string(s.method)},
          {"validation", to_json(s.validation)},
          {"unseen", to_json(s.unseen)},
          {"correlation", to_json(s.correlation)},
          {"averaged", s.averaged},
          {"failure", s.failure}};
}

void try_out(TransferCliOptions& options, const TrainingTable& table) {
  if (table.group_names.size() < 2)
    throw InputError(
        fmt::format("column {} has one value in all rows; transfer needs a group to "
                    "learn from and another",
                    options.columns.group));
  ProgressDisplay display("groups and seeds", options.common.progress_style());
  options.validation.progress = display.callback();
  options.validation.undeclared = table.undeclared;
  const auto result = surrogate::validate_transfer(table.data, options.validation);
  display.finish();
  if (!options.common.json) return print_text(options, table, result);
  nlohmann::json scores = nlohmann::json::array(), means = nlohmann::json::array();
  for (const auto& s : result.scores) scores.push_back(to_json(s, table));
  for (const auto& s : result.means) means.push_back(to_json(s, table));
  fmt::print("{}\n", nlohmann::json{{"response", options.columns.response},
                                    {"model", options.validation.model},
                                    {"seeds", options.validation.seeds},
                                    {"all_seen", to_json(result.all_seen)},
                                    {"all_seen_failure", result.all_seen_failure},
                                    {"scores", std::move(scores)},
                                    {"means", std::move(means)}}
                         .dump(2));
}

/// The new group's rows without a response: what may be simulated next.
struct Waiting {
  std::vector<std::size_t> rows;  ///< of the table, from 0
  table::Table table;
  Matrix x;  ///< where --next asks for some
};

/// Throws InputError naming a row of the table where a value is missing.
void check_values(const Waiting& waiting, const TrainingTable& training) {
  for (Eigen::Index i = 0; i < waiting.x.rows(); ++i)
    for (Eigen::Index k = 0; k < waiting.x.cols(); ++k)
      if (!std::isfinite(waiting.x(i, k)))
        throw InputError(
            fmt::format("row {}, column {} is {}; a row that could be simulated needs all inputs: "
                        "fill it in or take the row out",
                        waiting.rows[static_cast<std::size_t>(i)] + 1,
                        training.inputs[static_cast<std::size_t>(k)], waiting.x(i, k)));
}

Waiting waiting_rows(const TransferCliOptions& options, const TrainingTable& training) {
  const auto all =
      table::read_table(table::parse_location(options.columns.table), table::Missing::allow);
  const auto groups = known_labels_of(all, options.columns.group);
  const auto y = all.numbers(options.columns.response);
  Waiting waiting;
  for (std::size_t i = 0; i < groups.size(); ++i)
    if (groups[i] == options.target && std::isnan(y[i])) waiting.rows.push_back(i);
  if (options.next == 0 || waiting.rows.empty()) return waiting;
  waiting.table = all.selected_rows(waiting.rows);
  waiting.x = input_matrix(waiting.table, training.inputs, training.data.inputs, waiting.rows);
  check_values(waiting, training);
  return waiting;
}

struct Split {
  surrogate::TrainingSet source, target;
};

Split split(const TransferCliOptions& options, const TrainingTable& table) {
  const auto& names = table.group_names;
  const auto found = std::find(names.begin(), names.end(), options.target);
  const auto number = static_cast<Eigen::Index>(found - names.begin());
  std::vector<Eigen::Index> source, target;
  for (Eigen::Index i = 0; i < table.data.rows(); ++i)
    (table.data.groups[static_cast<std::size_t>(i)] == number ? target : source).push_back(i);
  if (source.empty())
    throw InputError(
        fmt::format("all rows with a response belong to {}; there is nothing to "
                    "transfer from",
                    options.target));
  // ranges as when it was tried out: those of the configurations known
  Split rows{with_own_ranges(selected_rows(table.data, source), table.undeclared),
             selected_rows(table.data, target)};
  rows.target.inputs = rows.source.inputs;
  return rows;
}

std::vector<Eigen::Index> choose_next(const TransferCliOptions& options,
                                      const surrogate::PretrainedModel& model, const Split& rows,
                                      const Waiting& waiting) {
  if (options.next == 0) return {};
  if (options.next > static_cast<int>(waiting.rows.size()))
    throw InputError(
        fmt::format("--next {}: {} rows of {} wait without a response; add rows with "
                    "an empty {} for the simulations that could be run",
                    options.next, waiting.rows.size(), options.target, options.columns.response));
  return surrogate::first_target_runs(model, rows.source, waiting.x, options.next, rows.target.x);
}

void write_next(const TransferCliOptions& options, const Waiting& waiting,
                const std::vector<Eigen::Index>& chosen) {
  if (options.next_table.empty()) return;
  std::vector<std::size_t> rows;
  for (const Eigen::Index i : chosen) rows.push_back(static_cast<std::size_t>(i));
  table::write_table(table::parse_location(options.next_table), waiting.table.selected_rows(rows));
}

void adapt(TransferCliOptions& options, const TrainingTable& table) {
  const Split rows = split(options, table);
  const Waiting waiting = waiting_rows(options, table);
  if (rows.target.rows() == 0 && waiting.rows.empty())
    throw InputError(fmt::format("column {} has no value '{}'; there are {}", options.columns.group,
                                 options.target, fmt::join(table.group_names, ", ")));
  auto& v = options.validation;
  check_possible(v.methods.front(), v.model);
  ProgressDisplay display("settings", options.common.progress_style());
  v.search.threads = v.threads;
  v.search.progress = display.callback();
  const auto model = surrogate::pretrained(v.model, rows.source, v.seed, v.search);
  display.finish();
  const auto found = surrogate::transfer(model, rows.source, rows.target,
                                         {.method = v.methods.front(), .seed = v.seed});
  const auto next = choose_next(options, model, rows, waiting);
  if (!options.output.empty())
    surrogate::save_regressor(options.output,
                              {found.model, table.inputs, options.columns.response});
  write_next(options, waiting, next);
  if (options.common.json) {
    nlohmann::json parts = nlohmann::json::array(), order = nlohmann::json::array();
    for (const auto& part : found.parts)
      parts.push_back({{"method", to_string(part.method)},
                       {"weight", part.weight},
                       {"left_out_rmse", number_or_null(part.left_out_rmse)},
                       {"failure", part.failure}});
    for (const Eigen::Index i : next)
      order.push_back(waiting.rows[static_cast<std::size_t>(i)] + 1);
    fmt::print("{}\n", nlohmann::json{{"response", options.columns.response},
                                      {"target", options.target},
                                      {"source_rows", rows.source.rows()},
                                      {"target_rows", rows.target.rows()},
                                      {"model", found.model.describe()},
                                      {"parts", parts},
                                      {"correlation", number_or_null(found.correlation)},
                                      {"correlation_deviation",
                                       number_or_null(found.correlation_deviation)},
                                      {"next", order},
                                      {"file", options.output}}
                           .dump(2));
    return;
  }
  fmt::print("{} of {}: {} rows of it, {} of others\n", options.columns.response, options.target,
             rows.target.rows(), rows.source.rows());
  fmt::print("{}", described("source", model.model.describe()));
  if (!found.parts.empty())
    fmt::print("\n{:<18}{:>8}{:>20}\n", "transferred by", "weight", "RMSE left out");
  for (const auto& part : found.parts)
    fmt::print("{:<18}{:>8.2f}{:>20}  {}\n", to_string(part.method), part.weight,
               cell(part.left_out_rmse), part.failure);
  if (std::isfinite(found.correlation))
    fmt::print("\ncorrelation of its function with the others': {}\n",
               with_deviation({found.correlation, found.correlation_deviation}, 2));
  else
    fmt::print("\ncorrelation of its function with the others': not known without its rows\n");
  if (!next.empty()) {
    fmt::print("\nto simulate next, in this order (rows of the table):");
    for (const Eigen::Index i : next)
      fmt::print(" {}", waiting.rows[static_cast<std::size_t>(i)] + 1);
    fmt::print("\n");
  }
  for (const std::string& file : {options.output, options.next_table})
    if (!file.empty()) fmt::print("written: {}\n", file);
}

void run(const CLI::App& command, TransferCliOptions options) {
  auto& v = options.validation;
  v.order = options.order == "variance" ? Order::variance : Order::random;
  v.search.evaluations = options.optimise;
  v.search.initial_points = std::min(4, options.optimise);
  v.search.folds = v.folds;
  if (!options.methods.empty()) v.methods.clear();
  for (const auto& name : options.methods)
    v.methods.push_back(surrogate::transfer_method_named(name));
  const bool adapts = !options.target.empty();
  if (adapts) {
    refuse_options(command, {"--samples", "--seeds", "--order"},
                   "with --target, whose rows with a response are used");
    if (options.methods.empty()) v.methods = {surrogate::TransferMethod::weighted};
    if (v.methods.size() > 1) throw UsageError("--target takes one --method");
    if (options.next == 0)
      refuse_options(command, {"--next-table"}, "without --next, how many rows to choose");
  } else {
    refuse_options(command, {"--output", "--next", "--next-table"},
                   "without --target, the new group");
  }
  const TrainingTable table = read_training_table(options.columns);
  if (adapts)
    adapt(options, table);
  else
    try_out(options, table);
}

}  // namespace

void add_transfer(CLI::App& app) {
  auto o = std::make_shared<TransferCliOptions>();
  auto* command = add_command(
      app, "transfer", "A model of known configurations adapted to a new one with few runs",
      "repose transfer runs.h5 --response rsd --group layering\n"
      "           repose transfer runs.h5 --response rsd --group layering --target L5 -o new.h5",
      o->common);
  add_training_columns(command, &o->columns);
  add_replicate_column(command, &o->columns);
  auto& v = o->validation;
  command->add_option("--group", o->columns.group, "column that tells configurations apart")
      ->required();
  command->add_option("--model", v.model, "a name, as in repose compare")->capture_default_str();
  command
      ->add_option("--method", o->methods,
                   "retrained, target-only, shift-and-scale, source-basis,\n"
                   "coregionalised, weighted; else retrained and weighted")
      ->delimiter(',');
  command->add_option("--samples", v.samples, "rows of the group taken as new that are given")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--seeds", v.seeds, "repetitions with other rows and starts")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_option("--order", o->order, "which rows first: by chance or by variance")
      ->capture_default_str()
      ->check(CLI::IsMember({"random", "variance"}));
  command->add_option("--target", o->target, "the new group: fit a model of it and write it");
  command->add_option("-o,--output", o->output, "model file, with --target");
  command->add_option("--next", o->next, "rows of --target without response to simulate next")
      ->check(CLI::Range(1, 100000));
  command->add_option("--next-table", o->next_table, "file for these rows, in order");
  command->add_option("--folds", v.folds, "of the validation and of searches")
      ->capture_default_str()
      ->check(CLI::Range(2, 1000));
  command->add_option("--optimise", o->optimise, "settings tried by models that search them")
      ->capture_default_str()
      ->check(CLI::Range(2, 100000));
  command
      ->add_option("--threads", v.threads,
                   "0: one for each processor; with --target those of a search")
      ->default_val(0u);
  command->add_option("--seed", v.seed)->capture_default_str();
  command->callback([o, command] { run(*command, *o); });
}

}  // namespace repose::cli

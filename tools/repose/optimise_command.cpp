// repose optimise: the best parameters by fitted models.
#include <fmt/format.h>

#include <cmath>
#include <mutex>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "model_set.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/cma_es.hpp"
#include "repose/opt/genetic.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct OptimiseOptions {
  CommonOptions common;
  ModelSetOptions models;
  std::string method = "cma-es";
  std::string output;
  int repeat = 10;
  opt::GeneticOptions genetic;
  opt::CmaEsOptions cma_es;
  std::uint64_t seed = 1;
};

opt::RepeatedSearch search(const ModelSet& models, const OptimiseOptions& options) {
  ProgressDisplay display(options.method, options.common.progress_style());
  std::mutex mutex;
  int done = 0;
  const opt::BatchObjective objective = [&](const Matrix& rows) {
    return models.objective_means(rows);
  };
  const auto once = [&](std::uint64_t seed) {
    const opt::FeasibleSet& set = models.space().set();
    opt::EvolutionResult result;
    if (options.method == "ga") {
      auto genetic = options.genetic;
      genetic.seed = seed;
      result = opt::minimize_genetic(objective, set, genetic);
    } else {
      auto cma_es = options.cma_es;
      cma_es.seed = seed;
      result = opt::minimize_cma_es(objective, set, cma_es);
    }
    const std::lock_guard lock(mutex);
    display.update(++done, options.repeat, "searches");
    return result;
  };
  return opt::repeat_search(once, options.repeat, options.seed, 0);
}

/// Natural values of each search, with what the models say there.
table::Table table_of(const ModelSet& models, const opt::RepeatedSearch& found) {
  Matrix points(static_cast<Eigen::Index>(found.results.size()), models.space().dimension());
  std::vector<double> value;
  std::vector<std::int64_t> best;
  for (std::size_t i = 0; i < found.results.size(); ++i) {
    points.row(static_cast<Eigen::Index>(i)) = models.space().natural(found.results[i].x);
    value.push_back(models.maximises() ? -found.results[i].value : found.results[i].value);
    best.push_back(i == found.best ? 1 : 0);
  }
  table::Table table = models.runs(points);
  table.add({.name = "objective", .range = {}, .values = value});
  table.add({.name = "best", .range = {}, .values = best});
  return table;
}

/// Names of the parameters' columns.
std::vector<std::string> parameter_names(const ModelSet& models) {
  std::vector<std::string> names;
  for (const auto& [name, value] :
       models.space().parameters().complete(Vector::Zero(models.space().dimension())))
    names.push_back(name);
  return names;
}

/// Mean and deviation of a column over the searches.
std::pair<double, double> spread(const std::vector<double>& values) {
  double mean = 0.0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  double square = 0.0;
  for (const double v : values) square += (v - mean) * (v - mean);
  const auto n = static_cast<double>(values.size());
  return {mean, n > 1.0 ? std::sqrt(square / (n - 1.0)) : 0.0};
}

std::int64_t evaluations_of(const opt::RepeatedSearch& found) {
  std::int64_t sum = 0;
  for (const auto& r : found.results) sum += r.evaluations;
  return sum;
}

nlohmann::json to_json(const table::Table& table, const ModelSet& models,
                       const opt::RepeatedSearch& found, const OptimiseOptions& options) {
  nlohmann::json parameters, predicted = nlohmann::json::array();
  for (const auto& name : parameter_names(models)) {
    nlohmann::json entry;
    const auto& column = table.column(name);
    std::visit([&](const auto& values) { entry["value"] = values[found.best]; }, column.values);
    if (std::holds_alternative<std::vector<double>>(column.values)) {
      const auto [mean, sd] = spread(table.numbers(name));
      entry["mean"] = mean;
      entry["standard_deviation"] = sd;
    }
    parameters[name] = entry;
  }
  for (const auto& model : models.models()) {
    nlohmann::json entry{
        {"response", model.response},
        {"predicted", table.numbers(model.response + "_predicted")[found.best]},
        {"function_sd", table.numbers(model.response + "_function_sd")[found.best]},
        {"extrapolated", table.numbers(model.response + "_extrapolated")[found.best] != 0.0}};
    for (const auto& t : models.targets())
      if (t.name == model.response) entry["target"] = t.value;
    predicted.push_back(entry);
  }
  return {{"objective", models.objective_name()},
          {"method", options.method},
          {"value", table.numbers("objective")[found.best]},
          {"values", table.numbers("objective")},
          {"parameters", parameters},
          {"predicted", predicted},
          {"evaluations", evaluations_of(found)},
          {"file", options.output}};
}

void print_text(const table::Table& table, const ModelSet& models, const opt::RepeatedSearch& found,
                const OptimiseOptions& options) {
  fmt::print("{}\n{:.5g} by {} ({} searches, {} evaluations)\n\n", models.objective_name(),
             table.numbers("objective")[found.best], options.method, found.results.size(),
             evaluations_of(found));
  fmt::print("  {:<32} {:>14} {:>14} {:>12}\n", "parameter", "best", "mean of all", "deviation");
  for (const auto& name : parameter_names(models)) {
    const auto& column = table.column(name);
    if (const auto* text = std::get_if<std::vector<std::string>>(&column.values)) {
      fmt::print("  {:<32} {:>14}\n", name, (*text)[found.best]);
      continue;
    }
    const auto values = table.numbers(name);
    const auto [mean, sd] = spread(values);
    fmt::print("  {:<32} {:>14.5g} {:>14.5g} {:>12.2g}{}\n", name, values[found.best], mean, sd,
               column.unit == "1" ? "" : " " + column.unit);
  }
  fmt::print("\n  {:<32} {:>14} {:>14} {:>12}\n", "response", "predicted", "deviation", "target");
  for (const auto& model : models.models()) {
    std::string target = "-";
    for (const auto& t : models.targets())
      if (t.name == model.response) target = fmt::format("{:.5g}", t.value);
    fmt::print("  {:<32} {:>14.5g} {:>14.2g} {:>12}\n", model.response,
               table.numbers(model.response + "_predicted")[found.best],
               table.numbers(model.response + "_function_sd")[found.best], target);
  }
  for (const auto& model : models.models())
    if (table.numbers(model.response + "_extrapolated")[found.best] != 0.0)
      fmt::print("\nthe runs of {} tell little there: simulate it before it is believed\n",
                 model.response);
  if (!options.output.empty()) fmt::print("\nwritten to {}\n", options.output);
}

void optimise(const OptimiseOptions& options) {
  const ModelSet models(options.models);
  models.refuse_names({"run", "objective", "best"});
  const auto found = search(models, options);
  if (!std::isfinite(found.results[found.best].value))
    throw Error(
        ErrorKind::numerical,
        "no point obeys the constraints and has a finite prediction; loosen the constraints");
  auto table = table_of(models, found);
  if (!options.output.empty()) {
    auto parents = options.models.models;
    if (!options.models.factors.empty()) parents.push_back(options.models.factors);
    table::stamp_provenance(table, command_line(), options.seed, parents);
    table::write_table(table::parse_location(options.output), table);
  }
  if (options.common.json)
    fmt::print("{}\n", to_json(table, models, found, options).dump(2));
  else
    print_text(table, models, found, options);
}

}  // namespace

void add_optimise(CLI::App& app) {
  auto o = std::make_shared<OptimiseOptions>();
  auto* command = add_command(
      app, "optimise", "Finds the parameters with the best prediction",
      "repose optimise angle.h5 mass.h5 --target angle_deg=38.2 --target mass_kg=1.4", o->common);
  add_model_set_options(*command, o->models);
  command->add_option("--method", o->method, "cma-es, or ga: a genetic algorithm")
      ->capture_default_str()
      ->check(CLI::IsMember({"ga", "cma-es"}));
  command->add_option("--repeat", o->repeat, "searches with other random numbers")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_option("--population", o->genetic.population, "of ga")
      ->capture_default_str()
      ->check(CLI::Range(2, 1000000));
  command->add_option("--generations", o->genetic.max_generations, "of ga, at most")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  command->add_option("--evaluations", o->cma_es.max_points, "of each search by cma-es, at most")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000000));
  command->add_option("--seed", o->seed)->capture_default_str();
  command->add_option("-o,--output", o->output, "table to write, a row a search (.h5 or .csv)");
  command->callback([o, command] {
    if (o->method == "ga")
      refuse_options(*command, {"--evaluations"}, "with --method ga");
    else
      refuse_options(*command, {"--population", "--generations"}, "with --method cma-es");
    optimise(*o);
  });
}

}  // namespace repose::cli

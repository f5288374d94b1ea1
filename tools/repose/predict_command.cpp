// repose predict: what a fitted surrogate says about the rows of a table.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "model_columns.hpp"
#include "repose/base/error.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct PredictOptions {
  CommonOptions common;
  std::string model;
  std::string table;
  std::string output;
  bool gradient = false;
};

/// Column suffix and values, in order.
using Columns = std::vector<std::pair<std::string, table::Values>>;

Columns predicted_columns(const surrogate::NamedModel& named, const Matrix& x) {
  std::vector<double> mean, sd, observation_sd;
  std::vector<std::int64_t> outside, far;
  for (const auto& p : named.model.predictions(x)) {
    mean.push_back(p.function.mean);
    sd.push_back(p.function.standard_deviation());
    observation_sd.push_back(std::sqrt(p.observation_variance));
    outside.push_back(p.outside_range ? 1 : 0);
    far.push_back(p.far_from_data ? 1 : 0);
  }
  return {{"predicted", mean},
          {"function_sd", sd},
          {"observation_sd", observation_sd},
          {"outside_range", outside},
          {"far_from_data", far}};
}

/// Derivatives of mean and standard deviation in each input, per unit of it.
Columns gradient_columns(const surrogate::NamedModel& named, const Matrix& x) {
  const auto d = named.inputs.size();
  std::vector<std::vector<double>> mean(d), sd(d);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto g = named.model.predict_gradient(x.row(i));
    for (std::size_t k = 0; k < d; ++k) {
      mean[k].push_back(g.mean[static_cast<Eigen::Index>(k)]);
      sd[k].push_back(g.standard_deviation[static_cast<Eigen::Index>(k)]);
    }
  }
  Columns columns;
  for (std::size_t k = 0; k < d; ++k) {
    columns.emplace_back("predicted_by_" + named.inputs[k], mean[k]);
    columns.emplace_back("function_sd_by_" + named.inputs[k], sd[k]);
  }
  return columns;
}

void print_json(const surrogate::NamedModel& named, const Columns& columns,
                const std::string& file) {
  nlohmann::json json{{"response", named.response}, {"file", file}};
  for (const auto& [suffix, values] : columns)
    std::visit([&json, &name = suffix](const auto& v) { json[name] = v; }, values);
  fmt::print("{}\n", json.dump(2));
}

std::int64_t count_of(const Columns& columns, const std::string& suffix) {
  for (const auto& [name, values] : columns)
    if (name == suffix) {
      const auto& flags = std::get<std::vector<std::int64_t>>(values);
      return std::count(flags.begin(), flags.end(), 1);
    }
  return 0;
}

void predict(const PredictOptions& options) {
  const auto named = surrogate::load_model(options.model);
  auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const Matrix x = input_matrix(table, named.inputs, named.model.inputs());
  if (!x.allFinite())
    throw InputError(fmt::format("{}: an input is missing; give every row a value", options.table));
  Columns columns = predicted_columns(named, x);
  if (options.gradient)
    for (auto& column : gradient_columns(named, x)) columns.push_back(std::move(column));
  for (const auto& [suffix, values] : columns)
    table.add({.name = named.response + "_" + suffix, .range = {}, .values = values});
  table::stamp_provenance(table, command_line(), std::nullopt, {options.model, options.table});
  table::write_table(table::parse_location(options.output), table);
  if (options.common.json) return print_json(named, columns, options.output);
  fmt::print("{} predicted for {} rows, written to {}\n", named.response, x.rows(), options.output);
  if (const auto n = count_of(columns, "outside_range"); n > 0)
    fmt::print("{} of them lie outside the range the model was fitted for\n", n);
  if (const auto n = count_of(columns, "far_from_data"); n > 0)
    fmt::print("{} of them lie so far from the data that these tell little of them\n", n);
}

}  // namespace

void add_predict(CLI::App& app) {
  auto o = std::make_shared<PredictOptions>();
  auto* command = add_command(app, "predict", "Predicts a response for every row of a table",
                              "repose predict shear.h5 points.csv -o predicted.csv", o->common);
  command->add_option("MODEL", o->model, "file written by repose fit")->required();
  command->add_option("TABLE", o->table, "FILE.h5, FILE.h5:/group or FILE.csv with the inputs")
      ->required();
  command->add_option("-o,--output", o->output, "the table with predictions added (.h5 or .csv)")
      ->required();
  command->add_flag("--gradient", o->gradient,
                    "add the derivatives of mean and standard deviation in each input");
  command->callback([o] { predict(*o); });
}

}  // namespace repose::cli

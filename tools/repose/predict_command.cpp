// repose predict: what a fitted surrogate says about the rows of a table.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "model_columns.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
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

Columns gaussian_process_columns(const surrogate::GaussianProcess& model, const Matrix& x) {
  std::vector<double> mean, sd, observation_sd;
  std::vector<std::int64_t> outside, far;
  for (const auto& p : model.predictions(x)) {
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

std::vector<std::int64_t> outside_range(const std::vector<surrogate::Input>& inputs,
                                        const Matrix& x) {
  std::vector<std::int64_t> outside(static_cast<std::size_t>(x.rows()), 0);
  for (std::size_t k = 0; k < inputs.size(); ++k)
    for (std::size_t i = 0; i < outside.size() && !inputs[k].is_categorical(); ++i) {
      const double value = x(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k));
      if (value < inputs[k].lower || value > inputs[k].upper) outside[i] = 1;
    }
  return outside;
}

/// A value that is not finite, as the deviation where the data determine nothing, is missing.
std::vector<double> cells_of(const Vector& values) {
  std::vector<double> cells(values.begin(), values.end());
  for (double& value : cells)
    if (!std::isfinite(value)) value = std::nan("");
  return cells;
}

/// Of the standard deviations those that the model knows.
Columns predicted_columns(const surrogate::Regressor& model, const Matrix& x) {
  if (const auto* process = surrogate::gaussian_process(model))
    return gaussian_process_columns(*process, x);
  const surrogate::Predictions p = model.predict_with_variances(x);
  Columns columns{{"predicted", cells_of(p.mean)}};
  if (p.function_variance.size() > 0)
    columns.emplace_back("function_sd", cells_of(p.function_variance.cwiseSqrt()));
  if (p.observation_variance.size() > 0)
    columns.emplace_back("observation_sd", cells_of(p.observation_variance.cwiseSqrt()));
  columns.emplace_back("outside_range", outside_range(model.inputs(), x));
  return columns;
}

/// Derivatives of mean and standard deviation in each input, per unit of it.
Columns gradient_columns(const surrogate::NamedRegressor& named, const Matrix& x) {
  const auto* process = surrogate::gaussian_process(named.model);
  if (process == nullptr)
    throw InputError(fmt::format(
        "--gradient needs a Gaussian process; the model is {}: fit one with --model gpr",
        named.model.describe()));
  const auto d = named.inputs.size();
  std::vector<std::vector<double>> mean(d), sd(d);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto g = process->predict_gradient(x.row(i));
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

void print_json(const surrogate::NamedRegressor& named, const Columns& columns,
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
  const auto named = surrogate::load_regressor(options.model);
  auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const Matrix x = input_matrix(table, named.inputs, named.model.inputs());
  if (!x.allFinite())
    throw InputError(fmt::format("{}: an input is missing; give every row a value", options.table));
  Columns columns = predicted_columns(named.model, x);
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
                    "add the derivatives of mean and standard deviation in each input (gpr)");
  command->callback([o] { predict(*o); });
}

}  // namespace repose::cli

// repose predict: what a fitted surrogate says about the rows of a table.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct PredictOptions {
  CommonOptions common;
  std::string model;
  std::string table;
  std::string output;
};

/// The model's inputs; ln_NAME is the logarithm of a column NAME where the table has no column
/// ln_NAME.
Matrix inputs_of(const table::Table& table, const std::vector<std::string>& inputs) {
  Matrix x(static_cast<Eigen::Index>(table.rows()), static_cast<Eigen::Index>(inputs.size()));
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const bool log = !table.has(inputs[k]) && inputs[k].starts_with("ln_");
    const auto values = table.numbers(log ? inputs[k].substr(3) : inputs[k]);
    for (std::size_t i = 0; i < values.size(); ++i)
      x(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          log ? std::log(values[i]) : values[i];
  }
  return x;
}

void predict(const PredictOptions& options) {
  const auto named = surrogate::load_model(options.model);
  auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const Matrix x = inputs_of(table, named.inputs);
  if (!x.allFinite())
    throw InputError(fmt::format("{}: an input is missing; give every row a value", options.table));
  const auto& bounds = named.model.declared_bounds();
  std::vector<double> mean, sd, observation_sd;
  std::vector<std::int64_t> outside;
  const auto predictions = named.model.predict_rows(x);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const auto& p = predictions[static_cast<std::size_t>(i)];
    mean.push_back(p.mean);
    sd.push_back(p.standard_deviation());
    observation_sd.push_back(std::sqrt(p.variance + named.model.noise_variance()));
    const auto row = x.row(i).transpose().array();
    outside.push_back((row < bounds.lower.array()).any() || (row > bounds.upper.array()).any() ? 1
                                                                                               : 0);
  }
  const auto add = [&](const std::string& suffix, table::Values values) {
    table.add({.name = named.response + suffix, .range = {}, .values = std::move(values)});
  };
  add("_predicted", mean);
  add("_function_sd", sd);
  add("_observation_sd", observation_sd);
  add("_outside_range", outside);
  table::stamp_provenance(table, command_line(), std::nullopt, {options.model, options.table});
  table::write_table(table::parse_location(options.output), table);
  const auto extrapolated = std::count(outside.begin(), outside.end(), 1);
  if (options.common.json) {
    fmt::print("{}\n", nlohmann::json{{"response", named.response},
                                      {"predicted", mean},
                                      {"function_sd", sd},
                                      {"observation_sd", observation_sd},
                                      {"outside_range", outside},
                                      {"file", options.output}}
                           .dump(2));
    return;
  }
  fmt::print("{} predicted for {} rows, written to {}\n", named.response, x.rows(), options.output);
  if (extrapolated > 0)
    fmt::print("{} of them lie outside the range the model was fitted for\n", extrapolated);
}

}  // namespace

void add_predict(CLI::App& app) {
  auto o = std::make_shared<PredictOptions>();
  auto* command = add_command(app, "predict", "Predicts a response for every row of a table",
                              "repose predict shear.h5 points.csv -o predicted.csv", o->common);
  command->add_option("MODEL", o->model, "file written by repose fit")->required();
  command->add_option("TABLE", o->table, "table with the model's inputs as columns")->required();
  command->add_option("-o,--output", o->output, "the table with predictions added (.h5 or .csv)")
      ->required();
  command->callback([o] { predict(*o); });
}

}  // namespace repose::cli

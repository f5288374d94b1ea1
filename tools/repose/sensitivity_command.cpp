// repose sensitivity: which inputs of a surrogate matter.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "command.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/surrogate/sensitivity.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct SensitivityCommandOptions {
  CommonOptions common;
  std::string model;
  std::string output;
  surrogate::SensitivityOptions sobol;
  surrogate::PartialDependenceOptions dependence;
};

using Dependences = std::vector<surrogate::PartialDependence>;
using Indices = std::vector<surrogate::InputSensitivity>;

void add(table::Table& table, const std::string& name, table::Values values) {
  table.add({.name = name, .range = {}, .values = std::move(values)});
}

table::Table indices_table(const std::vector<std::string>& inputs, const Indices& indices) {
  std::vector<std::vector<double>> columns(6);
  for (const auto& index : indices) {
    const double values[] = {index.first.value, index.first.lower, index.first.upper,
                             index.total.value, index.total.lower, index.total.upper};
    for (std::size_t c = 0; c < 6; ++c) columns[c].push_back(values[c]);
  }
  table::Table table;
  add(table, "input", inputs);
  const char* names[] = {"first", "first_lower", "first_upper",
                         "total", "total_lower", "total_upper"};
  for (std::size_t c = 0; c < 6; ++c) add(table, names[c], columns[c]);
  return table;
}

table::Table dependence_table(const std::vector<std::string>& inputs,
                              const Dependences& dependences) {
  std::vector<std::string> input;
  std::vector<double> x, mean, lower, upper;
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    const auto& d = dependences[k];
    input.insert(input.end(), d.x.size(), inputs[k]);
    x.insert(x.end(), d.x.begin(), d.x.end());
    mean.insert(mean.end(), d.mean.begin(), d.mean.end());
    lower.insert(lower.end(), d.lower.begin(), d.lower.end());
    upper.insert(upper.end(), d.upper.begin(), d.upper.end());
  }
  table::Table table;
  add(table, "input", input);
  add(table, "x", x);
  add(table, "mean", mean);
  if (lower.empty()) return table;
  add(table, "lower", lower);
  add(table, "upper", upper);
  return table;
}

void print_json(const surrogate::NamedRegressor& named, const Indices& indices,
                const Dependences& dependences) {
  const auto share = [](const surrogate::SobolIndex& s) {
    return nlohmann::json{{"value", s.value}, {"lower", s.lower}, {"upper", s.upper}};
  };
  nlohmann::json inputs = nlohmann::json::array();
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const auto& d = dependences[k];
    inputs.push_back({{"name", named.inputs[k]},
                      {"first", share(indices[k].first)},
                      {"total", share(indices[k].total)},
                      {"partial_dependence",
                       {{"x", d.x}, {"mean", d.mean}, {"lower", d.lower}, {"upper", d.upper}}}});
  }
  fmt::print("{}\n", nlohmann::json{{"response", named.response}, {"inputs", inputs}}.dump(2));
}

void print_text(const surrogate::NamedRegressor& named, const Indices& indices) {
  fmt::print("shares of the variance of {} over the declared ranges, with 95 % intervals\n",
             named.response);
  if (surrogate::gaussian_process(named.model) == nullptr)
    fmt::print("(of the integration alone: {})\n", named.model.describe());
  fmt::print("\n");
  fmt::print("  {:<32} {:^24} {:^24}\n", "input", "alone", "with interactions");
  for (std::size_t k = 0; k < indices.size(); ++k) {
    const auto& [first, total] = indices[k];
    fmt::print("  {:<32} {:>7.3f} [{:>6.3f}, {:>6.3f}] {:>7.3f} [{:>6.3f}, {:>6.3f}]\n",
               named.inputs[k], first.value, first.lower, first.upper, total.value, total.lower,
               total.upper);
  }
}

void sensitivity(const SensitivityCommandOptions& options) {
  const auto named = surrogate::load_regressor(options.model);
  const auto indices = surrogate::sobol_indices(named.model, options.sobol);
  Dependences dependences;
  for (Eigen::Index k = 0; k < named.model.dimension(); ++k)
    dependences.push_back(surrogate::partial_dependence(named.model, k, options.dependence));
  if (!options.output.empty()) {
    auto shares = indices_table(named.inputs, indices);
    auto dependence = dependence_table(named.inputs, dependences);
    for (auto* table : {&shares, &dependence})
      table::stamp_provenance(*table, command_line(), options.sobol.seed, {options.model});
    table::write_tables(options.output, {{"/sobol", shares}, {"/partial_dependence", dependence}});
  }
  if (options.common.json) return print_json(named, indices, dependences);
  print_text(named, indices);
  if (!options.output.empty())
    fmt::print("\nwith partial dependence written to {}\n", options.output);
}

}  // namespace

void add_sensitivity(CLI::App& app) {
  auto o = std::make_shared<SensitivityCommandOptions>();
  auto* command = add_command(app, "sensitivity", "Tells which inputs of a surrogate matter",
                              "repose sensitivity shear.h5 -o shear_sensitivity.h5", o->common);
  command->add_option("MODEL", o->model, "file written by repose fit")->required();
  command->add_option("--points", o->sobol.points, "quasi-random base points")
      ->capture_default_str()
      ->check(CLI::Range(8, 100000));
  command->add_option("--draws", o->sobol.draws, "of the function, for the intervals")
      ->capture_default_str()
      ->check(CLI::Range(20, 100000));
  command->add_option("--seed", o->sobol.seed)->capture_default_str();
  command->add_option("-o,--output", o->output,
                      "HDF5 file for the tables /sobol and /partial_dependence");
  command->callback([o] {
    o->dependence.seed = o->sobol.seed;
    sensitivity(*o);
  });
}

}  // namespace repose::cli

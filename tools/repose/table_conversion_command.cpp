// repose table import|export: tables of other programs into ours, and back.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "design_columns.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"
#include "repose/table/operations.hpp"

namespace repose::cli {
namespace {

using Names = std::vector<std::string>;

struct ImportOptions {
  CommonOptions common;
  std::string data;
  std::string output;
  Names responses, groups, replicates, variances, weights, ids;
  Names units;
  std::string factors;
  bool allow_missing = false;
  bool drop_missing = false;
};

struct ExportOptions {
  CommonOptions common;
  std::string table;
  std::string output;
  Names columns;
};

/// The roles named on the command line; each column has one.
std::map<std::string, table::Role> named_roles(const ImportOptions& options) {
  using table::Role;
  std::map<std::string, Role> roles;
  const auto add = [&](const Names& names, Role role) {
    for (const std::string& name : names)
      if (!roles.emplace(name, role).second)
        throw UsageError(fmt::format("column \"{}\" is given two roles, {} and {}; choose one",
                                     name, table::role_name(roles.at(name)),
                                     table::role_name(role)));
  };
  add(options.responses, Role::response);
  add(options.groups, Role::group);
  add(options.replicates, Role::replicate);
  add(options.variances, Role::variance);
  add(options.weights, Role::weight);
  add(options.ids, Role::id);
  return roles;
}

/// Columns of numbers that nothing else is known of vary from run to run: factors, unless a factors
/// file says which are.
table::Table with_known_roles(const table::Table& table, std::map<std::string, table::Role> roles,
                              const std::optional<ParameterSpace>& space) {
  if (space)
    for (const Parameter& parameter : space->parameters())
      if (const auto [at, is_new] = roles.emplace(parameter.name, table::Role::factor); !is_new)
        throw UsageError(fmt::format("column \"{}\" is a factor of the factors file and a {}",
                                     parameter.name, table::role_name(at->second)));
  for (const table::Column& column : table.columns())
    if (!space && column.role == table::Role::none &&
        !std::holds_alternative<std::vector<std::string>>(column.values))
      roles.emplace(column.name, table::Role::factor);
  return table::with_roles(table, roles);
}

/// Where the ranges of factors come from, for the user to know.
using RangeOrigins = std::map<std::string, std::string>;

/// Between the smallest and the largest value; nothing if there are not two.
std::optional<table::FactorRange> range_of_data(const table::Table& table,
                                                const std::string& name) {
  if (std::holds_alternative<std::vector<std::string>>(table.column(name).values))
    return std::nullopt;  // categories
  std::vector<double> values = table.numbers(name);
  std::erase_if(values, [](double value) { return std::isnan(value); });
  if (values.empty()) return std::nullopt;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (!(*least < *most)) return std::nullopt;
  return table::FactorRange{*least, *most, scale_of_levels(values)};
}

void take_parameter(table::Column& column, const Parameter& parameter,
                    const std::vector<double>& values, const std::string& file) {
  if (column.unit != "1" && parameter.unit != "1" && column.unit != parameter.unit)
    throw InputError(fmt::format("column \"{}\" has the unit {}, but {} says {}", column.name,
                                 column.unit, file, parameter.unit));
  if (parameter.unit != "1") column.unit = parameter.unit;
  column.range = table::FactorRange{parameter.lower, parameter.upper, parameter.scale};
  for (std::size_t row = 0; row < values.size(); ++row)
    if (values[row] < parameter.lower || values[row] > parameter.upper)
      throw InputError(fmt::format(
          "row {} of column \"{}\" is {}, outside its range [{}, {}] in {}; correct one of them",
          row + 1, column.name, shortest(values[row]), shortest(parameter.lower),
          shortest(parameter.upper), file));
}

/// Gives each factor without a range that of the factors file, or else that of its data.
table::Table with_ranges(const table::Table& table, const std::optional<ParameterSpace>& space,
                         const std::string& file, RangeOrigins& origins) {
  table::Table result;
  for (table::Column column : table.columns()) {
    if (column.role == table::Role::factor) {
      origins[column.name] = column.range ? "table" : "data";
      if (!space && !column.range) column.range = range_of_data(table, column.name);
      if (space)
        for (const Parameter& parameter : space->parameters())
          if (parameter.name == column.name) {
            take_parameter(column, parameter, table.numbers(column.name), file);
            origins[column.name] = "factors file";
          }
      if (!column.range) origins[column.name] = "none";
    }
    result.add(std::move(column));
  }
  result.attributes = table.attributes;
  return result;
}

table::Table with_units(const table::Table& table, const Names& units) {
  std::map<std::string, std::string> unit_of;
  for (const std::string& text : units) {
    const std::size_t equals = text.rfind('=');
    if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
      throw UsageError(fmt::format("--unit {}: write NAME=UNIT, e.g. flow=kg/s", text));
    unit_of[text.substr(0, equals)] = text.substr(equals + 1);
    static_cast<void>(table.column(text.substr(0, equals)));
  }
  table::Table result;
  for (table::Column column : table.columns()) {
    if (const auto unit = unit_of.find(column.name); unit != unit_of.end())
      column.unit = unit->second;
    result.add(std::move(column));
  }
  result.attributes = table.attributes;
  return result;
}

Names names_of_roles(const table::Table& table) {
  Names names = table.names_with_role(table::Role::factor);
  const Names responses = table.names_with_role(table::Role::response);
  names.insert(names.end(), responses.begin(), responses.end());
  return names;
}

nlohmann::json summary(const table::Table& table, const std::string& output) {
  return {{"file", output},
          {"rows", table.rows()},
          {"columns", table.names()},
          {"factors", table.names_with_role(table::Role::factor)},
          {"responses", table.names_with_role(table::Role::response)}};
}

void print(const CommonOptions& common, const nlohmann::json& summary) {
  if (common.json) {
    fmt::print("{}\n", summary.dump(2));
    return;
  }
  fmt::print("{} rows, {} columns in {}\n", summary["rows"].get<std::size_t>(),
             summary["columns"].size(), summary["file"].get<std::string>());
  for (const char* role : {"responses", "factors"})
    if (const auto names = summary[role].get<Names>(); !names.empty())
      fmt::print("{}: {}\n", role, listed(names));
}

std::string range_text(const table::Column& column, const std::string& origin) {
  if (!column.range) return "no range: its values do not differ";
  return fmt::format("{:.6g} ... {:.6g}{}, from the {}", column.range->lower, column.range->upper,
                     column.range->scale == Scale::log ? " (log)" : "", origin);
}

void print_import(const ImportOptions& options, const table::Table& table,
                  const RangeOrigins& origins) {
  auto json = summary(table, options.output);
  for (const auto& [name, origin] : origins) {
    auto& range = json["ranges"][name] = {{"from", origin}};
    if (const auto& known = table.column(name).range)
      range.update({{"lower", known->lower},
                    {"upper", known->upper},
                    {"scale", known->scale == Scale::log ? "log" : "linear"}});
  }
  print(options.common, json);
  if (options.common.json) return;
  for (const std::string& name : table.names_with_role(table::Role::factor))
    fmt::print("  {}: {}\n", name, range_text(table.column(name), origins.at(name)));
}

void import_table(const ImportOptions& options) {
  const auto roles = named_roles(options);
  std::optional<ParameterSpace> space;
  if (!options.factors.empty()) space = read_factors(options.factors);
  const bool may_miss = options.allow_missing || options.drop_missing;
  auto table = table::read_table(table::parse_location(options.data),
                                 may_miss ? table::Missing::allow : table::Missing::refuse);
  table = with_units(with_known_roles(table, roles, space), options.units);
  if (options.drop_missing) {
    const std::size_t before = table.rows();
    table = table.selected_rows(table::complete_rows(table, names_of_roles(table)));
    if (table.rows() < before && !options.common.quiet)
      fmt::print(stderr, "repose: {} of {} rows lack a factor or a response and are left out\n",
                 before - table.rows(), before);
  }
  RangeOrigins origins;
  table = with_ranges(table, space, options.factors, origins);
  Names parents{options.data};
  if (space) parents.push_back(options.factors);
  table::stamp_provenance(table, command_line(), std::nullopt, parents);
  table::write_table(table::parse_location(options.output), table);
  print_import(options, table, origins);
}

void export_table(const ExportOptions& options) {
  auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  if (!options.columns.empty()) table = table::selected_columns(table, options.columns);
  table::write_table(table::parse_location(options.output), table);
  print(options.common, summary(table, options.output));
}

void add_import(CLI::App& group) {
  auto options = std::make_shared<ImportOptions>();
  auto* command = add_command(
      group, "import", "Reads a table of another program and says what its columns are",
      "repose table import runs.csv -o runs.h5 --response angle_deg --group lab\n"
      "Columns of numbers that no option names become factors, in the range of their values,\n"
      "unless --factors names the factors and their ranges. DATA is CSV, HDF5 of h5py,\n"
      "PyTables or pandas, or MATLAB v7.3; FILE:/path names a table inside a file.",
      options->common);
  command->add_option("DATA", options->data, "FILE.csv, FILE.h5, FILE.h5:/path, FILE.mat:/name")
      ->required();
  command->add_option("-o,--output", options->output, "table to write")->required();
  const auto names = [&](const char* flag, Names& to, const char* description) {
    command->add_option(flag, to, description)->delimiter(',')->type_name("NAME");
  };
  names("--response", options->responses, "columns that were measured or simulated");
  names("--group", options->groups, "columns that separate data: material, laboratory");
  names("--replicate", options->replicates, "column that numbers repetitions");
  names("--variance", options->variances, "variances of responses");
  names("--weight", options->weights, "weights of rows");
  names("--id", options->ids, "columns that name rows");
  command->add_option("--factors", options->factors,
                      "TOML file with the factors' names, ranges and\nunits, as for repose design");
  command->add_option("--unit", options->units, "unit of a column, e.g. flow=kg/s")
      ->delimiter(',')
      ->type_name("NAME=UNIT");
  auto* allow = command->add_flag("--allow-missing", options->allow_missing,
                                  "keep missing values instead of refusing them");
  command
      ->add_flag("--drop-missing", options->drop_missing,
                 "leave out rows that lack a factor or a response")
      ->excludes(allow);
  command->callback([options] { import_table(*options); });
}

void add_export(CLI::App& group) {
  auto options = std::make_shared<ExportOptions>();
  auto* command = add_command(
      group, "export", "Writes a table as CSV, or as an HDF5 file of its own",
      "repose table export study/runs.h5 -o runs.csv --columns run,angle_deg", options->common);
  command->add_option("TABLE", options->table, "FILE.h5, FILE.h5:/group or FILE.csv")->required();
  command->add_option("-o,--output", options->output, "FILE.csv or FILE.h5")->required();
  command->add_option("--columns", options->columns, "these only, in this order")
      ->delimiter(',')
      ->type_name("NAME");
  command->callback([options] { export_table(*options); });
}

}  // namespace

void add_table_conversions(CLI::App& table) {
  add_import(table);
  add_export(table);
}

}  // namespace repose::cli

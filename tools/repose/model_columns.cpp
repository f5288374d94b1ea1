#include "model_columns.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::cli {
namespace {

bool is_text(const table::Column& column) {
  return std::holds_alternative<std::vector<std::string>>(column.values);
}

surrogate::Input category(const table::Column& column, surrogate::Coding coding) {
  const auto& values = std::get<std::vector<std::string>>(column.values);
  const std::set<std::string> levels(values.begin(), values.end());
  return {.levels = {levels.begin(), levels.end()}, .coding = coding};
}

surrogate::Input number(const table::Table& table, const table::Column& column, bool log) {
  const auto values = table.numbers(column.name);
  surrogate::Input input{.lower = *std::min_element(values.begin(), values.end()),
                         .upper = *std::max_element(values.begin(), values.end())};
  if (column.range)
    input = {
        .lower = column.range->lower, .upper = column.range->upper, .scale = column.range->scale};
  if (log) input.scale = Scale::log;
  if (!(input.lower < input.upper))
    throw InputError(
        fmt::format("column {} is {} in every row: nothing can be learnt from it; leave it out by "
                    "naming the others with --input",
                    column.name, shortest(input.lower)));
  return input;
}

Vector level_numbers(const table::Table& table, const std::string& name,
                     const surrogate::Input& input, const std::vector<std::size_t>& rows) {
  const auto& values = table.texts(name);
  Vector numbers(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto found = std::find(input.levels.begin(), input.levels.end(), values[i]);
    if (found == input.levels.end())
      throw InputError(fmt::format("row {}, column {}: '{}' is no level; the model knows {}",
                                   (rows.empty() ? i : rows[i]) + 1, name, values[i],
                                   fmt::join(input.levels, ", ")));
    numbers[static_cast<Eigen::Index>(i)] = static_cast<double>(found - input.levels.begin());
  }
  return numbers;
}

}  // namespace

std::vector<surrogate::Input> inputs_from_columns(const table::Table& table,
                                                  const std::vector<std::string>& names,
                                                  const std::vector<std::string>& log_names,
                                                  surrogate::Coding coding) {
  for (const auto& log : log_names)
    if (std::find(names.begin(), names.end(), log) == names.end())
      throw InputError(fmt::format("--log names {}, which is no input; these are {}", log,
                                   fmt::join(names, ", ")));
  std::vector<surrogate::Input> inputs;
  for (const auto& name : names) {
    const auto& column = table.column(name);
    const bool log = std::find(log_names.begin(), log_names.end(), name) != log_names.end();
    inputs.push_back(is_text(column) ? category(column, coding) : number(table, column, log));
  }
  return inputs;
}

Matrix input_matrix(const table::Table& table, const std::vector<std::string>& names,
                    const std::vector<surrogate::Input>& inputs,
                    const std::vector<std::size_t>& numbers) {
  Matrix x(static_cast<Eigen::Index>(table.rows()), static_cast<Eigen::Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k) {
    auto column = x.col(static_cast<Eigen::Index>(k));
    if (inputs[k].is_categorical()) {
      column = level_numbers(table, names[k], inputs[k], numbers);
      continue;
    }
    const auto values = table.numbers(names[k]);
    column = Eigen::Map<const Vector>(values.data(), column.size());
  }
  return x;
}

std::vector<std::string> known_labels_of(const table::Table& table, const std::string& name) {
  if (is_text(table.column(name))) return table.texts(name);
  std::vector<std::string> labels;
  for (const double value : table.numbers(name))
    labels.push_back(std::isnan(value) ? "" : shortest(value));
  return labels;
}

std::vector<std::string> labels_of(const table::Table& table, const std::string& name) {
  auto labels = known_labels_of(table, name);
  if (const auto missing = std::count(labels.begin(), labels.end(), ""); missing > 0)
    throw InputError(
        fmt::format("column {} has no value in {} of {} rows that are used; give each row one, or "
                    "take those rows out",
                    name, missing, labels.size()));
  return labels;
}

}  // namespace repose::cli

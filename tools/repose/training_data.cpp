#include "training_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "model_columns.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

bool is_text(const table::Column& column) {
  return std::holds_alternative<std::vector<std::string>>(column.values);
}

std::vector<std::string> input_names(const table::Table& table, const TrainingColumns& columns) {
  if (!columns.inputs.empty()) return columns.inputs;
  auto names = table.names_with_role(table::Role::factor);
  if (names.empty())
    for (const auto& c : table.columns())
      if (c.role == table::Role::none && c.name != columns.response && c.name != columns.group &&
          c.name != columns.replicate && c.name != columns.noise && !is_text(c))
        names.push_back(c.name);
  if (names.empty())
    throw InputError("the table has no column to predict from; name them with --input");
  return names;
}

table::Table usable_rows(const table::Table& table, const std::string& response) {
  const auto y = table.numbers(response);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < y.size(); ++i)
    if (!std::isnan(y[i])) rows.push_back(i);
  if (rows.empty()) throw InputError(fmt::format("column {} has no value", response));
  return table.selected_rows(rows);
}

/// A number for each different value of a column, in order of their first rows.
std::vector<Eigen::Index> numbered(const table::Table& table, const std::string& name,
                                   std::vector<std::string>& labels) {
  std::vector<Eigen::Index> numbers;
  std::map<std::string, Eigen::Index> known;
  for (const auto& value : labels_of(table, name)) {
    const auto [at, is_new] = known.try_emplace(value, static_cast<Eigen::Index>(labels.size()));
    if (is_new) labels.push_back(value);
    numbers.push_back(at->second);
  }
  return numbers;
}

}  // namespace

void add_training_columns(CLI::App* command, TrainingColumns* columns) {
  command->add_option("TABLE", columns->table, "FILE.h5, FILE.h5:/group or FILE.csv")->required();
  command->add_option("--response", columns->response, "column to predict")->required();
  command
      ->add_option("--input", columns->inputs,
                   "columns to predict from (text: categories); else the factors")
      ->delimiter(',');
  command
      ->add_option("--log", columns->log_inputs, "inputs on a log scale, besides those declared so")
      ->delimiter(',');
  command->add_option("--coding", columns->coding, "of categories")
      ->capture_default_str()
      ->check(CLI::IsMember({"label", "one-hot", "exchangeable"}));
}

void add_replicate_column(CLI::App* command, TrainingColumns* columns) {
  command->add_option("--replicate", columns->replicate,
                      "column whose equal values repeat a point; else rows with equal inputs");
}

TrainingTable read_training_table(const TrainingColumns& columns) {
  TrainingTable result{.rows = usable_rows(table::read_table(table::parse_location(columns.table),
                                                             table::Missing::allow),
                                           columns.response)};
  const table::Table& table = result.rows;
  result.inputs = input_names(table, columns);
  surrogate::TrainingSet& data = result.data;
  data.inputs = inputs_from_columns(
      table, result.inputs, columns.log_inputs,
      named(columns.coding, {surrogate::Coding::label, surrogate::Coding::one_hot,
                             surrogate::Coding::exchangeable}));
  for (const auto& name : result.inputs)
    result.undeclared.push_back(!table.column(name).range.has_value());
  data.x = input_matrix(table, result.inputs, data.inputs);
  const auto y = table.numbers(columns.response);
  data.y = Eigen::Map<const Vector>(y.data(), static_cast<Eigen::Index>(y.size()));
  if (!columns.group.empty()) data.groups = numbered(table, columns.group, result.group_names);
  std::vector<std::string> ignored;
  if (!columns.replicate.empty()) data.replicates = numbered(table, columns.replicate, ignored);
  surrogate::check(data);
  return result;
}

}  // namespace repose::cli

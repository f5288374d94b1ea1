#include "repose/table/table.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::table {
namespace {

constexpr std::array<std::pair<Role, const char*>, 8> kRoleNames = {{
    {Role::none, "none"},
    {Role::factor, "factor"},
    {Role::response, "response"},
    {Role::group, "group"},
    {Role::replicate, "replicate"},
    {Role::variance, "variance"},
    {Role::weight, "weight"},
    {Role::id, "id"},
}};

const char* type_name(const Values& values) {
  constexpr std::array<const char*, 3> kNames = {"decimal numbers", "integers", "text"};
  return kNames[values.index()];
}

template <class T>
std::vector<T> at_rows(const std::vector<T>& values, const std::vector<std::size_t>& rows) {
  std::vector<T> result;
  result.reserve(rows.size());
  for (const std::size_t row : rows) result.push_back(values[row]);
  return result;
}

std::int64_t exact_integer(double value, std::string_view column, std::size_t row) {
  // 2^63 is a double, 2^63 - 1 is not.
  constexpr double kLimit = 9223372036854775808.0;
  if (!(value >= -kLimit && value < kLimit) || value != std::floor(value))
    throw InputError(fmt::format("column \"{}\" holds {} in row {}; an integer is needed", column,
                                 shortest(value), row + 1));
  return static_cast<std::int64_t>(value);
}

}  // namespace

std::string role_name(Role role) {
  for (const auto& [known, name] : kRoleNames)
    if (known == role) return name;
  throw Error(ErrorKind::internal, fmt::format("role {} has no name", static_cast<int>(role)));
}

Role role_from_name(std::string_view name) {
  std::vector<std::string> known;
  for (const auto& [role, role_text] : kRoleNames) {
    if (name == role_text) return role;
    known.emplace_back(role_text);
  }
  throw InputError(
      fmt::format("\"{}\" is not the role of a column; roles are {}", name, listed(known)));
}

Column factor_column(const Parameter& parameter, std::vector<double> values) {
  if (parameter.kind == ParameterKind::categorical) {
    std::vector<std::string> names;
    for (const double value : values)
      names.push_back(parameter.categories.at(static_cast<std::size_t>(value)));
    return Column{.name = parameter.name, .role = Role::factor, .values = std::move(names)};
  }
  return Column{.name = parameter.name,
                .unit = parameter.unit,
                .role = Role::factor,
                .range = FactorRange{parameter.lower, parameter.upper, parameter.scale},
                .values = std::move(values)};
}

std::size_t length(const Values& values) {
  return std::visit([](const auto& v) { return v.size(); }, values);
}

void Table::add(Column column) {
  if (column.name.empty()) throw InputError("a column of a table has no name; give it one");
  if (has(column.name))
    throw InputError(
        fmt::format("the table has a column \"{}\" already; names must differ", column.name));
  if (!columns_.empty() && length(column.values) != rows())
    throw InputError(
        fmt::format("column \"{}\" has {} rows, but the table has {}; columns must be equally long",
                    column.name, length(column.values), rows()));
  columns_.push_back(std::move(column));
}

std::size_t Table::rows() const {
  return columns_.empty() ? 0 : length(columns_.front().values);
}

std::vector<std::string> Table::names() const {
  std::vector<std::string> result;
  for (const Column& column : columns_) result.push_back(column.name);
  return result;
}

std::vector<std::string> Table::names_with_role(Role role) const {
  std::vector<std::string> result;
  for (const Column& column : columns_)
    if (column.role == role) result.push_back(column.name);
  return result;
}

bool Table::has(std::string_view name) const {
  for (const Column& column : columns_)
    if (column.name == name) return true;
  return false;
}

const Column& Table::column(std::string_view name) const {
  for (const Column& column : columns_)
    if (column.name == name) return column;
  if (columns_.empty())
    throw InputError(fmt::format("the table has no column \"{}\"; it has none at all", name));
  const std::string suggestion = closest_name(name, names());
  throw InputError(
      suggestion.empty()
          ? fmt::format("the table has no column \"{}\"; it has {}", name, listed(names()))
          : fmt::format("the table has no column \"{}\"; did you mean \"{}\"?", name, suggestion));
}

std::vector<double> Table::numbers(std::string_view name) const {
  const Values& values = column(name).values;
  if (const auto* doubles = std::get_if<std::vector<double>>(&values)) return *doubles;
  if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&values))
    return {integers->begin(), integers->end()};
  throw InputError(fmt::format("column \"{}\" holds text; numbers are needed", name));
}

std::vector<std::int64_t> Table::integers(std::string_view name) const {
  const Values& values = column(name).values;
  if (const auto* integers = std::get_if<std::vector<std::int64_t>>(&values)) return *integers;
  const std::vector<double> doubles = numbers(name);
  std::vector<std::int64_t> result;
  result.reserve(doubles.size());
  for (std::size_t row = 0; row < doubles.size(); ++row)
    result.push_back(exact_integer(doubles[row], name, row));
  return result;
}

const std::vector<std::string>& Table::texts(std::string_view name) const {
  const Values& values = column(name).values;
  if (const auto* texts = std::get_if<std::vector<std::string>>(&values)) return *texts;
  throw InputError(fmt::format("column \"{}\" holds {}; text is needed", name, type_name(values)));
}

Matrix Table::matrix(const std::vector<std::string>& names) const {
  Matrix result(static_cast<Eigen::Index>(rows()), static_cast<Eigen::Index>(names.size()));
  for (std::size_t j = 0; j < names.size(); ++j) {
    const std::vector<double> values = numbers(names[j]);
    result.col(static_cast<Eigen::Index>(j)) =
        Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size()));
  }
  return result;
}

Table Table::selected_rows(const std::vector<std::size_t>& rows) const {
  for (const std::size_t row : rows)
    REPOSE_ASSERT(row < this->rows(), fmt::format("row {} of {}", row, this->rows()));
  Table result;
  result.attributes = attributes;
  for (const Column& column : columns_) {
    Column selected{column.name, column.unit, column.role, column.range, {}};
    selected.values = std::visit(
        [&](const auto& values) -> Values { return at_rows(values, rows); }, column.values);
    result.columns_.push_back(std::move(selected));
  }
  return result;
}

void stamp_provenance(Table& table, const std::string& command_line,
                      std::optional<std::uint64_t> seed, const std::vector<std::string>& parents) {
  table.attributes["repose_version"] = std::string(version());
  table.attributes["command_line"] = command_line;
  table.attributes["parents"] = parents;
  table.attributes.erase("seed");
  if (!seed) return;
  if (*seed > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
    throw InputError(fmt::format("seed {} is above 2^63 - 1; choose a smaller one", *seed));
  table.attributes["seed"] = static_cast<std::int64_t>(*seed);
}

}  // namespace repose::table

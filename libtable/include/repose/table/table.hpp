// A table in memory: named columns of equal length that know their unit and what they are for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::table {

/// What a column is for. `variance` belongs to a measured response, `group` separates data that
/// must not be mixed (a material, a laboratory), `replicate` numbers repetitions of one point.
enum class Role { none, factor, response, group, replicate, variance, weight, id };

/// "factor", "response", ... as in files; "none" for Role::none.
std::string role_name(Role role);
/// Throws InputError naming the roles that exist.
Role role_from_name(std::string_view name);

/// Where a factor may vary, in the column's unit.
struct FactorRange {
  double lower = 0.0;
  double upper = 1.0;
  Scale scale = Scale::linear;
  bool operator==(const FactorRange&) const = default;
};

/// NaN in a column of doubles means that the value is missing.
using Values =
    std::variant<std::vector<double>, std::vector<std::int64_t>, std::vector<std::string>>;

struct Column {
  std::string name;
  std::string unit = "1";  ///< SI, e.g. "kg/s"; "1" is dimensionless
  Role role = Role::none;
  std::optional<FactorRange> range = std::nullopt;
  Values values = {};
};

/// A column that holds `values` of a parameter, with the role factor: numbers with unit and range,
/// or the names of a categorical one.
Column factor_column(const Parameter& parameter, std::vector<double> values);

/// What a file can say about a table or a group as a whole.
using Attribute =
    std::variant<double, std::int64_t, std::string, std::vector<double>, std::vector<std::string>>;
using Attributes = std::map<std::string, Attribute>;

/// Columns of equal length with unique names, in order. A name that is not there throws InputError
/// with the closest one or those that exist.
class Table {
 public:
  /// Appends a column. Throws InputError if its name is empty or taken, or its length differs.
  void add(Column column);

  std::size_t rows() const;
  const std::vector<Column>& columns() const { return columns_; }
  std::vector<std::string> names() const;
  std::vector<std::string> names_with_role(Role role) const;

  bool has(std::string_view name) const;
  const Column& column(std::string_view name) const;

  /// Values as doubles, integers converted. Throws InputError for text.
  std::vector<double> numbers(std::string_view name) const;
  /// Throws InputError unless the column holds integers, or doubles that all are.
  std::vector<std::int64_t> integers(std::string_view name) const;
  /// Throws InputError for numbers.
  const std::vector<std::string>& texts(std::string_view name) const;
  /// rows() x names.size(), as numbers() gives them.
  Matrix matrix(const std::vector<std::string>& names) const;

  /// The same columns and attributes with these rows, in this order; a row may repeat.
  Table selected_rows(const std::vector<std::size_t>& rows) const;

  /// Provenance and whatever else belongs to the whole table.
  Attributes attributes;

 private:
  std::vector<Column> columns_;
};

/// Number of values, whatever their type.
std::size_t length(const Values& values);

/// Writes into the attributes where the table came from: `repose_version`, `command_line`, `seed`
/// (if any; at most 2^63 - 1) and `parents`, the files it was computed from.
void stamp_provenance(Table& table, const std::string& command_line,
                      std::optional<std::uint64_t> seed, const std::vector<std::string>& parents);

}  // namespace repose::table

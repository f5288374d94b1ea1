#include "repose/table/operations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

#include "repose/base/error.hpp"

namespace repose::table {
namespace {

constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

bool is_text(const Column& column) {
  return std::holds_alternative<Texts>(column.values);
}

void append_bytes(std::string& key, std::uint64_t bits) {
  for (int shift = 0; shift < 64; shift += 8) key += static_cast<char>((bits >> shift) & 0xff);
}

void append_number(std::string& key, double value) {
  append_bytes(key, std::bit_cast<std::uint64_t>(value + 0.0));  // -0.0 equals 0.0
}

enum class Compare { exactly, as_doubles };

/// Adds what tells `column`'s value in `row` from all others.
void append_key(std::string& key, const Column& column, std::size_t row, Compare compare) {
  if (const auto* texts = std::get_if<Texts>(&column.values)) {
    append_bytes(key, (*texts)[row].size());
    key += (*texts)[row];
  } else if (const auto* integers = std::get_if<Integers>(&column.values)) {
    if (compare == Compare::exactly)
      append_bytes(key, static_cast<std::uint64_t>((*integers)[row]));
    else
      append_number(key, static_cast<double>((*integers)[row]));
  } else {
    const double value = std::get<Doubles>(column.values)[row];
    if (std::isnan(value))
      throw InputError(fmt::format(
          "row {} of the key column \"{}\" has no value; drop the row or choose another key",
          row + 1, column.name));
    append_number(key, value);
  }
}

/// The key of each row.
Texts row_keys(const Table& table, const Texts& names, const std::vector<Compare>& compare) {
  Texts keys(table.rows());
  for (std::size_t k = 0; k < names.size(); ++k) {
    const Column& column = table.column(names[k]);
    for (std::size_t row = 0; row < keys.size(); ++row)
      append_key(keys[row], column, row, compare[k]);
  }
  return keys;
}

void need_keys(const Texts& keys, const char* what) {
  if (keys.empty()) throw InputError(fmt::format("{} needs at least one key column", what));
}

/// How the keys of two tables compare; refuses text against numbers.
std::vector<Compare> comparisons(const Table& left, const Table& right, const Texts& keys) {
  std::vector<Compare> result;
  for (const std::string& key : keys) {
    const Column& a = left.column(key);
    const Column& b = right.column(key);
    if (is_text(a) != is_text(b))
      throw InputError(fmt::format(
          "the key column \"{}\" holds text in one table and numbers in the other", key));
    result.push_back(a.values.index() == b.values.index() ? Compare::exactly : Compare::as_doubles);
  }
  return result;
}

constexpr std::size_t kNoRow = std::numeric_limits<std::size_t>::max();

/// `rows` of a column; kNoRow gives a missing value.
Values picked(const Values& values, const std::vector<std::size_t>& rows, Join kind) {
  const auto pick = [&rows](const auto& from, auto result, const auto& missing) {
    result.reserve(rows.size());
    for (const std::size_t row : rows) {
      if (row == kNoRow)
        result.push_back(missing);
      else
        result.push_back(static_cast<std::decay_t<decltype(missing)>>(from[row]));
    }
    return Values(std::move(result));
  };
  if (const auto* texts = std::get_if<Texts>(&values)) return pick(*texts, Texts{}, std::string());
  if (const auto* doubles = std::get_if<Doubles>(&values))
    return pick(*doubles, Doubles{}, kMissing);
  const auto& integers = std::get<Integers>(values);
  for (const std::size_t row : rows)
    if (row == kNoRow && kind == Join::left) return pick(integers, Doubles{}, kMissing);
  return pick(integers, Integers{}, std::int64_t{0});
}

struct Moments {
  double mean = kMissing;
  double variance = kMissing;
};

Moments moments(const Doubles& values, const std::vector<std::size_t>& rows) {
  double sum = 0.0;
  double n = 0.0;
  for (const std::size_t row : rows) {
    if (std::isnan(values[row])) continue;
    sum += values[row];
    n += 1.0;
  }
  if (n == 0.0) return {};
  const double mean = sum / n;
  double squares = 0.0;
  for (const std::size_t row : rows)
    if (!std::isnan(values[row])) squares += (values[row] - mean) * (values[row] - mean);
  return {mean, n < 2.0 ? kMissing : squares / (n - 1.0)};
}

std::string squared(const std::string& unit) {
  if (unit == "1") return unit;
  return unit.find_first_of("/* ") == std::string::npos ? unit + "^2" : fmt::format("({})^2", unit);
}

Values missing_values(const Values& like, std::size_t rows) {
  if (std::holds_alternative<Texts>(like)) return Texts(rows);
  return Doubles(rows, kMissing);
}

void refuse_other_unit(const Column& a, const Column& b) {
  if (a.unit == b.unit) return;
  throw InputError(fmt::format(
      "column \"{}\" has the unit {} in one table and {} in the other; convert one of them", a.name,
      a.unit, b.unit));
}

Values concatenated(const std::string& name, const Values& a, const Values& b) {
  if (std::holds_alternative<Texts>(a) != std::holds_alternative<Texts>(b))
    throw InputError(
        fmt::format("column \"{}\" holds text in one table and numbers in the other", name));
  if (a.index() == b.index())
    return std::visit(
        [&b](const auto& first) -> Values {
          auto all = first;
          const auto& second = std::get<std::decay_t<decltype(first)>>(b);
          all.insert(all.end(), second.begin(), second.end());
          return all;
        },
        a);
  Doubles all;
  for (const Values* values : {&a, &b}) {
    if (const auto* doubles = std::get_if<Doubles>(values))
      all.insert(all.end(), doubles->begin(), doubles->end());
    else
      for (const std::int64_t value : std::get<Integers>(*values))
        all.push_back(static_cast<double>(value));
  }
  return all;
}

}  // namespace

Table selected_columns(const Table& table, const std::vector<std::string>& names) {
  Table result;
  for (const std::string& name : names) result.add(table.column(name));
  result.attributes = table.attributes;
  return result;
}

std::vector<std::size_t> rows_where(const Table& table,
                                    const std::function<bool(std::size_t row)>& keep) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < table.rows(); ++row)
    if (keep(row)) rows.push_back(row);
  return rows;
}

std::vector<std::size_t> complete_rows(const Table& table, const std::vector<std::string>& names) {
  std::vector<bool> is_complete(table.rows(), true);
  for (const std::string& name : names) {
    const Values& values = table.column(name).values;
    for (std::size_t row = 0; row < is_complete.size(); ++row) {
      if (const auto* doubles = std::get_if<Doubles>(&values);
          doubles && std::isnan((*doubles)[row]))
        is_complete[row] = false;
      if (const auto* texts = std::get_if<Texts>(&values); texts && (*texts)[row].empty())
        is_complete[row] = false;
    }
  }
  return rows_where(table, [&](std::size_t row) { return is_complete[row]; });
}

std::vector<Group> grouped(const Table& table, const std::vector<std::string>& keys) {
  need_keys(keys, "grouping");
  const Texts row_key = row_keys(table, keys, std::vector<Compare>(keys.size(), Compare::exactly));
  std::vector<Group> groups;
  std::unordered_map<std::string, std::size_t> place;
  for (std::size_t row = 0; row < row_key.size(); ++row) {
    const auto [at, is_new] = place.try_emplace(row_key[row], groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].rows.push_back(row);
  }
  return groups;
}

Table group_means(const Table& table, const std::vector<std::string>& keys,
                  const std::vector<std::string>& responses) {
  const std::vector<Group> groups = grouped(table, keys);
  std::vector<std::size_t> first_rows;
  Integers counts;
  for (const Group& group : groups) {
    first_rows.push_back(group.rows.front());
    counts.push_back(static_cast<std::int64_t>(group.rows.size()));
  }
  Table result = selected_columns(table, keys).selected_rows(first_rows);
  result.add({.name = "rows", .role = Role::weight, .values = std::move(counts)});
  for (const std::string& name : responses) {
    const Column& column = table.column(name);
    const Doubles values = table.numbers(name);
    Doubles means, variances;
    for (const Group& group : groups) {
      const Moments m = moments(values, group.rows);
      means.push_back(m.mean);
      variances.push_back(m.variance);
    }
    result.add({name, column.unit, column.role, std::nullopt, std::move(means)});
    result.add({name + "_variance", squared(column.unit), Role::variance, std::nullopt,
                std::move(variances)});
  }
  return result;
}

Table joined(const Table& left, const Table& right, const std::vector<std::string>& keys,
             Join kind) {
  need_keys(keys, "a join");
  const std::vector<Compare> compare = comparisons(left, right, keys);
  std::unordered_map<std::string, std::vector<std::size_t>> partners;
  const Texts right_keys = row_keys(right, keys, compare);
  for (std::size_t row = 0; row < right_keys.size(); ++row)
    partners[right_keys[row]].push_back(row);
  std::vector<std::size_t> left_rows, right_rows;
  const Texts left_keys = row_keys(left, keys, compare);
  for (std::size_t row = 0; row < left_keys.size(); ++row) {
    const auto found = partners.find(left_keys[row]);
    if (found == partners.end()) {
      if (kind == Join::inner) continue;
      left_rows.push_back(row);
      right_rows.push_back(kNoRow);
      continue;
    }
    left_rows.insert(left_rows.end(), found->second.size(), row);
    right_rows.insert(right_rows.end(), found->second.begin(), found->second.end());
  }
  Table result = left.selected_rows(left_rows);
  for (const Column& column : right.columns()) {
    if (std::find(keys.begin(), keys.end(), column.name) != keys.end()) continue;
    if (left.has(column.name))
      throw InputError(fmt::format(
          "both tables have a column \"{}\" that is no key; leave it out of one of them",
          column.name));
    result.add({column.name, column.unit, column.role, column.range,
                picked(column.values, right_rows, kind)});
  }
  return result;
}

Table appended(const Table& first, const Table& second, Unmatched unmatched) {
  const auto missing_in = [&](const Table& table, const Column& column) {
    if (unmatched == Unmatched::refuse)
      throw InputError(fmt::format(
          "column \"{}\" is only in the {} of two tables to be put one below the other; leave it "
          "out or allow missing values",
          column.name, &table == &first ? "second" : "first"));
    return missing_values(column.values, table.rows());
  };
  Table result;
  for (const Column& column : first.columns()) {
    const bool in_both = second.has(column.name);
    if (in_both) refuse_other_unit(column, second.column(column.name));
    const Values more = in_both ? second.column(column.name).values : missing_in(second, column);
    result.add({column.name, column.unit, column.role, column.range,
                concatenated(column.name, column.values, more)});
  }
  for (const Column& column : second.columns()) {
    if (first.has(column.name)) continue;
    result.add({column.name, column.unit, column.role, column.range,
                concatenated(column.name, missing_in(first, column), column.values)});
  }
  result.attributes = first.attributes;
  return result;
}

Table with_roles(const Table& table, const std::map<std::string, Role>& roles) {
  for (const auto& [name, role] : roles) {
    const bool needs_numbers = role == Role::factor || role == Role::response ||
                               role == Role::variance || role == Role::weight;
    if (is_text(table.column(name)) && needs_numbers)
      throw InputError(
          fmt::format("column \"{}\" holds text and cannot be a {}; numbers are needed", name,
                      role_name(role)));
  }
  Table result;
  for (Column column : table.columns()) {
    if (const auto found = roles.find(column.name); found != roles.end())
      column.role = found->second;
    result.add(std::move(column));
  }
  result.attributes = table.attributes;
  return result;
}

}  // namespace repose::table

// repose table show: what is in a table.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct ShowOptions {
  CommonOptions common;
  std::string location;
  int rows = 10;
};

/// A value as a cell: up to six significant digits.
std::string cell(const table::Values& values, std::size_t row) {
  return std::visit(
      [row](const auto& v) -> std::string {
        if constexpr (std::is_same_v<std::decay_t<decltype(v[row])>, double>)
          return fmt::format("{:.6g}", v[row]);
        else
          return fmt::format("{}", v[row]);
      },
      values);
}

std::string summary(const table::Column& column) {
  if (const auto* text = std::get_if<std::vector<std::string>>(&column.values)) {
    auto distinct = *text;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    return fmt::format("{} different texts", distinct.size());
  }
  double low = INFINITY, high = -INFINITY, sum = 0.0;
  std::size_t n = 0, missing = 0;
  const auto take = [&](double v) {
    if (std::isnan(v)) {
      ++missing;
      return;
    }
    low = std::min(low, v);
    high = std::max(high, v);
    sum += v;
    ++n;
  };
  std::visit(
      [&](const auto& values) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(values)>, std::vector<std::string>>)
          for (const auto v : values) take(static_cast<double>(v));
      },
      column.values);
  std::string text = n == 0 ? "no values"
                            : fmt::format("{:.6g} ... {:.6g}, mean {:.6g}", low, high,
                                          sum / static_cast<double>(n));
  if (missing > 0) text += fmt::format(", {} missing", missing);
  if (column.range)
    text += fmt::format(", range {:.6g} ... {:.6g}{}", column.range->lower, column.range->upper,
                        column.range->scale == Scale::log ? " (log)" : "");
  return text;
}

void print_columns(const table::Table& table) {
  std::size_t name_width = 6, unit_width = 4;
  for (const auto& c : table.columns()) {
    name_width = std::max(name_width, c.name.size());
    unit_width = std::max(unit_width, c.unit.size());
  }
  fmt::print("{:<{}}  {:<{}}  {:<9}  values\n", "column", name_width, "unit", unit_width, "role");
  for (const auto& c : table.columns())
    fmt::print("{:<{}}  {:<{}}  {:<9}  {}\n", c.name, name_width, c.unit, unit_width,
               c.role == table::Role::none ? "" : table::role_name(c.role), summary(c));
}

void print_rows(const table::Table& table, std::size_t rows) {
  constexpr std::size_t kColumns = 100, kWidest = 24;
  std::vector<std::vector<std::string>> cells;
  std::size_t width = 0, shown = 0;
  for (const auto& c : table.columns()) {
    std::vector<std::string> column{c.name};
    for (std::size_t r = 0; r < rows; ++r) column.push_back(cell(c.values, r));
    std::size_t w = 0;
    for (auto& text : column) {
      if (text.size() > kWidest) text = text.substr(0, kWidest - 3) + "...";
      w = std::max(w, text.size());
    }
    if (width + w + 2 > kColumns) break;
    for (auto& text : column) text = fmt::format("{:>{}}", text, w);
    width += w + 2;
    ++shown;
    cells.push_back(std::move(column));
  }
  for (std::size_t r = 0; r <= rows; ++r) {
    std::string line;
    for (const auto& column : cells) line += column[r] + "  ";
    while (!line.empty() && line.back() == ' ') line.pop_back();
    fmt::print("{}\n", line);
  }
  if (shown < table.columns().size())
    fmt::print("({} more columns)\n", table.columns().size() - shown);
  if (rows < table.rows()) fmt::print("({} more rows; --rows N shows more)\n", table.rows() - rows);
}

nlohmann::json as_json(const table::Table& table, std::size_t rows) {
  nlohmann::json json{{"rows", table.rows()}, {"columns", nlohmann::json::array()}};
  for (const auto& c : table.columns()) {
    nlohmann::json values = nlohmann::json::array();
    for (std::size_t r = 0; r < rows; ++r)
      std::visit([&](const auto& v) { values.push_back(v[r]); }, c.values);
    nlohmann::json column{
        {"name", c.name}, {"unit", c.unit}, {"role", table::role_name(c.role)}, {"values", values}};
    if (c.range) {
      column["lower"] = c.range->lower;
      column["upper"] = c.range->upper;
      column["scale"] = c.range->scale == Scale::log ? "log" : "linear";
    }
    json["columns"].push_back(std::move(column));
  }
  return json;
}

void show(const ShowOptions& options) {
  auto location = table::parse_location(options.location);
  if (location.group.empty()) {
    const auto tables = table::list_tables(location.file);
    if (tables.size() > 1) {
      if (options.common.json) {
        fmt::print("{}\n", nlohmann::json{{"tables", tables}}.dump(2));
        return;
      }
      fmt::print("{} tables; show one with {}:/NAME\n", tables.size(), location.file.string());
      for (const auto& name : tables) fmt::print("  {}\n", name);
      return;
    }
  }
  const auto table = table::read_table(location, table::Missing::allow);
  const auto rows = std::min(table.rows(), static_cast<std::size_t>(options.rows));
  if (options.common.json) {
    fmt::print("{}\n", as_json(table, rows).dump(2));
    return;
  }
  fmt::print("{} rows, {} columns\n\n", table.rows(), table.columns().size());
  print_columns(table);
  if (rows > 0) fmt::print("\n");
  if (rows > 0) print_rows(table, rows);
}

}  // namespace

void add_table(CLI::App& app) {
  auto* group =
      app.add_subcommand("table", "Shows, imports and exports tables in HDF5 and CSV files");
  group->require_subcommand(1);
  auto options = std::make_shared<ShowOptions>();
  auto* command = add_command(*group, "show", "Columns, units, roles, ranges and the first rows",
                              "repose table show quick/runs.h5 --rows 5", options->common);
  command->add_option("TABLE", options->location, "FILE.h5, FILE.h5:/group or FILE.csv")
      ->required();
  command->add_option("--rows", options->rows, "rows shown")
      ->capture_default_str()
      ->check(CLI::Range(0, 1000000));
  command->callback([options] { show(*options); });
  add_table_conversions(*group);
}

}  // namespace repose::cli

// A table as a design.
#include "design_columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/base/toml.hpp"

namespace repose::cli {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Not a factor unless it is asked for: how runs are customarily numbered.
bool numbers_runs(const std::string& name) {
  constexpr std::array kNames{"run",        "row", "id",   "pair",  "pair_id", "replicate",
                              "repetition", "rep", "seed", "point", "block",   "added"};
  return std::find(kNames.begin(), kNames.end(), name) != kNames.end();
}

/// A column that was not named is no factor by surprise: it may be a result.
void require_few_levels(const table::Table& table, const std::string& name) {
  constexpr std::size_t kFewLevels = 8;
  auto values = table.numbers(name);
  const std::size_t rows = values.size();
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.size() > kFewLevels && 2 * values.size() > rows)
    throw InputError(fmt::format(
        "column {} has {} different values in {} rows: a factor or a result? Name the factors with "
        "--columns",
        name, values.size(), rows));
}

std::vector<std::string> names_of_factors(const table::Table& table, const FactorOptions& options,
                                          const std::optional<ParameterSpace>& space,
                                          const std::vector<std::string>& others) {
  if (!options.columns.empty()) return options.columns;
  if (space) return space->names();
  auto names = table.names_with_role(table::Role::factor);
  if (names.empty())
    for (const auto& c : table.columns())
      if (c.role == table::Role::none && !contains(others, c.name) && !numbers_runs(c.name) &&
          !std::holds_alternative<std::vector<std::string>>(c.values)) {
        require_few_levels(table, c.name);
        names.push_back(c.name);
      }
  if (names.empty())
    throw InputError("the table has no column that can be a factor; name them with --columns");
  return names;
}

DesignFactor with_middle(std::string name, double lower, double upper, Scale scale) {
  const double middle =
      scale == Scale::log ? std::sqrt(lower) * std::sqrt(upper) : 0.5 * lower + 0.5 * upper;
  return {std::move(name), lower, middle, upper, scale};
}

DesignFactor factor_of(const Parameter& p) {
  auto factor = with_middle(p.name, p.lower, p.upper, p.scale);
  factor.categories = p.categories;
  if (p.kind == ParameterKind::levels && p.levels.size() % 2 == 1)
    factor.middle = p.levels[p.levels.size() / 2];
  return factor;
}

/// A factor of names that no factors file knows: in alphabetical order.
DesignFactor factor_of_names(const std::string& name, std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  if (names.size() < 2)
    throw InputError(fmt::format(
        "column {} is \"{}\" in every row: it is no factor; name the factors with --columns", name,
        names.empty() ? "" : names.front()));
  return factor_of(Parameter{.name = name,
                             .upper = static_cast<double>(names.size() - 1),
                             .kind = ParameterKind::categorical,
                             .categories = std::move(names)});
}

bool holds_names(const table::Table& table, const std::string& column) {
  return std::holds_alternative<std::vector<std::string>>(table.column(column).values);
}

/// Values of a factor's column, of names their places.
std::vector<double> values_of(const table::Table& table, const DesignFactor& f) {
  if (f.categories.empty()) return table.numbers(f.name);
  std::vector<double> values;
  for (const auto& name : table.texts(f.name)) {
    const auto place = std::find(f.categories.begin(), f.categories.end(), name);
    if (place == f.categories.end())
      throw InputError(fmt::format("row {}: {} = \"{}\" is none of {}", values.size() + 1, f.name,
                                   name, listed(f.categories)));
    values.push_back(static_cast<double>(place - f.categories.begin()));
  }
  return values;
}

DesignFactor factor_of(const table::Table& table, const std::string& name,
                       const std::optional<ParameterSpace>& space) {
  if (space)
    for (const auto& p : space->parameters())
      if (p.name == name && p.kind == ParameterKind::categorical) return factor_of(p);
  if (holds_names(table, name)) return factor_of_names(name, table.texts(name));
  const auto values = table.numbers(name);
  const auto missing =
      std::find_if(values.begin(), values.end(), [](double v) { return std::isnan(v); });
  if (missing != values.end())
    throw InputError(
        fmt::format("column {} has no value in row {}; every run of a design needs one", name,
                    missing - values.begin() + 1));
  if (space)
    for (const auto& p : space->parameters())
      if (p.name == name) return factor_of(p);
  if (const auto& range = table.column(name).range)
    return with_middle(name, range->lower, range->upper, range->scale);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (least == values.end() || !(*least < *most))
    throw InputError(fmt::format(
        "column {} is {} in every row: it is no factor; name the factors with --columns", name,
        values.empty() ? "empty" : shortest(*least)));
  return with_middle(name, *least, *most, scale_of_levels(values));
}

double coded(const DesignFactor& f, double value) {
  if (value == f.middle) return 0.0;
  const double unit = f.scale == Scale::log
                          ? std::log(value / f.lower) / std::log(f.upper / f.lower)
                          : (value - f.lower) / (f.upper - f.lower);
  const double level = 2.0 * unit - 1.0, nearest = std::round(level);
  return std::abs(level - nearest) <= 1e-9 ? nearest + 0.0 : level;
}

}  // namespace

Scale scale_of_levels(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.size() != 3 || values[0] <= 0.0) return Scale::linear;
  const double geometric = std::sqrt(values[0]) * std::sqrt(values[2]);
  const double arithmetic = 0.5 * (values[0] + values[2]);
  return std::abs(values[1] - geometric) < std::abs(values[1] - arithmetic) ? Scale::log
                                                                            : Scale::linear;
}

ParameterSpace read_factors(const std::string& file) {
  const auto root = TomlTable::read_file(file);
  auto space = read_parameter_space(root);
  root.refuse_unknown_keys();
  return space;
}

void add_factor_options(CLI::App& command, FactorOptions& options) {
  command
      .add_option("--columns", options.columns,
                  "the factors' columns; without it those of\n--factors, those with the role "
                  "factor, or all\nnumbers that can be factors")
      ->delimiter(',');
  command.add_option("--factors", options.factors,
                     "TOML file with names and ranges; without it\nthe ranges in the table, or its "
                     "lowest and\nhighest values");
}

Parameter DesignFactor::parameter() const {
  return {.name = name,
          .lower = lower,
          .upper = upper,
          .scale = scale,
          .kind = categories.empty() ? ParameterKind::continuous : ParameterKind::categorical,
          .categories = categories};
}

std::vector<std::string> CodedDesign::names() const {
  std::vector<std::string> names;
  for (const auto& f : factors) names.push_back(f.name);
  return names;
}

double CodedDesign::natural(std::size_t factor, double level) const {
  const auto& f = factors.at(factor);
  if (level == 0.0) return f.middle;
  if (std::abs(level) == 1.0) return level < 0.0 ? f.lower : f.upper;
  const double unit = 0.5 * (level + 1.0);
  return f.scale == Scale::log ? f.lower * std::pow(f.upper / f.lower, unit)
                               : f.lower + unit * (f.upper - f.lower);
}

CodedDesign coded_design(const table::Table& table, const FactorOptions& options,
                         const std::vector<std::string>& others) {
  std::optional<ParameterSpace> space;
  if (!options.factors.empty()) space = read_factors(options.factors);
  CodedDesign design;
  const auto names = names_of_factors(table, options, space, others);
  if (table.rows() == 0) throw InputError("the table has no rows");
  design.coded =
      Matrix(static_cast<Eigen::Index>(table.rows()), static_cast<Eigen::Index>(names.size()));
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (contains(others, names[j]))
      throw InputError(fmt::format("column {} cannot be a factor and something else", names[j]));
    design.factors.push_back(factor_of(table, names[j], space));
    const auto& f = design.factors.back();
    const auto values = values_of(table, f);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double level =
          f.scale == Scale::log && values[i] <= 0.0 ? -INFINITY : coded(f, values[i]);
      if (!(std::abs(level) <= 1.0))
        throw InputError(
            fmt::format("row {}: {} = {} is outside its range [{}, {}]; correct the "
                        "value or the range (--factors)",
                        i + 1, f.name, shortest(values[i]), shortest(f.lower), shortest(f.upper)));
      if (level == 0.0) design.factors.back().middle = values[i];  // as the table writes it
      design.coded(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = level;
    }
  }
  return design;
}

std::vector<std::string> row_labels(const table::Table& table, const std::string& column) {
  if (const auto* texts = std::get_if<std::vector<std::string>>(&table.column(column).values))
    return *texts;
  std::vector<std::string> labels;
  for (const auto v : table.integers(column)) labels.push_back(std::to_string(v));
  return labels;
}

std::vector<std::string> response_columns(const table::Table& table,
                                          const std::vector<std::string>& named) {
  auto names = named.empty() ? table.names_with_role(table::Role::response) : named;
  if (names.empty()) throw InputError("the table names no response; give --response COLUMN");
  for (const auto& name : names)
    static_cast<void>(table.column(name));  // throws if it is not there
  return names;
}

}  // namespace repose::cli

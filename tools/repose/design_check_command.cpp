// repose design check: is a table a definitive screening design, and which runs does it lack?
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "design_columns.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/doe/design_check.hpp"
#include "repose/doe/distributions.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct CheckOptions {
  CommonOptions common;
  FactorOptions factors;
  std::string table;
  std::string repair;
  double effect = 1.0;
  double alpha = 0.01;
};

/// What the tests of main effects with one estimate of error can find.
struct TestStrength {
  std::string error;  ///< where it comes from
  int df = 0;
  Vector significant_from;  ///< |coefficient| over the standard deviation of a run
  Vector power;             ///< at the effect asked for
};

TestStrength strength(const doe::DesignCheck& check, std::string error, int df,
                      const CheckOptions& options) {
  TestStrength result{std::move(error), df, check.standard_error, check.standard_error};
  const double critical = doe::t_critical(options.alpha, df);
  for (Eigen::Index j = 0; j < check.standard_error.size(); ++j) {
    result.significant_from(j) = critical * check.standard_error(j);
    result.power(j) =
        doe::t_test_power(options.effect / check.standard_error(j), df, options.alpha);
  }
  return result;
}

std::vector<TestStrength> strengths(const doe::DesignCheck& check, const CheckOptions& options) {
  std::vector<TestStrength> results;
  if (!std::isfinite(check.alias_max)) return results;
  if (check.residual_df > 0)
    results.push_back(strength(check, "fit of all main effects", check.residual_df, options));
  if (check.two_stage_df > 0)
    results.push_back(strength(check, "fake factors and centre runs", check.two_stage_df, options));
  return results;
}

std::vector<int> from_one(std::vector<int> runs) {
  for (int& run : runs) ++run;
  return runs;
}

std::string numbers_text(const std::vector<int>& runs) {
  std::vector<std::string> texts;
  for (const int run : from_one(runs)) texts.push_back(std::to_string(run));
  return texts.empty() ? "none" : listed(texts);
}

/// A line of at most 100 columns, continued below its value.
void print_item(const std::string& name, const std::vector<std::string>& words) {
  constexpr std::size_t kIndent = 32, kColumns = 100;
  std::string line = fmt::format("  {:<{}}", name, kIndent - 2);
  for (const auto& word : words) {
    if (line.size() + word.size() + 1 > kColumns) {
      fmt::print("{}\n", line);
      line = std::string(kIndent, ' ');
    }
    line += (line.size() == kIndent ? "" : " ") + word;
  }
  fmt::print("{}\n", line);
}

void print_pairs(const doe::DesignCheck& check) {
  std::vector<std::string> words{fmt::format("{}:", check.pairs.size())};
  for (const auto& [run, mirror] : check.pairs)
    words.push_back(fmt::format("({},{})", run + 1, mirror + 1));
  if (check.pairs.empty()) words = {"none"};
  print_item("fold-over pairs", words);
}

void print_correlation(const doe::DesignCheck& check, const std::vector<std::string>& names) {
  if (check.correlation_max < 1e-12) {
    print_item("correlation of main effects", {"none"});
    return;
  }
  Eigen::Index a = 0, b = 0;
  (check.correlation.cwiseAbs() - Matrix::Identity(check.factors, check.factors)).maxCoeff(&a, &b);
  print_item("correlation of main effects",
             {fmt::format("at most {:.3f},", check.correlation_max), "of",
              names[static_cast<std::size_t>(std::min(a, b))], "and",
              names[static_cast<std::size_t>(std::max(a, b))]});
}

void print_aliasing(const doe::DesignCheck& check, const std::vector<std::string>& names) {
  const std::string item = "aliased second-order effects";
  if (std::isinf(check.alias_max)) {
    print_item(item, {"the main effects cannot all be estimated"});
    return;
  }
  if (check.aliases.empty()) {
    print_item(item, {"none"});
    return;
  }
  const auto& worst = check.aliases.front();
  print_item(item, {fmt::format("{},", check.aliases.size()),
                    fmt::format("root mean square {:.3f};", check.alias_rms),
                    "most:", names[static_cast<std::size_t>(worst.factor)], "carries",
                    fmt::format("{:.3f}", worst.coefficient), "of",
                    doe::term_name(worst.second_order, names)});
}

std::string level_text(double value) {
  return fmt::format("{:.5g}", value);
}

void print_factors(const CodedDesign& design, const doe::DesignCheck& check,
                   const std::vector<TestStrength>& tests) {
  std::size_t width = 6;
  for (const auto& f : design.factors) width = std::max(width, f.name.size());
  width = std::min<std::size_t>(width, 30);
  fmt::print("\n  {:<{}}  {:>10} {:>10} {:>10}  {:>14}  {:>8}\n", "factor", width, "low", "middle",
             "high", "runs at each", "se/sigma");
  for (std::size_t j = 0; j < design.factors.size(); ++j) {
    const auto& f = design.factors[j];
    const auto column = design.coded.col(static_cast<Eigen::Index>(j)).array();
    const auto at = [&](double level) { return (column == level).count(); };
    fmt::print("  {:<{}}  {:>10} {:>10} {:>10}  {:>14}  {:>8.4f}\n", f.name.substr(0, width), width,
               level_text(f.lower), level_text(f.middle), level_text(f.upper),
               fmt::format("{} / {} / {}", at(-1.0), at(0.0), at(1.0)),
               check.standard_error(static_cast<Eigen::Index>(j)));
  }
  if (tests.empty()) fmt::print("\n  No error to test main effects against.\n");
  for (const auto& test : tests)
    fmt::print(
        "\n  Error from the {} ({} degree{} of freedom): significant from\n  |b| = {:.3g} sigma; "
        "power {:.1f} % (least of all factors).\n",
        test.error, test.df, test.df == 1 ? "" : "s", test.significant_from.maxCoeff(),
        100.0 * test.power.minCoeff());
}

void print_uneven_levels(const CodedDesign& design) {
  for (std::size_t j = 0; j < design.factors.size(); ++j) {
    const auto column = design.coded.col(static_cast<Eigen::Index>(j)).array();
    std::vector<double> others;
    for (const double level : column)
      if (level != std::round(level)) others.push_back(level);
    if (others.empty()) continue;
    const auto& f = design.factors[j];
    fmt::print("  {}: {} where {} would be the middle of [{}, {}]\n", f.name,
               level_text(design.natural(j, others.front())), shortest(f.middle), shortest(f.lower),
               shortest(f.upper));
  }
}

std::vector<std::string> two_level_names(const CodedDesign& design, const doe::DesignCheck& check) {
  std::vector<std::string> names;
  for (const int j : check.two_level_factors)
    names.push_back(design.factors[static_cast<std::size_t>(j)].name);
  return names;
}

void print_check(const CheckOptions& options, const CodedDesign& design,
                 const doe::DesignCheck& check) {
  const auto names = design.names();
  fmt::print("{}: {} runs of {} factors\n\n", options.table, check.runs, check.factors);
  print_item("definitive screening design", {check.is_definitive_screening() ? "yes" : "no"});
  print_pairs(check);
  print_item("centre runs", {numbers_text(check.centre_runs)});
  if (!check.two_level_factors.empty())
    print_item("factors of two levels only", {listed(two_level_names(design, check))});
  print_item("runs without a mirror image", {numbers_text(check.orphans)});
  print_correlation(check, names);
  print_aliasing(check, names);
  print_item("D-efficiency", {fmt::format("{:.2f} %", 100.0 * check.d_efficiency)});
  print_uneven_levels(design);
  print_factors(design, check, strengths(check, options));
  fmt::print(
      "\n  Runs are rows counted from 1. sigma: standard deviation of one run; b: half of what the "
      "response\n  changes from low to high; power: at |b| = {} sigma and alpha = {}.\n",
      shortest(options.effect), shortest(options.alpha));
}

nlohmann::json numbers(const Vector& values) {
  nlohmann::json json = nlohmann::json::array();
  for (const double v : values) json.push_back(v);  // infinity becomes null
  return json;
}

nlohmann::json as_json(const CheckOptions& options, const CodedDesign& design,
                       const doe::DesignCheck& check) {
  const auto names = design.names();
  nlohmann::json pairs = nlohmann::json::array(), aliases = nlohmann::json::array(),
                 factors = nlohmann::json::array(), correlation = nlohmann::json::array(),
                 tests = nlohmann::json::array();
  for (const auto& [run, mirror] : check.pairs) pairs.push_back({run + 1, mirror + 1});
  for (const auto& a : check.aliases)
    aliases.push_back({{"main_effect", names[static_cast<std::size_t>(a.factor)]},
                       {"second_order", doe::term_name(a.second_order, names)},
                       {"coefficient", a.coefficient}});
  for (const auto& f : design.factors)
    factors.push_back({{"name", f.name},
                       {"low", f.lower},
                       {"middle", f.middle},
                       {"high", f.upper},
                       {"scale", f.scale == Scale::log ? "log" : "linear"}});
  for (Eigen::Index j = 0; j < check.correlation.rows(); ++j)
    correlation.push_back(numbers(check.correlation.row(j)));
  for (const auto& t : strengths(check, options))
    tests.push_back({{"error", t.error},
                     {"df", t.df},
                     {"significant_from", numbers(t.significant_from)},
                     {"power", numbers(t.power)}});
  return {{"definitive_screening", check.is_definitive_screening()},
          {"problems", check.problems},
          {"runs", check.runs},
          {"factors", factors},
          {"pairs", pairs},
          {"centre_runs", from_one(check.centre_runs)},
          {"two_level_factors", two_level_names(design, check)},
          {"runs_without_mirror_image", from_one(check.orphans)},
          {"correlation", correlation},
          {"correlation_max", check.correlation_max},
          {"aliases", aliases},
          {"alias_max", check.alias_max},
          {"alias_rms", check.alias_rms},
          {"d_efficiency", check.d_efficiency},
          {"standard_error", numbers(check.standard_error)},
          {"tests", {{"effect", options.effect}, {"alpha", options.alpha}, {"errors", tests}}}};
}

/// The factors' columns with the missing runs below, numbered on.
table::Table repaired(const table::Table& table, const CodedDesign& design, const Matrix& missing) {
  table::Table result;
  const auto rows = table.rows() + static_cast<std::size_t>(missing.rows());
  std::vector<std::int64_t> run(rows), added(rows, 0);
  for (std::size_t i = 0; i < rows; ++i) run[i] = static_cast<std::int64_t>(i) + 1;
  std::fill(added.begin() + static_cast<std::ptrdiff_t>(table.rows()), added.end(), 1);
  result.add({.name = "run", .role = table::Role::id, .range = {}, .values = run});
  for (std::size_t j = 0; j < design.factors.size(); ++j) {
    const auto& f = design.factors[j];
    const auto column = static_cast<Eigen::Index>(j);
    std::vector<double> values;
    for (const double level : design.coded.col(column)) values.push_back(design.natural(j, level));
    if (f.categories.empty()) values = table.numbers(f.name);  // as they are, to the last digit
    for (const double level : missing.col(column)) values.push_back(design.natural(j, level));
    auto parameter = f.parameter();
    parameter.unit = table.column(f.name).unit;
    result.add(table::factor_column(parameter, std::move(values)));
  }
  result.add({.name = "added", .range = {}, .values = added});
  return result;
}

/// Writes the design with the runs it lacks; what the check says of it.
doe::DesignCheck repair(const CheckOptions& options, const table::Table& table,
                        const CodedDesign& design) {
  const Matrix missing = doe::missing_runs(design.coded);
  auto result = repaired(table, design, missing);
  table::stamp_provenance(result, command_line(), std::nullopt, {options.table});
  Matrix coded(design.coded.rows() + missing.rows(), design.coded.cols());
  coded << design.coded, missing;
  auto check = doe::check_design(coded);
  if (check.is_definitive_screening()) result.attributes["design"] = "definitive screening design";
  table::write_table(table::parse_location(options.repair), result);
  return check;
}

void check(const CheckOptions& options) {
  const auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const auto design = coded_design(table, options.factors);
  const auto found = doe::check_design(design.coded);
  const auto* judged = &found;
  doe::DesignCheck after;
  if (!options.repair.empty()) {
    after = repair(options, table, design);
    judged = &after;
  }
  if (options.common.json) {
    auto json = as_json(options, design, found);
    if (!options.repair.empty())
      json["repaired"] = {{"file", options.repair},
                          {"runs", after.runs},
                          {"added", after.runs - found.runs},
                          {"definitive_screening", after.is_definitive_screening()},
                          {"problems", after.problems}};
    fmt::print("{}\n", json.dump(2));
  } else {
    print_check(options, design, found);
    if (!options.repair.empty())
      fmt::print("\n  {} runs added: {} runs in {}\n", after.runs - found.runs, after.runs,
                 options.repair);
  }
  if (judged->is_definitive_screening()) return;
  std::fflush(stdout);
  std::string reasons;
  for (const auto& problem : judged->problems) reasons += (reasons.empty() ? "" : "; ") + problem;
  throw InputError(
      fmt::format("{} is not a definitive screening design: {}{}",
                  options.repair.empty() ? options.table : options.repair, reasons,
                  options.repair.empty() && (!found.orphans.empty() || found.centre_runs.empty())
                      ? "; --repair OUT writes it with the runs it lacks"
                      : ""));
}

}  // namespace

void add_design_check(CLI::App& design) {
  auto o = std::make_shared<CheckOptions>();
  auto* command =
      add_command(design, "check", "Is it a definitive screening design? What can it find?",
                  "repose design check runs.csv --columns mu_s,mu_r,c_r --repair complete.h5\n"
                  "Exits with 3 and names the runs if it is not one; with --repair, if the "
                  "repaired one is not.",
                  o->common);
  command->add_option("DESIGN", o->table, "FILE.h5, FILE.h5:/group or FILE.csv, one run a row")
      ->required();
  add_factor_options(*command, o->factors);
  command->add_option("--repair", o->repair,
                      "table to write (.h5 or .csv): the factors with the\nmirror images and the "
                      "centre run that are missing");
  command->add_option("--effect", o->effect, "coefficient over sigma for which power is given")
      ->capture_default_str()
      ->check(CLI::Range(0.0, 1e6));
  command->add_option("--alpha", o->alpha, "level of the tests")
      ->capture_default_str()
      ->check(CLI::Range(1e-12, 0.999));
  command->callback([o] { check(*o); });
}

}  // namespace repose::cli

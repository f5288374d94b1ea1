// repose design d-optimal|augment: runs chosen for a model, and runs added to those there are.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "design_columns.hpp"
#include "design_table.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/optimal_design.hpp"
#include "repose/doe/space_filling.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct OptimalOptions : DesignOptions {
  int runs = 0;
  int starts = 10;
  int levels = 0;
  std::string model;
  std::string method = "space-filling";
  std::string table;
  std::vector<std::string> columns;
};

doe::ModelOrder model_order(const std::string& name) {
  return name == "linear"         ? doe::ModelOrder::linear
         : name == "interactions" ? doe::ModelOrder::interactions
                                  : doe::ModelOrder::quadratic;
}

/// Candidate levels: all of a list, of ranges two ends, a middle for quadratics, and eleven steps
/// where constraints cut corners off.
std::vector<std::vector<double>> candidate_levels(const ParameterSpace& space,
                                                  const OptimalOptions& options) {
  const int unconstrained = model_order(options.model) == doe::ModelOrder::quadratic ? 3 : 2;
  const int wanted = options.levels > 0            ? options.levels
                     : space.constraints().empty() ? unconstrained
                                                   : 11;
  std::vector<std::vector<double>> levels;
  for (const auto& p : space.parameters()) {
    if (p.kind == ParameterKind::categorical && level_count(p) > 2)
      throw InputError(fmt::format(
          "parameter {}: it has {} names; a D-optimal design takes two: fix it and make "
          "one design for each name, or choose lhs, sobol or halton",
          p.name, level_count(p)));
    const bool is_list = p.kind == ParameterKind::levels || p.kind == ParameterKind::categorical;
    std::size_t count = is_list ? level_count(p) : static_cast<std::size_t>(wanted);
    if (p.kind == ParameterKind::integer) count = std::min(count, level_count(p));
    std::vector<double> coded;
    for (std::size_t i = 0; i < count; ++i) {
      const double unit = static_cast<double>(i) / static_cast<double>(count - 1);
      coded.push_back(2.0 * unit_value(p, natural_value(p, unit)) - 1.0);
    }
    coded.erase(std::unique(coded.begin(), coded.end()), coded.end());  // few whole numbers
    levels.push_back(std::move(coded));
  }
  return levels;
}

doe::OptimalDesign optimal(const ParameterSpace& space, const OptimalOptions& options,
                           Matrix existing, MadeDesign& made) {
  const int k = static_cast<int>(space.dimension());
  std::vector<int> two_level;
  for (int j = 0; j < k; ++j)
    if (level_count(space.parameters()[static_cast<std::size_t>(j)]) == 2) two_level.push_back(j);
  doe::OptimalDesignOptions wanted{.levels = candidate_levels(space, options),
                                   .existing = std::move(existing),
                                   .starts = options.starts,
                                   .seed = options.seed};
  if (const auto allowed = doe::constraint_filter(space))
    wanted.allowed = [allowed](const Vector& coded) {
      return allowed(0.5 * (coded.array() + 1.0).matrix());
    };
  const auto terms = doe::terms_of(model_order(options.model), k, two_level);
  auto design = doe::d_optimal_design(k, options.runs, terms, wanted);
  const auto best = std::count_if(design.efficiencies.begin(), design.efficiencies.end(),
                                  [&](double e) { return e > design.d_efficiency * (1.0 - 1e-6); });
  made.facts.update({{"model", options.model},
                     {"coefficients", terms.size() + 1},
                     {"d_efficiency", design.d_efficiency},
                     {"starts", options.starts},
                     {"starts_that_reached_it", best}});
  made.lines.push_back(fmt::format(
      "{} model, {} coefficients, D-efficiency {:.2f} %, reached by {} "
      "of {} starts",
      options.model, terms.size() + 1, 100.0 * design.d_efficiency, best, options.starts));
  return design;
}

void d_optimal(const OptimalOptions& options) {
  const auto space = read_factors(options.factors);
  MadeDesign made{.kind = "D-optimal design", .table = {}};
  const auto design = optimal(space, options, {}, made);
  const auto order = run_order(design.coded.rows(), options);
  made.table = design_table(space, unit_of(design.coded(order, Eigen::all)));
  finish(options, space, std::move(made));
}

/// What is known of the factors of a table: the factors file, else ranges in the table.
ParameterSpace space_of(const CodedDesign& design, const OptimalOptions& options) {
  if (!options.factors.empty()) return read_factors(options.factors);
  std::vector<Parameter> parameters;
  for (const auto& f : design.factors) parameters.push_back(f.parameter());
  return ParameterSpace(std::move(parameters));
}

/// The runs of a table as points of the unit cube.
Matrix places_of(const CodedDesign& design, const ParameterSpace& space) {
  Matrix unit(design.coded.rows(), design.coded.cols());
  for (Eigen::Index run = 0; run < unit.rows(); ++run)
    for (Eigen::Index j = 0; j < unit.cols(); ++j)
      unit(run, j) = unit_value(space.parameters()[static_cast<std::size_t>(j)],
                                design.natural(static_cast<std::size_t>(j), design.coded(run, j)));
  return unit.cwiseMax(0.0).cwiseMin(1.0);
}

/// A column of the old table with what it says of the new runs: nothing, unless it numbers rows.
table::Column prolonged(const table::Column& column, std::size_t added) {
  auto result = column;
  const std::size_t rows = table::length(column.values) + added;
  if (auto* texts = std::get_if<std::vector<std::string>>(&result.values)) {
    texts->resize(rows);
  } else if (auto* numbers = std::get_if<std::vector<double>>(&result.values)) {
    numbers->resize(rows, std::numeric_limits<double>::quiet_NaN());
  } else {
    const auto& integers = std::get<std::vector<std::int64_t>>(column.values);
    if (column.role == table::Role::id || column.name == "run") {
      auto next = integers.empty() ? 0 : *std::max_element(integers.begin(), integers.end());
      auto numbered = integers;
      while (numbered.size() < rows) numbered.push_back(++next);
      result.values = std::move(numbered);
    } else {
      std::vector<double> doubles(integers.begin(), integers.end());
      doubles.resize(rows, std::numeric_limits<double>::quiet_NaN());
      result.values = std::move(doubles);
    }
  }
  return result;
}

/// The old table with its columns in their order, then the new runs, and a column `added`.
table::Table augmented(const table::Table& old, const ParameterSpace& space, const Matrix& unit) {
  const auto fresh = design_table(space, unit);
  table::Table result;
  for (const auto& column : old.columns()) {
    if (column.name == "added") continue;
    auto joined = prolonged(column, fresh.rows());
    if (fresh.has(column.name) && column.name != "run") {
      const auto& values = fresh.column(column.name).values;
      if (const auto* names = std::get_if<std::vector<std::string>>(&values)) {
        auto all = old.texts(column.name);
        all.insert(all.end(), names->begin(), names->end());
        joined.values = std::move(all);
      } else {
        auto all = old.numbers(column.name);
        const auto added = fresh.numbers(column.name);
        all.insert(all.end(), added.begin(), added.end());
        joined.values = std::move(all);
      }
      const auto& as_factor = fresh.column(column.name);
      if (as_factor.role == table::Role::factor) {
        joined.role = as_factor.role;
        joined.range = as_factor.range;
      }
    }
    result.add(std::move(joined));
  }
  std::vector<int> added(old.rows(), 0);
  added.resize(old.rows() + fresh.rows(), 1);
  add_integers(result, "added", added);
  return result;
}

void augment(const OptimalOptions& options) {
  const auto old = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const auto coded = coded_design(old, {.columns = options.columns, .factors = options.factors});
  const auto space = space_of(coded, options);
  if (coded.names() != space.names())
    throw InputError("the factors file and --columns name different factors; give one of them");
  const Matrix existing = places_of(coded, space);
  MadeDesign made{.kind = "augmented design", .table = {}, .parents = {options.table}};
  Matrix unit;
  if (options.method == "d-optimal") {
    const auto design = optimal(space, options, (2.0 * existing.array() - 1.0).matrix(), made);
    const auto order = run_order(options.runs, options);
    unit = unit_of(Matrix(design.coded.bottomRows(options.runs))(order, Eigen::all));
  } else {
    unit = doe::filling_points(existing, options.runs,
                               {.seed = options.seed, .allowed = doe::constraint_filter(space)});
  }
  made.table = augmented(old, space, unit);
  made.facts["added"] = options.runs;
  made.lines.push_back(
      fmt::format("{} runs added below {}, column added", options.runs, old.rows()));
  finish(options, space, std::move(made));
}

void add_model(CLI::App& command, OptimalOptions& o) {
  command.add_option("--runs", o.runs, "new runs")->required()->check(CLI::Range(1, 100000));
  command.add_option("--model", o.model, "linear, interactions or quadratic")
      ->capture_default_str()
      ->check(CLI::IsMember({"linear", "interactions", "quadratic"}));
  command.add_option("--starts", o.starts, "random starts, of which the best is kept")
      ->capture_default_str()
      ->check(CLI::Range(1, 100000));
  command
      .add_option("--levels", o.levels,
                  "candidates in each range; 2, 3 for quadratic models and\n11 with constraints "
                  "unless given")
      ->check(CLI::Range(2, 1001));
  add_run_order(command, o);
}

}  // namespace

void add_design_optimal(CLI::App& group) {
  auto d = std::make_shared<OptimalOptions>();
  d->model = "interactions";
  auto* optimal = add_design_kind(group, "d-optimal",
                                  "Runs that estimate a given model best; obeys constraints",
                                  "--factors factors.toml --model quadratic --runs 30", *d);
  add_factors_file(*optimal, *d);
  add_model(*optimal, *d);
  optimal->callback([d] { d_optimal(*d); });

  auto a = std::make_shared<OptimalOptions>();
  a->model = "quadratic";
  auto* more =
      add_design_kind(group, "augment", "Adds runs to a table: in its gaps, or best for a model",
                      "runs.h5 --runs 10 --method d-optimal --model quadratic", *a);
  more->add_option("TABLE", a->table, "FILE.h5, FILE.h5:/group or FILE.csv, one run a row")
      ->required();
  more->add_option("--method", a->method, "space-filling or d-optimal")
      ->capture_default_str()
      ->check(CLI::IsMember({"space-filling", "d-optimal"}));
  more->add_option("--columns", a->columns, "the factors' columns, as for design check")
      ->delimiter(',');
  more->add_option("--factors", a->factors,
                   "TOML file with names, ranges and constraints; without it\nthe ranges in the "
                   "table, or its lowest and highest values");
  add_model(*more, *a);
  more->callback([a] { augment(*a); });
}

}  // namespace repose::cli

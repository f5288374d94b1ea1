// What the commands that make designs share.
#include "design_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

/// Of categorical parameters the places of the names.
std::vector<double> values_of(const table::Table& table, const Parameter& p) {
  if (p.kind != ParameterKind::categorical) return table.numbers(p.name);
  std::vector<double> values;
  for (const auto& name : table.texts(p.name)) {
    const auto place = std::find(p.categories.begin(), p.categories.end(), name);
    values.push_back(static_cast<double>(place - p.categories.begin()));
  }
  return values;
}

struct Broken {
  std::size_t run = 0;  ///< from 1
  std::vector<std::string> constraints;
};

std::vector<Broken> broken_constraints(const ParameterSpace& space, const table::Table& table) {
  if (space.constraints().empty()) return {};
  Matrix natural(static_cast<Eigen::Index>(table.rows()),
                 static_cast<Eigen::Index>(space.dimension()));
  for (std::size_t j = 0; j < space.dimension(); ++j) {
    const auto values = values_of(table, space.parameters()[j]);
    natural.col(static_cast<Eigen::Index>(j)) =
        Eigen::Map<const Vector>(values.data(), natural.rows());
  }
  std::vector<Broken> broken;
  for (Eigen::Index run = 0; run < natural.rows(); ++run) {
    auto constraints = space.broken_constraints(natural.row(run).transpose());
    if (!constraints.empty())
      broken.push_back({static_cast<std::size_t>(run) + 1, std::move(constraints)});
  }
  return broken;
}

void warn(const std::vector<Broken>& broken) {
  if (broken.empty()) return;
  fmt::print(stderr, "repose: {} of the runs break{} constraints:\n", broken.size(),
             broken.size() == 1 ? "s" : "");
  for (const auto& b : broken)
    for (const auto& constraint : b.constraints)
      fmt::print(stderr, "  run {}: {}\n", b.run, constraint);
  fmt::print(stderr,
             "  leave them out, narrow the ranges, or use lhs, sobol, halton or d-optimal, which "
             "obey constraints\n");
}

nlohmann::json as_json(const std::vector<Broken>& broken) {
  nlohmann::json json = nlohmann::json::array();
  for (const auto& b : broken) json.push_back({{"run", b.run}, {"constraints", b.constraints}});
  return json;
}

}  // namespace

CLI::App* add_design_kind(CLI::App& group, const std::string& name, const std::string& description,
                          const std::string& arguments, DesignOptions& options) {
  auto* command =
      add_command(group, name, description,
                  fmt::format("repose design {} {} -o design.h5", name, arguments), options.common);
  command->add_option("-o,--output", options.output, "table to write (.h5 or .csv)")->required();
  command->add_option("--seed", options.seed, "of run order and random numbers")
      ->capture_default_str();
  return command;
}

void add_factors_file(CLI::App& command, DesignOptions& options) {
  command.add_option("--factors", options.factors, "TOML file with names and ranges")->required();
  command.footer(command.get_footer() + R"(
with factors.toml:
  [parameters]
  mu_s_pp = { lower = 0.3, upper = 0.9 }
  stiffness = { lower = 1e6, upper = 1e8, scale = "log", unit = "Pa" }
  layers = { lower = 2, upper = 6, integer = true }
  mesh_m = { levels = [0.1, 0.2] }
  mode = { categories = ["layered", "mixed"] }
and, if wanted:
  [fixed]
  mu_s_ss = 0.5
  [ties]                                    # the mean of its sources
  mu_s_ps = ["mu_s_pp", "mu_s_ss"]
  [constraints]                             # lower <= sum of coefficient x value <= upper
  slope = { coefficients = { mu_s_pp = 1, mesh_m = -2 }, upper = 0.5 })");
}

void add_run_order(CLI::App& command, DesignOptions& options) {
  command.add_option("--run-order", options.run_order, "randomised or structured")
      ->capture_default_str()
      ->check(CLI::IsMember({"randomised", "structured"}));
}

void add_centre_runs(CLI::App& command, int& centre_runs, const std::string& description) {
  command.add_option("--centre-runs", centre_runs, description)
      ->capture_default_str()
      ->check(CLI::Range(0, 1000));
}

std::vector<Eigen::Index> run_order(Eigen::Index runs, const DesignOptions& options) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(runs));
  std::iota(order.begin(), order.end(), 0);
  if (options.run_order == "randomised") RandomStream(options.seed).shuffle(order);
  return order;
}

Matrix unit_of(const Matrix& coded) {
  return 0.5 * (coded.array() + 1.0).matrix();
}

void require_levels(const ParameterSpace& space, Needs needs, const std::string& design) {
  for (const auto& p : space.parameters()) {
    const auto fail = [&](const std::string& why) {
      throw InputError(fmt::format(
          "parameter {}: {}, but a {} needs {}: change or fix it, or choose lhs, sobol, halton or "
          "d-optimal",
          p.name, why, design,
          needs == Needs::two_levels     ? "two"
          : needs == Needs::three_levels ? "two ends and a middle"
                                         : "a range"));
    };
    const auto levels = level_count(p);
    if (p.kind == ParameterKind::categorical && (levels > 2 || needs != Needs::two_levels))
      fail(fmt::format("it has {} names", levels));
    if (needs == Needs::three_levels && levels % 2 == 0 && levels > 0)
      fail(fmt::format("{} levels have no middle", levels));
    if (needs == Needs::any_distance && levels > 0) fail(fmt::format("it has {} levels", levels));
  }
}

table::Table design_table(const ParameterSpace& space, const Matrix& unit) {
  return runs_table(space, space.from_unit_rows(unit));
}

table::Table runs_table(const ParameterSpace& space, const Matrix& natural) {
  const auto runs = static_cast<std::size_t>(natural.rows());
  table::Table table;
  std::vector<std::int64_t> run(runs);
  std::iota(run.begin(), run.end(), 1);
  table.add({.name = "run", .role = table::Role::id, .range = {}, .values = run});
  for (Eigen::Index j = 0; j < natural.cols(); ++j)
    table.add(
        table::factor_column(space.parameters()[static_cast<std::size_t>(j)],
                             {natural.col(j).data(), natural.col(j).data() + natural.rows()}));
  std::vector<std::string> others;
  for (const auto& [name, value] : space.fixed()) others.push_back(name);
  for (const auto& tie : space.ties()) others.push_back(tie.name);
  for (const auto& name : others) {
    std::vector<double> values;
    for (Eigen::Index i = 0; i < natural.rows(); ++i)
      values.push_back(space.complete(natural.row(i).transpose()).at(name));
    table.add({.name = name, .range = {}, .values = std::move(values)});
  }
  return table;
}

void add_integers(table::Table& table, const std::string& name, const std::vector<int>& values) {
  table.add({.name = name,
             .range = {},
             .values = std::vector<std::int64_t>(values.begin(), values.end())});
}

void finish(const DesignOptions& options, const ParameterSpace& space, MadeDesign design) {
  auto& table = design.table;
  table.attributes["design"] = design.kind;
  if (!options.factors.empty()) design.parents.push_back(options.factors);
  table::stamp_provenance(table, command_line(), options.seed, design.parents);
  const auto broken = broken_constraints(space, table);
  table::write_table(table::parse_location(options.output), table);
  warn(broken);
  if (options.common.json) {
    nlohmann::json json{{"design", design.kind}, {"runs", table.rows()}, {"file", options.output}};
    json.update(design.facts);
    json["broken_constraints"] = as_json(broken);
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}: {} runs of {} factors in {}\n", design.kind, table.rows(), space.dimension(),
             options.output);
  for (const auto& line : design.lines) fmt::print("  {}\n", line);
}

}  // namespace repose::cli

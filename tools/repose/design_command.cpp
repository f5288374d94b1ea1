// repose design dsd|lhs|check: the runs of an experiment as a table.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "design_columns.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/space_filling.hpp"
#include "repose/table/io.hpp"

namespace repose::cli {
namespace {

struct DesignOptions {
  CommonOptions common;
  std::string factors;
  std::string output;
  std::uint64_t seed = 1;
  int fake_factors = 2;
  int centre_runs = 1;
  int points = 0;
  std::string criterion = "maximin";
};

table::Table as_table(const ParameterSpace& space, const Matrix& unit) {
  const Matrix natural = space.from_unit_rows(unit);
  table::Table table;
  std::vector<std::int64_t> run(static_cast<std::size_t>(unit.rows()));
  for (std::size_t i = 0; i < run.size(); ++i) run[i] = static_cast<std::int64_t>(i) + 1;
  table.add({.name = "run", .role = table::Role::id, .range = {}, .values = run});
  for (Eigen::Index j = 0; j < natural.cols(); ++j)
    table.add(
        table::factor_column(space.parameters()[static_cast<std::size_t>(j)],
                             {natural.col(j).data(), natural.col(j).data() + natural.rows()}));
  return table;
}

void finish(const DesignOptions& options, table::Table table, const std::string& kind) {
  table.attributes["design"] = kind;
  table::stamp_provenance(table, command_line(), options.seed, {options.factors});
  table::write_table(table::parse_location(options.output), table);
  if (options.common.json)
    fmt::print(
        "{}\n",
        nlohmann::json{{"design", kind}, {"runs", table.rows()}, {"file", options.output}}.dump(2));
  else
    fmt::print("{}: {} runs of {} factors in {}\n", kind, table.rows(),
               table.names_with_role(table::Role::factor).size(), options.output);
}

void screening(const DesignOptions& options) {
  const auto space = read_factors(options.factors);
  const auto design = doe::definitive_screening_design(static_cast<int>(space.dimension()),
                                                       {.fake_factors = options.fake_factors,
                                                        .centre_runs = options.centre_runs,
                                                        .seed = options.seed});
  auto table = as_table(space, 0.5 * (design.coded.array() + 1.0).matrix());
  table.add({.name = "pair",
             .range = {},
             .values = std::vector<std::int64_t>(design.pair_id.begin(), design.pair_id.end())});
  finish(options, std::move(table), "definitive screening design");
}

void hypercube(const DesignOptions& options) {
  const auto space = read_factors(options.factors);
  using Criterion = doe::LatinHypercubeOptions::Criterion;
  const auto criterion = options.criterion == "plain"     ? Criterion::plain
                         : options.criterion == "maximin" ? Criterion::maximin
                                                          : Criterion::correlation;
  const int d = static_cast<int>(space.dimension());
  const int points = options.points > 0 ? options.points : 10 * d;
  finish(options,
         as_table(space,
                  doe::latin_hypercube(points, d, {.criterion = criterion, .seed = options.seed})),
         "latin hypercube");
}

std::shared_ptr<DesignOptions> add_kind(CLI::App& group, const std::string& name,
                                        const std::string& description,
                                        void (*run)(const DesignOptions&)) {
  auto options = std::make_shared<DesignOptions>();
  auto* command = add_command(
      group, name, description,
      "repose design " + name +
          " --factors factors.toml -o design.h5\n"
          "with factors.toml:\n  [parameters]\n  mu_s_pp = { lower = 0.3, upper = 0.9 }\n"
          "  stiffness = { lower = 1e6, upper = 1e8, scale = \"log\", unit = \"Pa\" }\n  ...",
      options->common);
  command->add_option("--factors", options->factors, "TOML file with names and ranges")->required();
  command->add_option("-o,--output", options->output, "table to write (.h5 or .csv)")->required();
  command->add_option("--seed", options->seed, "of run order and random numbers")
      ->capture_default_str();
  command->callback([options, run] { run(*options); });
  return options;
}

}  // namespace

void add_design(CLI::App& app) {
  auto* group = app.add_subcommand("design", "Designs experiments and checks designs");
  group->require_subcommand(1);
  auto dsd =
      add_kind(*group, "dsd", "Definitive screening design: three levels, 2 n + 1 runs", screening);
  group->get_subcommand("dsd")
      ->add_option("--fake-factors", dsd->fake_factors, "extra columns for an estimate of error")
      ->capture_default_str()
      ->check(CLI::Range(0, 20));
  group->get_subcommand("dsd")
      ->add_option("--centre-runs", dsd->centre_runs, "runs at the middle")
      ->capture_default_str()
      ->check(CLI::Range(1, 100));
  auto lhs = add_kind(*group, "lhs", "Latin hypercube: space-filling", hypercube);
  group->get_subcommand("lhs")
      ->add_option("--points", lhs->points, "runs; 10 for each factor unless given")
      ->check(CLI::Range(1, 1000000));
  group->get_subcommand("lhs")
      ->add_option("--criterion", lhs->criterion, "plain, maximin or correlation")
      ->capture_default_str()
      ->check(CLI::IsMember({"plain", "maximin", "correlation"}));
  add_design_check(*group);
}

}  // namespace repose::cli

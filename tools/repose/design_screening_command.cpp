// repose design dsd: definitive screening designs.
#include <fmt/format.h>

#include <memory>

#include "design_columns.hpp"
#include "design_table.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/doe/designs.hpp"

namespace repose::cli {
namespace {

using doe::DefinitiveScreeningOptions;

struct ScreeningOptions : DesignOptions {
  int fake_factors = 2;
  int centre_runs = 1;
  int blocks = 1;
  std::string block_centres = "each";
  std::string two_level_rule = "fold-over";
};

/// Places of the parameters that have two levels only; the others must have a middle.
std::vector<int> two_level_factors(const ParameterSpace& space) {
  std::vector<int> factors;
  std::vector<Parameter> others;
  for (std::size_t j = 0; j < space.dimension(); ++j) {
    if (level_count(space.parameters()[j]) == 2)
      factors.push_back(static_cast<int>(j));
    else
      others.push_back(space.parameters()[j]);
  }
  require_levels(ParameterSpace(std::move(others)), Needs::three_levels,
                 "definitive screening design");
  return factors;
}

void screening(const ScreeningOptions& options) {
  const auto space = read_factors(options.factors);
  DefinitiveScreeningOptions wanted{.fake_factors = options.fake_factors,
                                    .centre_runs = options.centre_runs,
                                    .two_level_factors = two_level_factors(space),
                                    .blocks = options.blocks,
                                    .seed = options.seed};
  if (options.two_level_rule == "orthogonal")
    wanted.two_level_rule = DefinitiveScreeningOptions::TwoLevelRule::orthogonal;
  if (options.block_centres == "first")
    wanted.block_centres = DefinitiveScreeningOptions::BlockCentres::first_block;
  if (options.run_order == "structured") wanted.run_order = doe::RunOrder::structured;
  const auto design = doe::definitive_screening_design(static_cast<int>(space.dimension()), wanted);

  MadeDesign made{.kind = "definitive screening design",
                  .table = design_table(space, unit_of(design.coded))};
  add_integers(made.table, "pair", design.pair_id);
  if (options.blocks > 1) {
    add_integers(made.table, "block", design.block);
    made.lines.push_back(fmt::format("{} blocks, column block", options.blocks));
  }
  if (!wanted.two_level_factors.empty()) {
    std::vector<std::string> names;
    for (const int j : wanted.two_level_factors)
      names.push_back(space.names()[static_cast<std::size_t>(j)]);
    made.lines.push_back(
        fmt::format("two levels only, rule {}: {}", options.two_level_rule, listed(names)));
    made.facts["two_level_factors"] = names;
  }
  finish(options, space, std::move(made));
}

}  // namespace

void add_design_screening(CLI::App& group) {
  auto o = std::make_shared<ScreeningOptions>();
  auto* command =
      add_design_kind(group, "dsd", "Definitive screening design: three levels, 2 n + 1 runs",
                      "--factors factors.toml", *o);
  add_factors_file(*command, *o);
  command->add_option("--fake-factors", o->fake_factors, "extra columns for an estimate of error")
      ->capture_default_str()
      ->check(CLI::Range(0, 20));
  add_centre_runs(*command, o->centre_runs,
                  "runs at the middle of a block; with two-level factors\nmirrored pairs");
  command->add_option("--blocks", o->blocks, "1 to the number of factors; pairs stay together")
      ->capture_default_str();
  command
      ->add_option("--block-centres", o->block_centres,
                   "which blocks have centre runs: each, first")
      ->capture_default_str()
      ->check(CLI::IsMember({"each", "first"}));
  command
      ->add_option("--two-level-rule", o->two_level_rule,
                   "fold-over keeps main effects clear of second-order\neffects, orthogonal of "
                   "each other")
      ->capture_default_str()
      ->check(CLI::IsMember({"fold-over", "orthogonal"}));
  add_run_order(*command, *o);
  command->callback([o] { screening(*o); });
}

}  // namespace repose::cli

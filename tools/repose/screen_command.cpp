// repose screen: which factors of a table matter, by vote of the repetitions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <set>

#include "command.hpp"
#include "design_columns.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"
#include "screen_report.hpp"

namespace repose::cli {
namespace {

struct ScreenOptions {
  CommonOptions common;
  FactorOptions factors;
  std::string table;
  std::vector<std::string> responses;
  std::string replicate;
  std::string method = "stepwise";
  std::string terms = "main";
  std::string block;
  std::string direction, rule = "combine", stop = "p-value";
  std::string anova;
  std::vector<std::string> targets;
  std::string limits, ranges;
  doe::CoverageOptions coverage;
  std::string plots;
  doe::ScreeningOptions analysis;
};

/// The column that numbers repetitions: the one named, else the one with that role, else the one
/// with a customary name, else none.
std::string replicate_column(const table::Table& table, const std::string& named) {
  if (!named.empty()) return named;
  auto names = table.names_with_role(table::Role::replicate);
  if (names.empty())
    for (const auto& name : table.names())
      if (name == "repetition" || name == "replicate" || name == "rep") names.push_back(name);
  if (names.size() > 1)
    throw InputError(fmt::format("the columns {} all number repetitions; choose with --replicate",
                                 listed(names)));
  return names.empty() ? "" : names.front();
}

/// Rows sorted into runs and repetitions. Rows with the same levels are the same run; where levels
/// recur within a repetition, as in centre runs, they are taken in order.
struct RunsAndRepetitions {
  std::vector<std::string> repetitions;
  Matrix coded;                                 ///< of the runs
  std::vector<int> blocks;                      ///< of the runs; empty without
  std::vector<std::vector<Eigen::Index>> rows;  ///< [run][repetition], -1 where there is none
};

std::vector<std::string> sorted_labels(std::vector<std::string> labels) {
  std::sort(labels.begin(), labels.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;  // 2 before 10
  });
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  return labels;
}

/// The same levels in different blocks are different runs.
RunsAndRepetitions sort_rows(const Matrix& coded, const std::vector<std::string>& labels,
                             const std::vector<int>& blocks) {
  RunsAndRepetitions result;
  result.repetitions = sorted_labels(labels);
  const bool repeated = result.repetitions.size() > 1;
  std::map<std::string, std::size_t> number;
  for (std::size_t r = 0; r < result.repetitions.size(); ++r) number[result.repetitions[r]] = r;
  std::map<std::vector<double>, std::vector<std::size_t>> runs_with;  // of these levels, in order
  std::map<std::pair<std::vector<double>, std::size_t>, std::size_t> met;
  std::vector<Eigen::Index> first_rows;
  for (Eigen::Index row = 0; row < coded.rows(); ++row) {
    const std::size_t repetition = number.at(labels[static_cast<std::size_t>(row)]);
    const Vector vector = coded.row(row);
    std::vector<double> levels(vector.begin(), vector.end());
    if (!blocks.empty()) levels.push_back(blocks[static_cast<std::size_t>(row)]);
    auto& runs = runs_with[levels];
    const std::size_t occurrence = repeated ? met[{levels, repetition}]++ : runs.size();
    if (occurrence == runs.size()) {
      runs.push_back(result.rows.size());
      result.rows.emplace_back(result.repetitions.size(), -1);
      first_rows.push_back(row);
    }
    result.rows[runs[occurrence]][repetition] = row;
  }
  result.coded = coded(first_rows, Eigen::all);
  if (!blocks.empty())
    for (const auto row : first_rows)
      result.blocks.push_back(blocks[static_cast<std::size_t>(row)]);
  return result;
}

Matrix response_values(const RunsAndRepetitions& runs, const std::vector<double>& column) {
  Matrix values(runs.coded.rows(), static_cast<Eigen::Index>(runs.repetitions.size()));
  for (std::size_t run = 0; run < runs.rows.size(); ++run)
    for (std::size_t r = 0; r < runs.repetitions.size(); ++r) {
      const auto row = runs.rows[run][r];
      values(static_cast<Eigen::Index>(run), static_cast<Eigen::Index>(r)) =
          row < 0 ? std::numeric_limits<double>::quiet_NaN()
                  : column[static_cast<std::size_t>(row)];
    }
  return values;
}

const std::map<std::string, doe::StepDirection> kDirections{
    {"forward", doe::StepDirection::forward},
    {"backward", doe::StepDirection::backward},
    {"mixed", doe::StepDirection::mixed}};
const std::map<std::string, doe::HierarchyRule> kRules{
    {"combine", doe::HierarchyRule::combine},
    {"combine-joint", doe::HierarchyRule::combine_joint},
    {"restrict", doe::HierarchyRule::restrict},
    {"none", doe::HierarchyRule::none}};
const std::map<std::string, doe::StoppingRule> kStops{{"p-value", doe::StoppingRule::p_value},
                                                      {"aicc", doe::StoppingRule::aicc},
                                                      {"bic", doe::StoppingRule::bic}};
const std::map<std::string, doe::SumsOfSquares> kTypes{{"1", doe::SumsOfSquares::type_one},
                                                       {"2", doe::SumsOfSquares::type_two},
                                                       {"3", doe::SumsOfSquares::type_three}};
const std::map<std::string, doe::Heredity> kHeredities{{"strong", doe::Heredity::strong},
                                                       {"weak", doe::Heredity::weak},
                                                       {"none", doe::Heredity::none}};

template <typename Value>
std::vector<std::string> names_of(const std::map<std::string, Value>& values) {
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.push_back(name);
  return names;
}

doe::ScreeningOptions analysis_options(const ScreenOptions& options) {
  auto analysis = options.analysis;
  if (options.method == "fit-dsd") analysis.method = doe::ScreeningOptions::Method::fit_dsd;
  if (options.terms == "main") {
    analysis.candidates = doe::CandidateTerms::main_effects;
    analysis.direction = doe::StepDirection::backward;
  }
  if (!options.direction.empty()) analysis.direction = kDirections.at(options.direction);
  analysis.rule = kRules.at(options.rule);
  analysis.stop = kStops.at(options.stop);
  return analysis;
}

/// The block of each row; empty if the table has none, or if blocks are repetitions: those are
/// analysed apart as it is.
std::vector<int> block_numbers(const table::Table& table, const std::string& named,
                               const std::vector<std::string>& repetitions) {
  const auto names = table.names();
  if (named.empty() && std::find(names.begin(), names.end(), "block") == names.end()) return {};
  std::vector<int> blocks;
  for (const auto block : table.integers(named.empty() ? "block" : named))
    blocks.push_back(static_cast<int>(block));
  std::map<std::string, std::set<int>> of_repetition;
  for (std::size_t i = 0; i < blocks.size(); ++i) of_repetition[repetitions[i]].insert(blocks[i]);
  if (std::all_of(of_repetition.begin(), of_repetition.end(),
                  [](const auto& entry) { return entry.second.size() == 1; }))
    return {};
  return blocks;
}

/// "angle=41", "angle=41+-0.8" or "angle=41±0.8".
doe::Target target_of(const std::string& text) {
  const auto refuse = [&] {
    throw InputError(fmt::format(
        "--target {}: it must be RESPONSE=VALUE or RESPONSE=VALUE+-TOLERANCE, as in angle=41+-0.8",
        text));
  };
  const auto number = [&](const std::string& part) {
    char* end = nullptr;
    const double value = std::strtod(part.c_str(), &end);
    if (part.find_first_not_of("0123456789.eE+-") != std::string::npos || part.empty() ||
        end != part.c_str() + part.size() || !std::isfinite(value))
      refuse();
    return value;
  };
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse();
  doe::Target target{.response = text.substr(0, equals)};
  const std::string value = text.substr(equals + 1);
  for (const std::string sign : {"±", "+-"}) {
    const auto at = value.find(sign);
    if (at == std::string::npos) continue;
    target.value = number(value.substr(0, at));
    target.tolerance = number(value.substr(at + sign.size()));
    return target;
  }
  target.value = number(value);
  return target;
}

std::vector<Parameter> screened_ranges(const CodedDesign& design, const table::Table& table) {
  std::vector<Parameter> parameters;
  for (const auto& f : design.factors)
    parameters.push_back({.name = f.name,
                          .lower = f.lower,
                          .upper = f.upper,
                          .scale = f.scale,
                          .unit = table.column(f.name).unit});
  return parameters;
}

void cover(const ScreenOptions& options, const std::vector<doe::Target>& targets,
           ScreeningReport& report) {
  std::vector<Parameter> limits;
  if (!options.limits.empty()) limits = read_factors(options.limits).parameters();
  auto coverage = options.coverage;
  coverage.vote_share = report.options.vote_share;
  report.coverage = doe::cover_targets(report.screening, targets, ParameterSpace(report.screened),
                                       limits, coverage);
  if (!options.ranges.empty()) write_file_atomically(options.ranges, factors_toml(report));
}

void screen(const ScreenOptions& options) {
  std::vector<doe::Target> targets;
  for (const auto& text : options.targets) targets.push_back(target_of(text));
  const auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const auto responses = response_columns(table, options.responses);
  const auto replicate = replicate_column(table, options.replicate);
  auto others = responses;
  if (!replicate.empty()) others.push_back(replicate);
  if (!options.block.empty()) others.push_back(options.block);
  const auto design = coded_design(table, options.factors, others);
  const auto repetitions = replicate.empty() ? std::vector<std::string>(table.rows(), "1")
                                             : row_labels(table, replicate);
  const auto runs =
      sort_rows(design.coded, repetitions, block_numbers(table, options.block, repetitions));
  ScreeningReport report{.table = options.table,
                         .repetitions = runs.repetitions,
                         .coded = runs.coded,
                         .values = {},
                         .blocks = runs.blocks,
                         .screened = screened_ranges(design, table),
                         .options = analysis_options(options),
                         .anova = {},
                         .screening = {},
                         .coverage = {}};
  if (!options.anova.empty()) report.anova = kTypes.at(options.anova);
  for (const auto& name : responses)
    report.values.push_back(response_values(runs, table.numbers(name)));
  report.screening = doe::screen(report.coded, design.names(), responses, report.values,
                                 report.options, report.blocks);
  if (!targets.empty()) cover(options, targets, report);
  std::vector<std::filesystem::path> plots;
  if (!options.plots.empty()) plots = write_screening_plots(report, options.plots);
  if (options.common.json) {
    auto json = screening_json(report);
    for (const auto& file : plots) json["plots"].push_back(file.string());
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}", screening_text(report));
  if (!plots.empty()) fmt::print("\n{} figures in {}\n", plots.size(), options.plots);
  if (!options.ranges.empty()) fmt::print("\nproposed ranges in {}\n", options.ranges);
}

/// An option that would do nothing is a mistake.
void refuse_options_of_the_other_method(const CLI::App& command, const std::string& method) {
  const std::vector<std::string> stepwise{"--terms", "--leave", "--stop", "--direction", "--rule"};
  const std::vector<std::string> two_stage{"--alpha-1df",    "--alpha-2df",    "--alpha-more",
                                           "--alpha-second", "--interactions", "--quadratics",
                                           "--budget"};
  for (const auto& name : method == "stepwise" ? two_stage : stepwise)
    if (command.count(name) > 0)
      throw CLI::ValidationError(name, "has no meaning for --method " + method);
}

/// Thresholds of the two-stage analysis.
void add_two_stage_options(CLI::App& command, doe::FitDsdOptions& options) {
  const auto threshold = [&](const char* name, double& value, const char* meaning) {
    command.add_option(name, value, meaning)
        ->capture_default_str()
        ->check(CLI::Range(1e-12, 0.999));
  };
  threshold("--alpha-1df", options.alpha_one_df, "of fit-dsd, stage 1 with one degree of freedom");
  threshold("--alpha-2df", options.alpha_two_df, "with two");
  threshold("--alpha-more", options.alpha_more_df, "with more");
  threshold("--alpha-second", options.alpha_second,
            "of fit-dsd, stage 2: terms are added until p\nis "
            "above it");
  const auto heredity = [&](const char* name, doe::Heredity& value, const char* meaning) {
    command
        .add_option_function<std::string>(
            name, [&value](const std::string& text) { value = kHeredities.at(text); }, meaning)
        ->default_str("strong")
        ->check(CLI::IsMember(names_of(kHeredities)));
  };
  heredity("--interactions", options.interactions,
           "of fit-dsd, stage 2: how many of an interaction's\nfactors must be active, strong "
           "(both), weak, none");
  heredity("--quadratics", options.quadratics, "the same of quadratics");
  command
      .add_option("--budget", options.search_budget,
                  "of fit-dsd, nodes of the search for the best subset")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000000));
}

}  // namespace

void add_screen(CLI::App& app) {
  auto o = std::make_shared<ScreenOptions>();
  auto* command = add_command(
      app, "screen", "Which factors matter? Each repetition analysed alone, then a vote",
      "repose screen runs.csv --response angle,flow --replicate repetition\n"
      "A row is one run of one repetition; rows with the same factors are the same run.",
      o->common);
  command->add_option("TABLE", o->table, "FILE.h5, FILE.h5:/group or FILE.csv")->required();
  command
      ->add_option("--response", o->responses,
                   "columns to explain; those with the role response\nunless given")
      ->delimiter(',');
  command->add_option("--replicate", o->replicate,
                      "column that numbers the repetitions; unless given the\none with that role, "
                      "or called repetition, replicate\nor rep");
  add_factor_options(*command, o->factors);
  command->add_option("--method", o->method, "stepwise or fit-dsd (the two-stage analysis)")
      ->capture_default_str()
      ->check(CLI::IsMember({"stepwise", "fit-dsd"}));
  command
      ->add_option("--terms", o->terms,
                   "of stepwise: main (backward from all main effects)\nor second-order (mixed "
                   "steps from none)")
      ->capture_default_str()
      ->check(CLI::IsMember({"main", "second-order"}));
  command->add_option("--alpha", o->analysis.alpha, "a term is significant if its p is below it")
      ->capture_default_str()
      ->check(CLI::Range(1e-12, 0.999));
  command->add_option("--leave", o->analysis.p_leave, "a term leaves if its p is above it")
      ->capture_default_str()
      ->check(CLI::Range(1e-12, 0.999));
  command
      ->add_option("--vote", o->analysis.vote_share,
                   "share of the repetitions that selects a factor")
      ->capture_default_str()
      ->check(CLI::Range(1e-6, 1.0));
  command
      ->add_option("--stop", o->stop,
                   "of stepwise: p-value (thresholds), or the smallest\naicc or bic")
      ->capture_default_str()
      ->check(CLI::IsMember(names_of(kStops)));
  command
      ->add_option(
          "--direction", o->direction,
          "of stepwise: forward, backward or mixed; backward\nfor --terms main, else mixed")
      ->check(CLI::IsMember(names_of(kDirections)));
  command
      ->add_option("--rule", o->rule,
                   "of stepwise, for terms whose main effects are not\nin the model: combine, "
                   "combine-joint, restrict, none")
      ->capture_default_str()
      ->check(CLI::IsMember(names_of(kRules)));
  add_two_stage_options(*command, o->analysis.fit_dsd);
  command->add_option("--block", o->block,
                      "column that numbers blocks of runs; \"block\" if\nthere is one");
  command
      ->add_option("--anova", o->anova,
                   "print the final models' analysis of variance, with\nsums of squares of type 1, "
                   "2 or 3")
      ->check(CLI::IsMember(names_of(kTypes)));
  command
      ->add_option("--target", o->targets,
                   "RESPONSE=VALUE[+-TOLERANCE], measured: do the runs\nenclose it, and if not, "
                   "which way must ranges move?")
      ->delimiter(',');
  command->add_option("--limits", o->limits, "factors file with what is physically possible")
      ->needs("--target");
  command->add_option("--ranges", o->ranges, "factors file to write with the proposed ranges")
      ->needs("--target");
  command
      ->add_option("--margin", o->coverage.margin,
                   "share by which ranges are extended further than a\nlinear model asks for")
      ->capture_default_str()
      ->needs("--target")
      ->check(CLI::Range(0.0, 100.0));
  command
      ->add_option("--most", o->coverage.most_half_ranges,
                   "half ranges by which a side is extended at most")
      ->capture_default_str()
      ->needs("--target")
      ->check(CLI::Range(1e-6, 1000.0));
  command->add_option("--plots", o->plots, "folder for half-normal and main-effect plots (SVG)");
  command->callback([o, command] {
    refuse_options_of_the_other_method(*command, o->method);
    screen(*o);
  });
}

}  // namespace repose::cli

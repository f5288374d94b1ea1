// repose screen: which factors of a table matter, by vote of the repetitions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "command.hpp"
#include "design_columns.hpp"
#include "repose/base/error.hpp"
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
  std::string plots;
  doe::ScreeningOptions analysis;
};

/// The column that numbers repetitions: the one named, else the one with that role, else none.
std::string replicate_column(const table::Table& table, const std::string& named) {
  if (!named.empty()) return named;
  const auto names = table.names_with_role(table::Role::replicate);
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
  std::vector<std::vector<Eigen::Index>> rows;  ///< [run][repetition], -1 where there is none
};

std::vector<std::string> sorted_labels(std::vector<std::string> labels) {
  std::sort(labels.begin(), labels.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;  // 2 before 10
  });
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  return labels;
}

RunsAndRepetitions sort_rows(const Matrix& coded, const std::vector<std::string>& labels) {
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
    const std::vector<double> levels(vector.begin(), vector.end());
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

doe::ScreeningOptions analysis_options(const ScreenOptions& options) {
  auto analysis = options.analysis;
  if (options.method == "fit-dsd") analysis.method = doe::ScreeningOptions::Method::fit_dsd;
  if (options.terms == "main") {
    analysis.candidates = doe::CandidateTerms::main_effects;
    analysis.direction = doe::StepDirection::backward;
  }
  return analysis;
}

void screen(const ScreenOptions& options) {
  const auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const auto responses = response_columns(table, options.responses);
  const auto replicate = replicate_column(table, options.replicate);
  auto others = responses;
  if (!replicate.empty()) others.push_back(replicate);
  const auto design = coded_design(table, options.factors, others);
  const auto runs =
      sort_rows(design.coded, replicate.empty() ? std::vector<std::string>(table.rows(), "1")
                                                : row_labels(table, replicate));
  ScreeningReport report{.table = options.table,
                         .repetitions = runs.repetitions,
                         .coded = runs.coded,
                         .values = {},
                         .options = analysis_options(options),
                         .screening = {}};
  for (const auto& name : responses)
    report.values.push_back(response_values(runs, table.numbers(name)));
  report.screening =
      doe::screen(report.coded, design.names(), responses, report.values, report.options);
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
                      "column that numbers the repetitions; the one with\nthat role unless given");
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
  command->add_option("--plots", o->plots, "folder for half-normal and main-effect plots (SVG)");
  command->callback([o] { screen(*o); });
}

}  // namespace repose::cli

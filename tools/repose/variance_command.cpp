// repose variance: how much of a column's variance comes from the parameters.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "command.hpp"
#include "design_columns.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/doe/effect_size.hpp"
#include "repose/table/io.hpp"
#include "screen_report.hpp"

namespace repose::cli {
namespace {

struct VarianceOptions {
  CommonOptions common;
  std::string table;
  std::vector<std::string> responses;
  std::string by;
};

/// runs x most repetitions, NaN where a run has fewer.
Matrix grouped(const std::vector<std::string>& labels, const std::vector<double>& values) {
  std::map<std::string, std::size_t> number;
  std::vector<std::vector<double>> groups;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto [at, is_new] = number.try_emplace(labels[i], groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].push_back(values[i]);
  }
  std::size_t most = 0;
  for (const auto& group : groups) most = std::max(most, group.size());
  Matrix matrix =
      Matrix::Constant(static_cast<Eigen::Index>(groups.size()), static_cast<Eigen::Index>(most),
                       std::numeric_limits<double>::quiet_NaN());
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (std::size_t i = 0; i < groups[g].size(); ++i)
      matrix(static_cast<Eigen::Index>(g), static_cast<Eigen::Index>(i)) = groups[g][i];
  return matrix;
}

std::string verdict(const doe::VarianceDecomposition& v) {
  if (std::isnan(v.p_value))
    return v.observations == v.runs
               ? "no run is repeated: parameters and noise cannot be told apart"
               : "nothing varies";
  if (v.p_value >= 0.01) return "the runs cannot be told from noise (p >= 0.01)";
  return doe::is_stochastic(v) ? "stochasticity exceeds the parameters' share"
                               : "the parameters' share exceeds stochasticity";
}

/// One response: what its runs and repetitions say.
struct ResponseVariance {
  std::string response;
  doe::VarianceDecomposition decomposition;
  doe::SignalToRepetition signal;            ///< NaN if fewer than two runs are repeated
  doe::CoefficientOfVariation of_run_means;  ///< their spread
};

ResponseVariance analyse(const std::string& response, const Matrix& values) {
  ResponseVariance result{.response = response,
                          .decomposition = doe::decompose_variance(values),
                          .signal = {std::nan(""), std::nan("")}};
  std::vector<double> means;
  for (const double mean : doe::run_means(values))
    if (!std::isnan(mean)) means.push_back(mean);
  result.of_run_means = doe::coefficient_of_variation(
      Eigen::Map<const Vector>(means.data(), static_cast<Eigen::Index>(means.size())));
  const auto repeated = (values.array().isNaN() == false).rowwise().count();
  if ((repeated >= 2).count() >= 2) result.signal = doe::signal_to_repetition(values);
  return result;
}

void print_variance(const ResponseVariance& result) {
  const doe::VarianceDecomposition& v = result.decomposition;
  const auto item = [](const char* name, const std::string& value) {
    fmt::print("  {:<52}{:>14}\n", name, value);
  };
  fmt::print("\n{}: {} runs, {} values\n", result.response, v.runs, v.observations);
  item("share of the parameters, P = SSB/SST", percent_text(v.parameter_share, 2));
  item("share of stochasticity, S = SSW/SST", percent_text(v.stochastic_share, 2));
  item("P if nothing but noise were there", percent_text(v.noise_floor, 2));
  item("unbiased share of the parameters", percent_text(v.unbiased_share, 2));
  item(
      "standard deviation between runs, unbiased",
      number_text(std::isnan(v.unbiased_variance) ? v.unbiased_variance
                                                  : std::sqrt(std::max(0.0, v.unbiased_variance))));
  item("standard deviation of repetitions", number_text(std::sqrt(v.within_ms)));
  item("sum of squares between runs, SSB", fmt::format("{:.6g}", v.between_ss));
  item("sum of squares within runs, SSW", fmt::format("{:.6g}", v.within_ss));
  item(
      fmt::format("F on {} and {} degrees of freedom", v.runs - 1, v.observations - v.runs).c_str(),
      number_text(v.f));
  item("p", p_text(v.p_value));
  item("alpha, deviation of means over that of repetitions", number_text(result.signal.alpha));
  item("alpha if nothing but noise were there", number_text(result.signal.floor));
  item("coefficient of variation of means, n - 1", percent_text(result.of_run_means.sample, 2));
  item("coefficient of variation of means, n", percent_text(result.of_run_means.population, 2));
  fmt::print("  {}\n", verdict(v));
}

void variance(const VarianceOptions& options) {
  const auto table = table::read_table(table::parse_location(options.table), table::Missing::allow);
  const auto labels = row_labels(table, options.by);
  const auto responses = response_columns(table, options.responses);
  std::vector<ResponseVariance> results;
  for (const auto& name : responses) {
    try {
      results.push_back(analyse(name, grouped(labels, table.numbers(name))));
    } catch (const InputError& error) {
      throw InputError(fmt::format("column {}: {}", name, error.what()));
    }
  }
  if (options.common.json) {
    nlohmann::json json{{"table", options.table}, {"by", options.by}};
    for (const auto& result : results) {
      auto one = variance_json(result.decomposition);
      one["response"] = result.response;
      one["alpha"] = result.signal.alpha;
      one["alpha_of_noise"] = result.signal.floor;
      one["coefficient_of_variation_sample"] = result.of_run_means.sample;
      one["coefficient_of_variation_population"] = result.of_run_means.population;
      json["responses"].push_back(std::move(one));
    }
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}, runs by {}\n", options.table, options.by);
  for (const auto& result : results) print_variance(result);
}

}  // namespace

void add_variance(CLI::App& app) {
  auto o = std::make_shared<VarianceOptions>();
  auto* command = add_command(
      app, "variance", "Parameters or chance: where does a response's variance come from?",
      "repose variance runs.csv --response angle --by run\n"
      "Rows with the same value of the column RUN are repetitions of one run.",
      o->common);
  command->add_option("TABLE", o->table, "FILE.h5, FILE.h5:/group or FILE.csv")->required();
  command
      ->add_option("--response", o->responses,
                   "columns to decompose; those with the role response\nunless given")
      ->delimiter(',');
  command->add_option("--by", o->by, "column that tells runs apart: integers or text")->required();
  command->callback([o] { variance(*o); });
}

}  // namespace repose::cli

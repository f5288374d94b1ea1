// Coverage of targets as text, as JSON and as a factors file.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/text.hpp"
#include "repose/base/toml.hpp"
#include "screen_report.hpp"

namespace repose::cli {
namespace {

using doe::ProposedRange;
using doe::ResponseCoverage;

std::string target_text(const doe::Target& target) {
  return target.tolerance > 0.0 ? fmt::format("{:.5g} +- {:.3g}", target.value, target.tolerance)
                                : fmt::format("{:.5g}", target.value);
}

std::string directions(const ScreeningReport& report, const ResponseCoverage& coverage) {
  std::vector<std::string> up, down;
  for (std::size_t j = 0; j < coverage.direction.size(); ++j)
    if (coverage.direction[j] != 0)
      (coverage.direction[j] > 0 ? up : down).push_back(report.screening.factors[j]);
  std::vector<std::string> unclear;
  for (std::size_t j = 0; j < coverage.undirected.size(); ++j)
    if (coverage.undirected[j]) unclear.push_back(report.screening.factors[j]);
  if (up.empty() && down.empty() && unclear.empty())
    return "no factor is significant: there is nothing to move";
  std::string text;
  if (!up.empty()) text += "raise " + listed(up);
  if (!down.empty()) text += (text.empty() ? "lower " : "; lower ") + listed(down);
  if (!unclear.empty())
    text += (text.empty() ? "" : "; ") + listed(unclear) +
            (unclear.size() == 1 ? " matters" : " matter") +
            " through second-order terms only, which way is unknown";
  return text;
}

/// Which limits are in the way.
std::string limits_text(const ScreeningReport& report, const ResponseCoverage& coverage) {
  std::vector<std::string> names;
  for (std::size_t j = 0; j < coverage.direction.size(); ++j)
    if (coverage.direction[j] != 0 && report.coverage->ranges[j].at_limit)
      names.push_back(report.screening.factors[j]);
  return names.empty() ? "" : ": limits hold " + listed(names);
}

std::string response_text(const ScreeningReport& report, const ResponseCoverage& coverage) {
  using Position = ResponseCoverage::Position;
  std::string text =
      fmt::format("  {}: measured {}, runs {:.5g} to {:.5g}: {}\n", coverage.target.response,
                  target_text(coverage.target), coverage.lowest, coverage.highest,
                  coverage.position == Position::inside  ? "enclosed"
                  : coverage.position == Position::above ? "ABOVE all runs"
                                                         : "BELOW all runs");
  if (coverage.position != Position::inside) {
    text += wrapped(directions(report, coverage), 4);
    if (coverage.still_missing > 1e-9 * coverage.gap)
      text +=
          wrapped(fmt::format("the proposed ranges leave {:.3g} of {:.3g} missing{}",
                              coverage.still_missing, coverage.gap, limits_text(report, coverage)),
                  4);
  }
  if (coverage.stochastic)
    text += "    this KPI cannot calibrate: chance moves it more than the parameters do\n";
  return text;
}

}  // namespace

std::string coverage_text(const ScreeningReport& report) {
  std::string text = "\nTargets, by the means of the runs:\n";
  for (const auto& coverage : report.coverage->responses) text += response_text(report, coverage);
  const auto& ranges = report.coverage->ranges;
  if (std::none_of(ranges.begin(), ranges.end(), [](const ProposedRange& range) {
        return range.lower_extended || range.upper_extended;
      }))
    return text;
  text += "\nProposed ranges, first order and a quarter more:\n";
  for (const auto& range : ranges) {
    if (!range.lower_extended && !range.upper_extended) continue;
    text += fmt::format("  {:<24}  {:>10.4g}{} to {:>10.4g}{}  for {}{}\n", clipped(range.factor),
                        range.lower, range.lower_extended ? "*" : " ", range.upper,
                        range.upper_extended ? "*" : " ", listed(range.because),
                        range.at_limit ? " (at its limit)" : "");
  }
  return text + "  * extended\n";
}

nlohmann::json coverage_json(const ScreeningReport& report) {
  using Position = ResponseCoverage::Position;
  nlohmann::json targets = nlohmann::json::array(), ranges = nlohmann::json::array();
  for (const auto& coverage : report.coverage->responses) {
    nlohmann::json direction = nlohmann::json::object(), undirected = nlohmann::json::array();
    for (std::size_t j = 0; j < coverage.direction.size(); ++j)
      if (coverage.direction[j] != 0)
        direction[report.screening.factors[j]] = coverage.direction[j] > 0 ? "raise" : "lower";
      else if (coverage.undirected[j])
        undirected.push_back(report.screening.factors[j]);
    targets.push_back(
        {{"response", coverage.target.response},
         {"value", coverage.target.value},
         {"tolerance", coverage.target.tolerance},
         {"lowest_run", coverage.lowest},
         {"highest_run", coverage.highest},
         {"position", coverage.position == Position::inside  ? "inside"
                      : coverage.position == Position::above ? "above"
                                                             : "below"},
         {"gap", coverage.gap},
         {"still_missing", coverage.still_missing},
         {"can_calibrate", report.repetitions.size() > 1 ? nlohmann::json(!coverage.stochastic)
                                                         : nlohmann::json(nullptr)},
         {"move", direction},
         {"direction_unknown", undirected}});
  }
  for (const auto& range : report.coverage->ranges)
    ranges.push_back({{"factor", range.factor},
                      {"lower", range.lower},
                      {"upper", range.upper},
                      {"lower_extended", range.lower_extended},
                      {"upper_extended", range.upper_extended},
                      {"at_limit", range.at_limit},
                      {"because", range.because}});
  return {{"targets", targets}, {"ranges", ranges}};
}

std::string factors_toml(const ScreeningReport& report) {
  const auto& ranges = report.coverage->ranges;
  std::string text = "[parameters]\n";
  for (std::size_t j = 0; j < ranges.size(); ++j) {
    const auto& p = report.screened[j];
    text += fmt::format("{} = {{ lower = {}, upper = {}", toml_quoted(p.name),
                        shortest(ranges[j].lower), shortest(ranges[j].upper));
    if (p.scale == Scale::log) text += ", scale = \"log\"";
    if (!p.unit.empty() && p.unit != "1") text += ", unit = " + toml_quoted(p.unit);
    text += " }\n";
  }
  return text;
}

}  // namespace repose::cli

// A screening as text and as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "repose/base/text.hpp"
#include "screen_report.hpp"

namespace repose::cli {
namespace {

using doe::ResponseScreening;

constexpr std::size_t kWidestName = 22;
constexpr std::size_t kColumns = 100, kModelWidth = 20;

/// Characters of the longest name as it is printed.
std::size_t width_of(const std::vector<std::string>& names) {
  std::size_t width = 8;
  for (const auto& name : names) {
    const std::string shown = clipped(name);
    width = std::max(width, static_cast<std::size_t>(
                                std::count_if(shown.begin(), shown.end(),
                                              [](unsigned char c) { return (c & 0xC0) != 0x80; })));
  }
  return width;
}

std::string method_text(const doe::ScreeningOptions& options) {
  if (options.method == doe::ScreeningOptions::Method::fit_dsd)
    return fmt::format("two-stage analysis\nsignificant at p < {}", shortest(options.alpha));
  const auto direction = options.direction;
  std::string stop;
  if (options.stop != doe::StoppingRule::p_value)
    stop = options.stop == doe::StoppingRule::bic ? "smallest BIC, " : "smallest AICc, ";
  if (stop.empty() && direction != doe::StepDirection::backward)
    stop += fmt::format("enter at p <= {}, ", shortest(options.alpha));
  if (options.stop == doe::StoppingRule::p_value && direction != doe::StepDirection::forward)
    stop += fmt::format("leave at p > {}, ", shortest(std::max(options.p_leave, options.alpha)));
  return fmt::format("stepwise, {} {}\n{}significant at p < {}",
                     options.candidates == doe::CandidateTerms::main_effects
                         ? "main effects"
                         : "main and second-order effects",
                     direction == doe::StepDirection::backward  ? "backward"
                     : direction == doe::StepDirection::forward ? "forward"
                                                                : "mixed",
                     stop, shortest(options.alpha));
}

std::string variance_text(const ResponseScreening& response) {
  const doe::VarianceDecomposition& v = response.variance;
  std::string text =
      fmt::format("  parameters' share of the variance {} (noise alone: {})",
                  percent_text(v.parameter_share, 1), percent_text(v.noise_floor, 1));
  if (!std::isnan(v.f))
    text += fmt::format(";\n  unbiased {}; F = {:.3g}, p = {}", percent_text(v.unbiased_share, 1),
                        v.f, p_text(v.p_value));
  if (!std::isnan(response.signal.alpha))
    text += fmt::format(";\n  alpha = {} (noise alone: {})", number_text(response.signal.alpha),
                        number_text(response.signal.floor));
  return text + "\n";
}

/// A mark for each repetition, + where the factor is significant.
std::string votes_text(const ResponseScreening& response, Eigen::Index factor) {
  constexpr Eigen::Index kMost = 12;
  std::string text;
  for (Eigen::Index r = 0; r < std::min(kMost, response.significant.cols()); ++r)
    text += response.significant(factor, r) > 0.0 ? '+' : '.';
  return response.significant.cols() > kMost ? text + "..." : text;
}

std::string factors_text(const ScreeningReport& report, const ResponseScreening& response) {
  const auto& factors = report.screening.factors;
  const std::size_t width = width_of(factors);
  std::string text = fmt::format(
      "  {:<{}}  {:>10}  {:>9}  {:>4}  {:<{}}  {:>8}  {:>8}  {:>8}\n", "factor", width, "effect",
      "error", "of " + std::to_string(report.repetitions.size()), "votes",
      std::clamp<std::size_t>(report.repetitions.size(), 5, 15), "median p", "pooled p", "FDR");
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    text += fmt::format(
        "  {:<{}}  {:>10}  {:>9}  {:>4}  {:<{}}  {:>8}  {:>8}  {:>8}\n", clipped(factors[i]), width,
        fmt::format("{:+.4g}", response.effect(k)), number_text(response.pooled_standard_error(k)),
        response.count(k), votes_text(response, k),
        std::clamp<std::size_t>(report.repetitions.size(), 5, 15), p_text(response.p_value(k)),
        p_text(response.pooled_p_value(k)), p_text(response.false_discovery_rate(k)));
  }
  return text;
}

/// No second-order terms are better than those chosen, so many of them.
bool is_exact(const doe::FinalModel& model) {
  if (!model.two_stage) return true;
  const auto& steps = model.two_stage->steps;
  return std::all_of(steps.begin(), steps.end(), [](const auto& step) { return step.exact; });
}

/// Coefficient and p of a term in one repetition's model; empty if it is not in it.
std::string model_cell(const doe::FinalModel& model, const doe::Term* term) {
  std::size_t column = 0;
  if (term != nullptr) {
    const auto at = std::find(model.terms.begin(), model.terms.end(), *term);
    if (at == model.terms.end()) return "";
    column = static_cast<std::size_t>(at - model.terms.begin()) + 1;
  }
  const auto j = static_cast<Eigen::Index>(column);
  if (term == nullptr) return fmt::format("{:.4g}         ", model.fit.coefficients(j));
  return fmt::format("{:.3g} {:>9}", model.fit.coefficients(j), "(" + p_text(model.fit.p(j)) + ")");
}

std::string models_text(const ScreeningReport& report, const ResponseScreening& response) {
  std::vector<doe::Term> terms;
  for (const auto& model : response.models)
    terms.insert(terms.end(), model.terms.begin(), model.terms.end());
  std::sort(terms.begin(), terms.end());
  terms.erase(std::unique(terms.begin(), terms.end()), terms.end());
  std::vector<std::string> names;
  for (const auto& term : terms) names.push_back(doe::term_name(term, report.screening.factors));
  const std::size_t width = std::max(width_of(names), std::string("sigma (df)").size());
  std::string text = "\n  final models: coefficients in coded units (p)\n";
  const std::size_t abreast = (kColumns - 2 - width) / kModelWidth;
  for (std::size_t from = 0; from < response.models.size(); from += abreast) {
    const std::size_t to = std::min(response.models.size(), from + abreast);
    const auto line = [&](const std::string& name, const auto& cell) {
      std::string row = fmt::format("  {:<{}}", name, width);
      for (std::size_t r = from; r < to; ++r) row += fmt::format("{:>{}}", cell(r), kModelWidth);
      while (row.back() == ' ') row.pop_back();
      text += row + "\n";
    };
    line("term",
         [&](std::size_t r) { return fmt::format("{:.7}         ", report.repetitions[r]); });
    line("1", [&](std::size_t r) { return model_cell(response.models[r], nullptr); });
    for (std::size_t j = 0; j < terms.size(); ++j)
      line(clipped(names[j]),
           [&](std::size_t r) { return model_cell(response.models[r], &terms[j]); });
    line("sigma (df)", [&](std::size_t r) {
      const auto& fit = response.models[r].fit;
      return fmt::format("{} {:>9}", number_text(fit.sigma), fmt::format("({})", fit.residual_df));
    });
    const auto number = [](double value) {
      if (std::isnan(value)) return std::string("-         ");
      return fmt::format("{:.3f}         ", std::abs(value) < 5e-4 ? 0.0 : value);
    };
    line("R2", [&](std::size_t r) { return number(response.models[r].fit.r_squared); });
    line("predicted",
         [&](std::size_t r) { return number(response.models[r].diagnostics.predicted_r_squared); });
    if (std::any_of(response.models.begin() + static_cast<std::ptrdiff_t>(from),
                    response.models.begin() + static_cast<std::ptrdiff_t>(to),
                    [](const doe::FinalModel& m) { return !std::isnan(m.lack_of_fit.p); }))
      line("lack, p", [&](std::size_t r) { return number(response.models[r].lack_of_fit.p); });
    if (to < response.models.size()) text += "\n";
  }
  std::vector<std::string> cut;
  for (std::size_t r = 0; r < response.models.size(); ++r)
    if (!is_exact(response.models[r])) cut.push_back(report.repetitions[r]);
  if (!cut.empty())
    text += wrapped(fmt::format("repetition {}: the search ran out of its budget, better "
                                "second-order terms may exist; raise --budget",
                                listed(cut)),
                    2);
  return text;
}

const char* type_name(doe::SumsOfSquares type) {
  return type == doe::SumsOfSquares::type_one   ? "I"
         : type == doe::SumsOfSquares::type_two ? "II"
                                                : "III";
}

Eigen::Index candidate_count(const ScreeningReport& report) {
  return static_cast<Eigen::Index>(
      doe::candidate_terms(static_cast<int>(report.coded.cols()), report.options.candidates)
          .size());
}

std::string anova_text(const ScreeningReport& report, std::size_t response) {
  std::string text;
  for (std::size_t r = 0; r < report.repetitions.size(); ++r) {
    const auto rows = final_anova(report, response, r, *report.anova);
    std::vector<std::string> names{"residual"};
    for (const auto& row : rows) names.push_back(row.term);
    const std::size_t width = width_of(names);
    text += fmt::format(
        "\n  analysis of variance, type {}, of repetition {}\n  {:<{}}  {:>10}  {:>4}  "
        "{:>10}  {:>10}  {:>8}\n",
        type_name(*report.anova), report.repetitions[r], "term", width, "sum of sq.", "df",
        "mean sq.", "F", "p");
    for (const auto& row : rows)
      text += fmt::format("  {:<{}}  {:>10.4g}  {:>4}  {:>10.4g}  {:>10}  {:>8}\n",
                          clipped(row.term), width, row.sum_of_squares, row.df,
                          row.sum_of_squares / row.df, number_text(row.f), p_text(row.p));
    const auto& fit = report.screening.responses[response].models[r].fit;
    text += fmt::format("  {:<{}}  {:>10.4g}  {:>4}  {:>10}\n", "residual", width, fit.residual_ss,
                        fit.residual_df, number_text(fit.sigma * fit.sigma));
  }
  return text;
}

}  // namespace

std::string p_text(double p) {
  if (std::isnan(p)) return "-";
  return p < 1e-3 ? fmt::format("{:.0e}", p) : fmt::format("{:.3f}", p);
}

std::string number_text(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.4g}", value);
}

std::string percent_text(double share, int digits) {
  return std::isnan(share) ? "-" : fmt::format("{:.{}f} %", 100.0 * share, digits);
}

std::string clipped(const std::string& name) {
  std::vector<std::size_t> starts;  // of the characters, which in UTF-8 may have several bytes
  for (std::size_t i = 0; i < name.size(); ++i)
    if ((static_cast<unsigned char>(name[i]) & 0xC0) != 0x80) starts.push_back(i);
  if (starts.size() <= kWidestName) return name;
  constexpr std::size_t kHead = (kWidestName - 3) / 2, kTail = kWidestName - 3 - kHead;
  return name.substr(0, starts[kHead]) + "..." + name.substr(starts[starts.size() - kTail]);
}

std::string wrapped(const std::string& text, std::size_t indent) {
  std::string result, line;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!line.empty() && indent + line.size() + 1 + word.size() > kColumns) {
      result += std::string(indent, ' ') + line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return result + std::string(indent, ' ') + line + "\n";
}

std::vector<std::string> selected_names(const doe::Screening& screening) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < screening.factors.size(); ++i)
    if (screening.selected[i]) names.push_back(screening.factors[i]);
  return names;
}

bool ScreeningReport::is_selected(const ResponseScreening& response, std::size_t factor) const {
  return doe::vote({response.count}, static_cast<int>(repetitions.size()),
                   options.vote_share)[factor];
}

std::vector<doe::AnovaRow> final_anova(const ScreeningReport& report, std::size_t response,
                                       std::size_t repetition, doe::SumsOfSquares type) {
  const doe::FinalModel& model = report.screening.responses[response].models[repetition];
  std::vector<int> blocks;
  if (!report.blocks.empty())
    for (const auto run : model.runs)
      blocks.push_back(report.blocks[static_cast<std::size_t>(run)]);
  const Vector y = report.values[response].col(static_cast<Eigen::Index>(repetition))(model.runs);
  return doe::analysis_of_variance(report.coded(model.runs, Eigen::all), y,
                                   report.screening.factors, model.terms, type, blocks);
}

std::string screening_text(const ScreeningReport& report) {
  std::string text =
      fmt::format("{}: {} runs of {} factors, {} repetition{}\n{}\n", report.table,
                  report.coded.rows(), report.coded.cols(), report.repetitions.size(),
                  report.repetitions.size() == 1 ? "" : "s", method_text(report.options));
  if (const auto candidates = candidate_count(report);
      report.options.stop != doe::StoppingRule::p_value && candidates >= report.coded.rows())
    text += fmt::format(
        "{} candidate terms for {} runs: AICc and BIC keep false ones here "
        "(docs/validation/statistics.md)\n",
        candidates, report.coded.rows());
  for (std::size_t i = 0; i < report.screening.responses.size(); ++i) {
    const auto& response = report.screening.responses[i];
    text += fmt::format("\n{}\n", response.response) + variance_text(response) + "\n";
    text += factors_text(report, response) + models_text(report, response);
    if (report.anova) text += anova_text(report, i);
  }
  const auto names = selected_names(report.screening);
  text += fmt::format("\nSelected, in {:.0f} % of the repetitions for one response at least:\n",
                      100.0 * report.options.vote_share);
  text += names.empty() ? "  none\n" : wrapped(fmt::format("{}", fmt::join(names, " ")), 2);
  if (report.coverage) text += coverage_text(report);
  return text +
         "\neffect: mean coefficient of the main effect, half of the change from low to high; "
         "error: of it,\nfrom the repetitions; votes: + where a term with the factor is "
         "significant "
         "in the final model;\npooled p: of the main effect, all repetitions together against "
         "their "
         "own variance;\nFDR: false-discovery rate at which that test finds it, all factors and "
         "responses together.\n";
}

}  // namespace repose::cli

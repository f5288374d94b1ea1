// A screening as text and as JSON.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/text.hpp"
#include "screen_report.hpp"

namespace repose::cli {
namespace {

using doe::ResponseScreening;

constexpr std::size_t kWidestName = 24;
constexpr std::size_t kColumns = 100, kModelWidth = 18;

std::size_t width_of(const std::vector<std::string>& names) {
  std::size_t width = 8;
  for (const auto& name : names) width = std::max(width, std::min(name.size(), kWidestName));
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
      fmt::format("  parameters' share of the variance {:.1f} % (noise alone: {:.1f} %)",
                  100.0 * v.parameter_share, 100.0 * v.noise_floor);
  if (!std::isnan(v.f))
    text += fmt::format(";\n  unbiased {:.1f} %; F = {:.3g}, p = {}", 100.0 * v.unbiased_share, v.f,
                        p_text(v.p_value));
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
    text += fmt::format("  {:<{}}  {:>10}  {:>9}  {:>4}  {:<{}}  {:>8}  {:>8}  {:>8}\n",
                        clipped(factors[i]), width, fmt::format("{:+.4g}", response.effect(k)),
                        fmt::format("{:.3g}", response.pooled_standard_error(k)), response.count(k),
                        votes_text(response, k),
                        std::clamp<std::size_t>(report.repetitions.size(), 5, 15),
                        p_text(response.p_value(k)), p_text(response.pooled_p_value(k)),
                        p_text(response.false_discovery_rate(k)));
  }
  return text;
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
    if (!response.models[r].exact_search) cut.push_back(report.repetitions[r]);
  if (!cut.empty())
    text += fmt::format(
        "  repetition {}: the search ran out of its budget, better second-order terms may "
        "exist;\n  raise --budget\n",
        listed(cut));
  return text;
}

const char* type_name(doe::SumsOfSquares type) {
  return type == doe::SumsOfSquares::type_one   ? "I"
         : type == doe::SumsOfSquares::type_two ? "II"
                                                : "III";
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

nlohmann::json anova_json(const std::vector<doe::AnovaRow>& rows) {
  nlohmann::json json = nlohmann::json::array();
  for (const auto& row : rows)
    json.push_back({{"term", row.term},
                    {"sum_of_squares", row.sum_of_squares},
                    {"df", row.df},
                    {"f", row.f},
                    {"p", row.p}});
  return json;
}

nlohmann::json lack_of_fit_json(const doe::LackOfFit& lack) {
  return {{"lack_ss", lack.lack_ss},
          {"lack_df", lack.lack_df},
          {"pure_ss", lack.pure_ss},
          {"pure_df", lack.pure_df},
          {"f", lack.f},
          {"p", lack.p}};
}

nlohmann::json model_json(const ScreeningReport& report, std::size_t response,
                          std::size_t repetition) {
  const doe::FinalModel& model = report.screening.responses[response].models[repetition];
  nlohmann::json terms = nlohmann::json::array();
  for (std::size_t j = 0; j <= model.terms.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    terms.push_back(
        {{"term", j == 0 ? "1" : doe::term_name(model.terms[j - 1], report.screening.factors)},
         {"coefficient", model.fit.coefficients(i)},
         {"standard_error", model.fit.standard_errors(i)},
         {"t", model.fit.t(i)},
         {"p", model.fit.p(i)},
         {"variance_inflation", model.diagnostics.variance_inflation(i)}});
  }
  nlohmann::json runs = nlohmann::json::array();
  for (std::size_t i = 0; i < model.runs.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    runs.push_back({{"run", model.runs[i] + 1},
                    {"residual", model.diagnostics.residual(row)},
                    {"leverage", model.diagnostics.leverage(row)},
                    {"studentised_deleted", model.diagnostics.studentised_deleted(row)},
                    {"cooks_distance", model.diagnostics.cooks_distance(row)},
                    {"left_out_prediction", model.diagnostics.left_out(row)}});
  }
  const auto anova = [&](doe::SumsOfSquares type) {
    return anova_json(final_anova(report, response, repetition, type));
  };
  return {{"repetition", report.repetitions[repetition]},
          {"terms", terms},
          {"sigma", model.fit.sigma},
          {"residual_df", model.fit.residual_df},
          {"r_squared", model.fit.r_squared},
          {"predicted_r_squared", model.diagnostics.predicted_r_squared},
          {"press", model.diagnostics.press},
          {"aicc", model.criteria.aicc},
          {"bic", model.criteria.bic},
          {"lack_of_fit", lack_of_fit_json(model.lack_of_fit)},
          {"exact_search", model.exact_search},
          {"anova",
           {{"type_one", anova(doe::SumsOfSquares::type_one)},
            {"type_two", anova(doe::SumsOfSquares::type_two)},
            {"type_three", anova(doe::SumsOfSquares::type_three)}}},
          {"runs", runs}};
}

nlohmann::json response_json(const ScreeningReport& report, std::size_t index) {
  const ResponseScreening& response = report.screening.responses[index];
  nlohmann::json factors = nlohmann::json::array(), models = nlohmann::json::array();
  for (std::size_t i = 0; i < report.screening.factors.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    nlohmann::json p = nlohmann::json::array(), significant = nlohmann::json::array();
    for (Eigen::Index r = 0; r < response.p_values.cols(); ++r) {
      p.push_back(response.p_values(k, r));
      significant.push_back(response.significant(k, r) > 0.0);
    }
    factors.push_back({{"factor", report.screening.factors[i]},
                       {"effect", response.effect(k)},
                       {"pooled_standard_error", response.pooled_standard_error(k)},
                       {"times_significant", static_cast<int>(response.count(k))},
                       {"significant", significant},
                       {"p_values", p},
                       {"median_p", response.p_value(k)},
                       {"pooled_p", response.pooled_p_value(k)},
                       {"false_discovery_rate", response.false_discovery_rate(k)},
                       {"selected", report.is_selected(response, i)}});
  }
  for (std::size_t r = 0; r < response.models.size(); ++r)
    models.push_back(model_json(report, index, r));
  return {{"response", response.response},
          {"factors", factors},
          {"models", models},
          {"alpha", response.signal.alpha},
          {"alpha_of_noise", response.signal.floor},
          {"variance", variance_json(response.variance)}};
}

std::vector<std::string> selected_names(const doe::Screening& screening) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < screening.factors.size(); ++i)
    if (screening.selected[i]) names.push_back(screening.factors[i]);
  return names;
}

}  // namespace

std::string p_text(double p) {
  if (std::isnan(p)) return "-";
  return p < 1e-3 ? fmt::format("{:.0e}", p) : fmt::format("{:.3f}", p);
}

std::string number_text(double value) {
  return std::isnan(value) ? "-" : fmt::format("{:.4g}", value);
}

std::string clipped(const std::string& name) {
  return name.size() <= kWidestName ? name : name.substr(0, kWidestName - 3) + "...";
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
  for (std::size_t i = 0; i < report.screening.responses.size(); ++i) {
    const auto& response = report.screening.responses[i];
    text += fmt::format("\n{}\n", response.response) + variance_text(response) + "\n";
    text += factors_text(report, response) + models_text(report, response);
    if (report.anova) text += anova_text(report, i);
  }
  const auto names = selected_names(report.screening);
  text += fmt::format("\nSelected, in {:.0f} % of the repetitions for one response at least:\n",
                      100.0 * report.options.vote_share);
  std::string line = " ";
  for (const auto& name : names) {
    if (line.size() + name.size() + 1 > 98) {
      text += line + "\n";
      line = " ";
    }
    line += " " + name;
  }
  text += names.empty() ? "  none\n" : line + "\n";
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

nlohmann::json variance_json(const doe::VarianceDecomposition& v) {
  return {{"runs", v.runs},
          {"observations", v.observations},
          {"between_ss", v.between_ss},
          {"within_ss", v.within_ss},
          {"parameter_share", v.parameter_share},
          {"stochastic_share", v.stochastic_share},
          {"noise_floor", v.noise_floor},
          {"within_ms", v.within_ms},
          {"unbiased_variance", v.unbiased_variance},
          {"unbiased_share", v.unbiased_share},
          {"f", v.f},
          {"p_value", v.p_value}};
}

nlohmann::json screening_json(const ScreeningReport& report) {
  const bool stepwise = report.options.method == doe::ScreeningOptions::Method::stepwise;
  nlohmann::json json{{"table", report.table},
                      {"runs", report.coded.rows()},
                      {"factors", report.screening.factors},
                      {"repetitions", report.repetitions},
                      {"method", stepwise ? "stepwise" : "fit-dsd"},
                      {"alpha", report.options.alpha},
                      {"vote", report.options.vote_share},
                      {"responses", nlohmann::json::array()},
                      {"selected", selected_names(report.screening)}};
  if (stepwise) json["leave"] = std::max(report.options.p_leave, report.options.alpha);
  for (std::size_t i = 0; i < report.screening.responses.size(); ++i)
    json["responses"].push_back(response_json(report, i));
  if (report.coverage) json["coverage"] = coverage_json(report);
  return json;
}

}  // namespace repose::cli

// A screening as JSON.
#include <algorithm>

#include "screen_report.hpp"

namespace repose::cli {
namespace {

using doe::ResponseScreening;

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

nlohmann::json numbers(const Vector& values) {
  return std::vector<double>(values.begin(), values.end());
}

/// Both stages of the two-stage analysis; null for stepwise.
nlohmann::json two_stage_json(const ScreeningReport& report, const doe::FinalModel& model) {
  if (!model.two_stage) return nullptr;
  const doe::FitDsdResult& result = *model.two_stage;
  const auto& factors = report.screening.factors;
  nlohmann::json active = nlohmann::json::array(), steps = nlohmann::json::array();
  for (const int factor : result.active)
    active.push_back(factors[static_cast<std::size_t>(factor)]);
  for (const auto& step : result.steps) {
    nlohmann::json terms = nlohmann::json::array();
    for (const auto& term : step.terms) terms.push_back(doe::term_name(term, factors));
    steps.push_back({{"terms", terms},
                     {"residual_ss", step.residual_ss},
                     {"f", step.f},
                     {"p", step.p},
                     {"exact", step.exact}});
  }
  return {{"pairs", result.pairs},
          {"centre_runs", result.centre_runs},
          {"main_effects", numbers(result.main_effects)},
          {"t", numbers(result.t)},
          {"p", numbers(result.p)},
          {"error_df", result.fake_df + result.centre_df},
          {"alpha", result.alpha},
          {"active", active},
          {"active_t", numbers(result.active_t)},
          {"active_p", numbers(result.active_p)},
          {"sigma", result.stage1_sigma},
          {"sigma_df", result.stage1_df},
          {"second_f", result.second_f},
          {"second_p", result.second_p},
          {"steps", steps}};
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
          {"two_stage", two_stage_json(report, model)},
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

}  // namespace

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
  if (stepwise) {
    const auto& o = report.options;
    using doe::HierarchyRule, doe::StepDirection, doe::StoppingRule;
    json["leave"] = std::max(o.p_leave, o.alpha);
    json["terms"] = o.candidates == doe::CandidateTerms::main_effects ? "main" : "second-order";
    json["stop"] = o.stop == StoppingRule::p_value ? "p-value"
                   : o.stop == StoppingRule::aicc  ? "aicc"
                                                   : "bic";
    json["direction"] = o.direction == StepDirection::forward    ? "forward"
                        : o.direction == StepDirection::backward ? "backward"
                                                                 : "mixed";
    json["rule"] = o.rule == HierarchyRule::combine         ? "combine"
                   : o.rule == HierarchyRule::combine_joint ? "combine-joint"
                   : o.rule == HierarchyRule::restrict      ? "restrict"
                                                            : "none";
  }
  if (!report.blocks.empty()) json["blocks"] = report.blocks;
  for (const auto& p : report.screened)
    json["ranges"].push_back({{"factor", p.name},
                              {"lower", p.lower},
                              {"upper", p.upper},
                              {"scale", p.scale == Scale::log ? "log" : "linear"}});
  for (std::size_t i = 0; i < report.screening.responses.size(); ++i)
    json["responses"].push_back(response_json(report, i));
  if (report.coverage) json["coverage"] = coverage_json(report);
  return json;
}

}  // namespace repose::cli

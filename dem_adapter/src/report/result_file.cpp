// result.toml and the tables of a calibration.
#include <fmt/format.h>

#include <cmath>

#include "html_report.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/calibration.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/io.hpp"

namespace repose::dem_adapter {
namespace {

/// A TOML float: a whole number keeps its point, what is not finite is nan.
std::string number(double value) {
  if (!std::isfinite(value)) return "nan";
  auto text = shortest(value);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string result_toml(const Study& study, const Calibration& result,
                        const std::string& command_line) {
  std::string text = fmt::format(
      "# Result of a calibration by repose {}.\nrepose_result = 1\ntitle = {}\nseed = "
      "{}\ncommand_line = {}\n"
      "runs = {}\nfailed_runs = {}\nstopped_because = {}\n"
      "expected_weighted_error = {}\nverified_weighted_error = "
      "{}\nbest_screening_point_weighted_error = {}\n",
      version(), toml_quoted(study.title), study.seed, toml_quoted(command_line),
      result.data.observations.size(), result.data.failed(), toml_quoted(result.stop_reason),
      number(result.predicted_error), number(result.verified_error), number(result.baseline_error));
  text += "remarks = [";
  for (const auto& remark : result.remarks) text += fmt::format("\n  {},", toml_quoted(remark));
  text += result.remarks.empty() ? "]\n" : "\n]\n";

  text +=
      "\n# Every coefficient of the calibrated simulation, tied and fixed ones "
      "included.\n[values]\n";
  for (const auto& [name, value] : result.values)
    text += fmt::format("{} = {}\n", name, number(value));
  for (const auto& p : result.parameters)
    text += fmt::format(
        "\n[[parameter]]\nname = {}\nvalue = {}\ncalibrated = {}\nindistinguishable_from = {}\n"
        "indistinguishable_to = {}\nweakly_determined = {}\n",
        toml_quoted(p.name), number(p.value), p.selected, number(p.lowest), number(p.highest),
        p.is_ridge());
  for (const auto& k : result.kpis) {
    text += fmt::format(
        "\n[[kpi]]\nname = {}\ntarget = {}\ntarget_ci95 = {}\nweight = {}\npredicted = {}\n"
        "predicted_standard_deviation = {}\npredicted_relative_error = {}\nverified = {}\n"
        "verified_standard_deviation = {}\nverified_runs = {}\nverified_relative_error = {}\n"
        "best_screening_point = {}\nlowest_seen = {}\nhighest_seen = {}\nreached = {}\n",
        toml_quoted(k.target.target.name), number(k.target.target.value), number(k.target.ci95),
        number(k.target.target.weight), number(k.predicted.mean),
        number(k.predicted.standard_deviation()), number(k.predicted_relative_error()),
        number(k.verified.mean), number(k.verified.deviation), k.verified.count,
        number(k.verified_relative_error()), number(k.baseline.mean), number(k.lowest_seen),
        number(k.highest_seen), k.reached());
  }
  return text;
}

/// One row a factor and response: counts, p-values, effects.
table::Table screening_table(const doe::Screening& screening) {
  std::vector<std::string> factor, response;
  std::vector<double> count, p_value, pooled, effect, share;
  std::vector<std::int64_t> selected;
  for (const auto& r : screening.responses)
    for (std::size_t i = 0; i < screening.factors.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      factor.push_back(screening.factors[i]);
      response.push_back(r.response);
      count.push_back(r.count[k]);
      p_value.push_back(r.p_value[k]);
      pooled.push_back(r.pooled_p_value[k]);
      effect.push_back(r.effect[k]);
      share.push_back(r.variance.unbiased_share);
      selected.push_back(screening.selected[i] ? 1 : 0);
    }
  table::Table table;
  const auto add = [&](std::string name, table::Values values) {
    table.add({.name = std::move(name), .range = {}, .values = std::move(values)});
  };
  add("factor", factor);
  add("response", response);
  add("times_significant", count);
  add("p_value", p_value);
  add("pooled_p_value", pooled);
  add("effect", effect);
  add("parameter_share_of_variance", share);
  add("selected", selected);
  table.attributes["repetitions"] = std::int64_t{screening.repetitions};
  return table;
}

table::Table design_table(const Study& study, const Matrix& coded) {
  table::Table table;
  const Matrix natural = study.space.from_unit_rows(0.5 * (coded.array() + 1.0).matrix());
  for (std::size_t j = 0; j < study.space.dimension(); ++j) {
    const auto column = natural.col(static_cast<Eigen::Index>(j));
    table.add(table::factor_column(study.space.parameters()[j],
                                   {column.data(), column.data() + column.size()}));
  }
  return table;
}

/// The same model with inputs in natural units and on their scales, as its users have them.
surrogate::NamedModel model_in_natural_units(const Study& study, const SurrogateSet& set,
                                             std::size_t j) {
  std::vector<surrogate::Input> inputs;
  auto hyper = set.models[j].hyperparameters();
  Matrix x = set.x[j];
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    for (const auto& p : study.space.parameters()) {
      if (p.name != set.parameters[static_cast<std::size_t>(k)]) continue;
      inputs.push_back({.lower = p.lower, .upper = p.upper, .scale = p.scale});
      for (double& value : x.col(k)) value = natural_value(p, value);
      const double range = p.scale == Scale::log ? std::log(p.upper / p.lower) : p.upper - p.lower;
      if (study.surrogate.kernel.length_scales == surrogate::LengthScales::one_per_input)
        hyper.length_scales[k] *= range;
    }
  auto options = study.surrogate;
  options.seed = study.seed;
  return {surrogate::GaussianProcess::with_parameters(x, set.y[j], inputs, hyper, options),
          set.parameters, study.targets[j].target.name};
}

}  // namespace

void write_results(const std::filesystem::path& directory, const Study& study,
                   const Calibration& result, const std::string& command_line) {
  auto runs = result.data.table(study);
  table::stamp_provenance(runs, command_line, study.seed, {"study.toml"});
  table::write_table({directory / "runs.h5", ""}, runs);
  auto design = design_table(study, result.screening_design);
  table::stamp_provenance(design, command_line, study.seed, {"study.toml"});
  auto analysis = screening_table(result.screening);
  table::stamp_provenance(analysis, command_line, study.seed, {"runs.h5"});
  table::write_tables(directory / "screening.h5", {{"/design", design}, {"/analysis", analysis}});
  make_directory(directory / "models");
  for (std::size_t j = 0; j < study.targets.size(); ++j)
    surrogate::save_model(directory / "models" / (study.targets[j].target.name + ".h5"),
                          model_in_natural_units(study, result.surrogates, j));
  write_file_atomically(directory / "report.html", html_report(study, result));
  write_file_atomically(directory / "result.toml", result_toml(study, result, command_line));
}

}  // namespace repose::dem_adapter

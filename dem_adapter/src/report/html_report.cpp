#include "html_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/text.hpp"
#include "repose/plot/figure.hpp"

namespace repose::dem_adapter {
namespace {

using plot::Figure;

constexpr plot::Size kFigure{.width = 480, .height = 340};

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += c;
  }
  return result;
}

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
  std::string text = "<tr>";
  for (const auto& cell : cells) text += fmt::format("<{0}>{1}</{0}>", tag, escaped(cell));
  return text + "</tr>\n";
}

std::string section(const std::string& heading, const std::string& explanation,
                    const std::string& body) {
  return fmt::format("<section><h2>{}</h2>\n<p>{}</p>\n{}</section>\n", escaped(heading),
                     escaped(explanation), body);
}

plot::Axis axis_of(const std::string& kpi) {
  const auto label = label_of(kpi);
  return {.label = label.words, .unit = label.unit};
}

std::string percent(double fraction) {
  return std::isfinite(fraction) ? fmt::format("{:+.2f} %", 100.0 * fraction) : "-";
}

std::string share(double fraction) {
  return std::isfinite(fraction) ? fmt::format("{:.2f} %", 100.0 * fraction) : "-";
}

std::string with_spread(double value, double spread) {
  return std::isfinite(value) ? fmt::format("{:.4g} ± {:.2g}", value, spread) : "-";
}

std::string kpi_table(const Calibration& result) {
  std::string text = "<table>\n" + row({"KPI", "target", "predicted", "error", "verified", "error",
                                        "best screening point"},
                                       "th");
  for (const auto& k : result.kpis)
    text += row(
        {k.target.target.name,
         k.target.ci95 > 0.0
             ? fmt::format("{} ± {}", shortest(k.target.target.value), shortest(k.target.ci95))
             : shortest(k.target.target.value),
         with_spread(k.predicted.mean, k.predicted.standard_deviation()),
         percent(k.predicted_relative_error()), with_spread(k.verified.mean, k.verified.deviation),
         percent(k.verified_relative_error()), with_spread(k.baseline.mean, k.baseline.deviation)});
  return text + "</table>\n";
}

std::string parameter_table(const Study& study, const Calibration& result) {
  std::string text =
      "<table>\n" + row({"parameter", "value", "searched in", "cannot be told apart from"}, "th");
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const auto& p = result.parameters[i];
    const auto& declared = study.space.parameters()[i];
    text += row({p.name, fmt::format("{:.4g}", p.value),
                 fmt::format("{} ... {}", shortest(declared.lower), shortest(declared.upper)),
                 p.selected ? fmt::format("{:.3g} ... {:.3g}{}", p.lowest, p.highest,
                                          p.is_ridge() ? " (a ridge)" : "")
                            : "does not matter: middle of its range"});
  }
  return text + "</table>\n";
}

/// Effects in percent of the target, factors by responses.
std::string screening_figure(const Study& study, const Calibration& result) {
  const auto& screening = result.screening;
  std::vector<std::string> columns;
  Matrix effects(static_cast<Eigen::Index>(screening.factors.size()),
                 static_cast<Eigen::Index>(screening.responses.size()));
  for (std::size_t j = 0; j < screening.responses.size(); ++j) {
    const auto& r = screening.responses[j];
    columns.push_back(axis_of(r.response).label);
    effects.col(static_cast<Eigen::Index>(j)) = 100.0 * r.effect / study.targets[j].target.scale;
  }
  const int height = 140 + 34 * static_cast<int>(screening.factors.size());
  return Figure("Main effects", {.label = ""}, {.label = ""}, {.width = 640, .height = height})
      .heat_map(columns, screening.factors, effects,
                {.label = "effect of half the range", .unit = "% of the target"},
                plot::ColorScale::diverging)
      .svg();
}

/// Every run of a KPI in order, by phase, with the target's band.
std::string coverage_figure(const Calibration& result, const CalibratedKpi& kpi) {
  const auto& target = kpi.target;
  Figure figure("Runs and target", {.label = "run"}, axis_of(target.target.name), kFigure);
  figure.band(target.target.value - target.ci95, target.target.value + target.ci95, "target");
  for (const auto phase :
       {Phase::screening, Phase::sampling, Phase::adaptive, Phase::verification}) {
    std::vector<double> x, y;
    for (std::size_t i = 0; i < result.data.observations.size(); ++i) {
      const auto& o = result.data.observations[i];
      const auto value = o.kpi(target.target.name);
      if (result.data.points[o.point].phase != phase || !value || o.outcome.failed()) continue;
      x.push_back(static_cast<double>(i + 1));
      y.push_back(*value);
    }
    if (!x.empty()) figure.scatter(x, y, to_string(phase));
  }
  return figure.svg();
}

/// Left-out prediction against observation, one point a run.
std::string parity_figure(const SurrogateSet& set, std::size_t j, const CalibratedKpi& kpi) {
  const auto loo = set.models[j].leave_one_out();
  const auto axis = axis_of(kpi.target.target.name);
  auto x = axis, y = axis;
  x.label = "simulated " + axis.label;
  y.label = "predicted without it";
  const std::span<const double> observed(set.y[j].data(),
                                         static_cast<std::size_t>(set.y[j].size()));
  const std::span<const double> predicted(loo.predicted.data(),
                                          static_cast<std::size_t>(loo.predicted.size()));
  return Figure("Surrogate", x, y, kFigure)
      .scatter(observed, predicted)
      .diagonal()
      .note(fmt::format("R2 of points = {:.2f}", set.r2[j]))
      .svg();
}

std::string history_figure(const Study& study, const Calibration& result) {
  Figure figure("Adaptive sampling", {.label = "runs"}, {.label = "R2 of left-out points"},
                kFigure);
  for (std::size_t j = 0; j < study.targets.size(); ++j) {
    std::vector<double> x, y;
    for (const auto& step : result.history) {
      x.push_back(step.runs);
      y.push_back(step.r2[j]);
    }
    figure.lines(x, y, axis_of(study.targets[j].target.name).label);
  }
  figure.horizontal_line(study.adaptive.r2, "wanted");
  return figure.svg();
}

/// Expected weighted error over the two parameters with the largest effects, the others at the
/// optimum.
std::string error_map(const Study& study, const Calibration& result) {
  const auto& names = result.surrogates.parameters;
  if (names.size() < 2) return "";
  std::vector<std::pair<double, std::size_t>> strength;
  for (std::size_t i = 0; i < names.size(); ++i) {
    double largest = 0.0;
    for (std::size_t f = 0; f < result.screening.factors.size(); ++f)
      if (result.screening.factors[f] == names[i])
        for (std::size_t j = 0; j < result.screening.responses.size(); ++j)
          largest = std::max(
              largest,
              std::abs(result.screening.responses[j].effect[static_cast<Eigen::Index>(f)]) /
                  study.targets[j].target.scale);
    strength.emplace_back(-largest, i);
  }
  std::sort(strength.begin(), strength.end());
  const auto u = std::min(strength[0].second, strength[1].second);
  const auto v = std::max(strength[0].second, strength[1].second);
  constexpr int kCells = 40;
  const auto declared = [&](std::size_t k) {
    for (std::size_t i = 0; i < study.space.dimension(); ++i)
      if (study.space.parameters()[i].name == names[k]) return i;
    return std::size_t{0};
  };
  const auto& px = study.space.parameters()[declared(u)];
  const auto& py = study.space.parameters()[declared(v)];
  Vector natural(static_cast<Eigen::Index>(study.space.dimension()));
  for (std::size_t i = 0; i < study.space.dimension(); ++i)
    natural[static_cast<Eigen::Index>(i)] = result.values.at(study.space.parameters()[i].name);
  const Vector full = study.space.to_unit(natural);
  Vector optimum(static_cast<Eigen::Index>(names.size()));
  for (std::size_t k = 0; k < names.size(); ++k)
    optimum[static_cast<Eigen::Index>(k)] = full[static_cast<Eigen::Index>(declared(k))];
  Matrix points = optimum.transpose().replicate(kCells * kCells, 1);
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      points(i * kCells + j, static_cast<Eigen::Index>(v)) = (i + 0.5) / kCells;
      points(i * kCells + j, static_cast<Eigen::Index>(u)) = (j + 0.5) / kCells;
    }
  const auto targets = study.plain_targets();
  std::vector<std::vector<Gaussian>> predictions;
  for (const auto& model : result.surrogates.models)
    predictions.push_back(model.predict_rows(points));
  Matrix error(kCells, kCells);
  std::vector<Gaussian> kpis(targets.size());
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) {
      for (std::size_t k = 0; k < kpis.size(); ++k)
        kpis[k] = predictions[k][static_cast<std::size_t>(i * kCells + j)];
      error(i, j) = 100.0 * opt::weighted_error(std::span<const Gaussian>(kpis), targets).mean;
    }
  const auto edges = [&](const Parameter& p) {
    std::vector<double> e;
    for (int i = 0; i <= kCells; ++i) {
      const double s = static_cast<double>(i) / kCells;
      e.push_back(p.scale == Scale::log ? p.lower * std::pow(p.upper / p.lower, s)
                                        : p.lower + s * (p.upper - p.lower));
    }
    return e;
  };
  const double best_x = result.values.at(px.name), best_y = result.values.at(py.name);
  return Figure("Expected weighted error", {.label = px.name, .unit = px.unit, .scale = px.scale},
                {.label = py.name, .unit = py.unit, .scale = py.scale}, kFigure)
      .heat_map(edges(px), edges(py), error, {.label = "weighted error", .unit = "%"})
      .scatter(std::span(&best_x, 1), std::span(&best_y, 1), "calibrated")
      .svg();
}

std::string error_bars_figure(const Calibration& result) {
  std::vector<std::string> names;
  std::vector<double> predicted, verified, baseline, spread;
  for (const auto& k : result.kpis) {
    names.push_back(axis_of(k.target.target.name).label);
    predicted.push_back(100.0 * k.predicted_relative_error());
    verified.push_back(100.0 * k.verified_relative_error());
    baseline.push_back(100.0 * (k.baseline.mean - k.target.target.value) / k.target.target.scale);
    spread.push_back(100.0 * k.verified.deviation / k.target.target.scale);
  }
  return Figure("Relative errors", {.label = ""}, {.label = "error (%)"},
                {.width = 640, .height = 340})
      .bars(names, predicted, "predicted")
      .bars(names, verified, "verified (± sd of a run)", spread)
      .bars(names, baseline, "best screening point")
      .svg();
}

constexpr auto kStyle =
    R"(body{font-family:sans-serif;max-width:1020px;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:1em 0}td,th{border-bottom:1px solid #ccc;padding:.3em .8em;text-align:right}
td:first-child,th:first-child{text-align:left}.figures{display:flex;flex-wrap:wrap;gap:1em}
li{margin:.3em 0}section{margin:2.5em 0}svg{max-width:100%;height:auto})";

}  // namespace

std::string html_report(const Study& study, const Calibration& result) {
  std::string remarks;
  for (const auto& remark : result.remarks)
    remarks += fmt::format("<li>{}</li>\n", escaped(remark));
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta "
      "charset=\"utf-8\"><title>{0}</title>\n<style>{1}</style></head>"
      "<body>\n<h1>{0}</h1>\n<p>Calibrated by repose {2}: {3} runs, {4} failed. Weighted error: "
      "expected {5:.2f} %, "
      "verified {6}, best screening point {7}.</p>\n",
      escaped(study.title), kStyle, version(), result.data.observations.size(),
      result.data.failed(), 100.0 * result.predicted_error, share(result.verified_error),
      share(result.baseline_error));
  if (!remarks.empty()) html += fmt::format("<ul>\n{}</ul>\n", remarks);
  html += section("Result",
                  "Predicted: mean of the surrogate and its standard deviation. Verified: mean of "
                  "fresh runs with seeds "
                  "used nowhere else and the standard deviation of one run. The best screening "
                  "point was simulated "
                  "with the same seeds.",
                  kpi_table(result) + parameter_table(study, result) + error_bars_figure(result));
  html += section(
      "What matters",
      fmt::format(
          "A parameter is calibrated if it is significant (p < {}) in at least {:.0f} % of {} "
          "repetitions of the screening for one KPI.",
          shortest(study.screening.analysis.alpha), 100.0 * study.screening.analysis.vote_share,
          result.screening.repetitions),
      screening_figure(study, result));
  std::string figures = "<div class=\"figures\">\n";
  for (std::size_t j = 0; j < result.kpis.size(); ++j)
    figures += coverage_figure(result, result.kpis[j]) +
               parity_figure(result.surrogates, j, result.kpis[j]);
  figures += history_figure(study, result) + error_map(study, result) + "</div>\n";
  html +=
      section("Runs and surrogates",
              fmt::format("Adaptive sampling stopped because {}.", result.stop_reason), figures);
  return html + "</body></html>\n";
}

}  // namespace repose::dem_adapter

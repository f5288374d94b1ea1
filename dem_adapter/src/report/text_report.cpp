// The tables a calibration prints.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "repose/base/text.hpp"
#include "repose/dem_adapter/calibration.hpp"
#include "repose/doe/designs.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::size_t kBlock = 3;  // KPIs beside each other in 100 columns

/// Width of the longest name, at least that of `heading`.
template <class Range, class Name>
std::size_t width_of(const Range& range, Name name, std::string_view heading) {
  std::size_t width = heading.size();
  for (const auto& element : range) width = std::max(width, name(element).size());
  return width;
}

std::string percent(double fraction) {
  return std::isfinite(fraction) ? fmt::format("{:+.1f} %", 100.0 * fraction) : "-";
}

std::string share(double fraction) {
  return std::isfinite(fraction) ? fmt::format("{:.2f} %", 100.0 * fraction) : "-";
}

std::string noise_text(const doe::VarianceDecomposition& variance) {
  return std::isfinite(variance.unbiased_share)
             ? fmt::format("{:.0f} %", 100.0 * (1.0 - variance.unbiased_share))
             : "-";
}

std::string p_text(double p) {
  if (!std::isfinite(p)) return "-";
  return p < 1e-4 ? "<0.0001" : fmt::format("{:.4f}", p);
}

}  // namespace

std::string plan_text(const Study& study, unsigned workers, double seconds_per_run) {
  const auto counts = planned_runs(study);
  std::string text = fmt::format("{}\n\n", study.title);
  text += fmt::format("  {:<12} {:<10} {:>5} runs  {}\n", "screening", "", counts.screening,
                      fmt::format("definitive screening design of {} parameters, {} repetition{}",
                                  study.space.dimension(), study.screening.repetitions,
                                  study.screening.repetitions == 1 ? "" : "s"));
  text += fmt::format("  {:<12} {:<10} {:>5} runs  {}\n", "sampling", "at most", counts.sampling,
                      fmt::format("Latin hypercube, {} points for each that matters, {} run{} each",
                                  study.sampling.points_per_parameter, study.sampling.repetitions,
                                  study.sampling.repetitions == 1 ? "" : "s"));
  text += fmt::format(
      "  {:<12} {:<10} {:>5} runs  {}\n", "adaptive", "at most", counts.adaptive,
      fmt::format("expected improvement, {} batches of {} points, until R2 = {}",
                  study.adaptive.max_batches, study.adaptive.batch, shortest(study.adaptive.r2)));
  text += fmt::format("  {:<12} {:<10} {:>5} runs  {}\n", "verification", "", counts.verification,
                      "the calibrated and the best screening point, fresh seeds");
  text += fmt::format("  {:<12} {:<10} {:>5} runs, {} at once", "together", "at most",
                      counts.total(), workers);
  if (seconds_per_run > 0.0)
    text += fmt::format(", {:.1f} s each: about {}", seconds_per_run,
                        duration_text(seconds_per_run * counts.total() / workers));
  text += "\n\n  targets\n";
  for (const auto& t : study.targets)
    text +=
        fmt::format("    {} = {}{}, weight {:.3g}\n", t.target.name, shortest(t.target.value),
                    t.ci95 > 0.0 ? fmt::format(" ± {}", shortest(t.ci95)) : "", t.target.weight);
  text += "  parameters\n";
  for (const auto& p : study.space.parameters())
    text += fmt::format("    {} in [{}, {}]{}\n", p.name, shortest(p.lower), shortest(p.upper),
                        p.scale == Scale::log ? ", logarithmic" : "");
  for (const auto& tie : study.space.ties())
    text += fmt::format("    {} = {}{}\n", tie.name, tie.sources.size() > 1 ? "mean of " : "",
                        listed(tie.sources));
  return text;
}

std::string screening_text(const doe::Screening& screening) {
  const auto width = width_of(
      screening.factors, [](const auto& n) { return n; }, "share of noise");
  std::string text = fmt::format(
      "\nWhat matters: times significant in {} repetition{} (pooled p), sign of the effect\n",
      screening.repetitions, screening.repetitions == 1 ? "" : "s");
  const auto& responses = screening.responses;
  for (std::size_t from = 0; from < responses.size(); from += kBlock) {
    const auto block =
        std::span(responses).subspan(from, std::min(kBlock, responses.size() - from));
    const bool last = from + kBlock >= responses.size();
    text += fmt::format("\n  {:<{}}", "parameter", width);
    for (const auto& r : block) text += fmt::format("  {:>19}", r.response);
    text += last ? "  chosen\n" : "\n";
    for (std::size_t i = 0; i < screening.factors.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      text += fmt::format("  {:<{}}", screening.factors[i], width);
      for (const auto& r : block)
        text += fmt::format("  {:>19}",
                            fmt::format("{:.0f} ({}) {}", r.count[k], p_text(r.pooled_p_value[k]),
                                        r.sign[k] > 0 ? '+' : '-'));
      if (last) text += screening.selected[i] ? "  yes" : "  no";
      text += "\n";
    }
    text += fmt::format("  {:<{}}", "share of noise", width);
    for (const auto& r : block) text += fmt::format("  {:>19}", noise_text(r.variance));
    text += "\n";
  }
  return text;
}

std::string history_text(const Study& study, const Calibration& result) {
  std::string text = "\nSurrogates: R2 of left-out points\n";
  const auto& targets = study.targets;
  for (std::size_t from = 0; from < targets.size(); from += kBlock) {
    const auto to = std::min(from + kBlock, targets.size());
    const bool last = to == targets.size();
    text += fmt::format("\n  {:<8} {:>5}", "batch", "runs");
    for (std::size_t j = from; j < to; ++j) text += fmt::format("  {:>19}", targets[j].target.name);
    text += last ? "  expected error\n" : "\n";
    for (const auto& step : result.history) {
      text += fmt::format("  {:<8} {:>5}", step.batch == 0 ? "initial" : std::to_string(step.batch),
                          step.runs);
      for (std::size_t j = from; j < to; ++j) text += fmt::format("  {:>19.3f}", step.r2[j]);
      text += last ? fmt::format("  {:>12.2f} %\n", 100.0 * step.best_expected_error) : "\n";
    }
  }
  return text + fmt::format("\n  Stopped because {}.\n", result.stop_reason);
}

std::string result_text(const Study& study, const Calibration& result) {
  std::string text = history_text(study, result);

  const auto width = width_of(
      result.parameters, [](const auto& p) { return p.name; }, "parameter");
  text += fmt::format("\nCalibrated parameters\n\n  {:<{}}  {:>9}  {}\n", "parameter", width,
                      "value", "range the surrogates cannot tell apart");
  for (const auto& p : result.parameters)
    text += fmt::format("  {:<{}}  {:>9.4g}  {}\n", p.name, width, p.value,
                        p.selected ? fmt::format("{:.3g} ... {:.3g}{}", p.lowest, p.highest,
                                                 p.is_ridge() ? "  (a ridge)" : "")
                                   : "does not matter: middle of its range");

  const auto kpi_width = width_of(
      result.kpis, [](const auto& k) { return k.target.target.name; }, "KPI");
  text += fmt::format("\n  {:<{}}  {:>16}  {:>17}  {:>8}  {:>17}  {:>8}\n", "KPI", kpi_width,
                      "target", "predicted", "error", "verified", "error");
  for (const auto& k : result.kpis) {
    const auto& t = k.target;
    text += fmt::format(
        "  {:<{}}  {:>16}  {:>17}  {:>8}  {:>17}  {:>8}\n", t.target.name, kpi_width,
        t.ci95 > 0.0 ? fmt::format("{} ± {}", shortest(t.target.value), shortest(t.ci95))
                     : shortest(t.target.value),
        fmt::format("{:.4g} ± {:.2g}", k.predicted.mean, k.predicted.standard_deviation()),
        percent(k.predicted_relative_error()),
        k.verified.count > 0 ? fmt::format("{:.4g} ± {:.2g}", k.verified.mean, k.verified.deviation)
                             : "-",
        percent(k.verified_relative_error()));
  }
  const int n = result.kpis.front().verified.count;
  text += fmt::format(
      "  predicted ± standard deviation of the mean; verified ± that of one run ({} fresh runs)\n",
      n);
  text += fmt::format("\n  weighted error: expected {}, verified {}; best screening point {}\n",
                      share(result.predicted_error), share(result.verified_error),
                      share(result.baseline_error));
  if (!result.remarks.empty()) {
    text += "\nNote\n";
    for (const auto& remark : result.remarks) text += fmt::format("  - {}\n", remark);
  }
  const auto failed = result.data.failed();
  text += fmt::format("\n{} runs, {} failed{}\n", result.data.observations.size(), failed,
                      failed > 0 ? " (each with its reason in runs.h5)" : "");
  return text;
}

}  // namespace repose::dem_adapter

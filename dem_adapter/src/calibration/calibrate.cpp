#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "phases.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/text.hpp"
#include "repose/dem_adapter/calibration.hpp"
#include "repose/doe/space_filling.hpp"
#include "repose/table/io.hpp"

namespace repose::dem_adapter {
namespace {

constexpr std::uint64_t kSamplingStream = 300;

ProgressCallback progress_of(const CalibrationObserver& observer, const std::string& label) {
  return observer.progress ? observer.progress(label) : ProgressCallback{};
}

void say(const CalibrationObserver& observer, const std::string& sentence) {
  if (observer.say) observer.say(sentence);
}

Matrix initial_sample(const Study& study, std::size_t dimension) {
  const auto d = static_cast<int>(dimension);
  return doe::latin_hypercube(d * study.sampling.points_per_parameter, d,
                              {.seed = derive_seed(study.seed, kSamplingStream)});
}

bool good_enough(const Study& study, const SurrogateSet& surrogates) {
  return std::all_of(surrogates.r2.begin(), surrogates.r2.end(),
                     [&](double r2) { return r2 >= study.adaptive.r2; });
}

AdaptiveStep step_of(const Study& study, const SurrogateSet& surrogates, const Dataset& data,
                     int batch) {
  const auto visited = visited_points(study, data, surrogates.parameters);
  return {.batch = batch,
          .runs = surrogates.runs(),
          .r2 = surrogates.r2,
          .best_expected_error = best_expected_error(study, surrogates, visited.usable)};
}

/// The table of all runs so far, so that whoever looks after a failure finds it.
void write_runs(const std::filesystem::path& directory, const Study& study, const Dataset& data) {
  auto runs = data.table(study);
  table::stamp_provenance(runs, "", study.seed, {});
  table::write_table({directory / "runs.h5", ""}, runs);
}

/// Samples, fits, and adds batches until the surrogates are good enough or the budget is spent.
void learn(const Study& study, const Campaign& campaign, const CalibrationObserver& observer,
           const std::vector<std::string>& parameters, Calibration& result) {
  auto& data = result.data;
  const Matrix sample = initial_sample(study, parameters.size());
  simulate(data, study, campaign, Phase::sampling, 0, embed(study, parameters, sample),
           study.sampling.repetitions, progress_of(observer, "sampling"));
  write_runs(campaign.directory(), study, data);
  result.surrogates = fit_surrogates(study, data, parameters);
  result.history.push_back(step_of(study, result.surrogates, data, 0));
  int batch = 0;
  while (!good_enough(study, result.surrogates) && batch < study.adaptive.max_batches) {
    ++batch;
    const auto visited = visited_points(study, data, parameters);
    const Matrix next = propose(study, result.surrogates, visited, batch);
    simulate(data, study, campaign, Phase::adaptive, batch, embed(study, parameters, next),
             study.sampling.repetitions,
             progress_of(observer, fmt::format("adaptive batch {} of {}", batch,
                                               study.adaptive.max_batches)));
    result.surrogates = fit_surrogates(study, data, parameters);
    result.history.push_back(step_of(study, result.surrogates, data, batch));
  }
  result.stop_reason =
      good_enough(study, result.surrogates)
          ? fmt::format("every surrogate reached R2 = {}", shortest(study.adaptive.r2))
          : fmt::format("the budget of {} batches was spent", study.adaptive.max_batches);
}

/// Range of each KPI over everything simulated so far.
void note_coverage(const Study& study, Calibration& result) {
  for (const auto& target : study.targets) {
    CalibratedKpi kpi;
    kpi.target = target;
    kpi.lowest_seen = std::numeric_limits<double>::infinity();
    kpi.highest_seen = -kpi.lowest_seen;
    for (const auto& o : result.data.observations) {
      const auto value = o.kpi(target.target.name);
      if (!value || o.outcome.failed()) continue;  // a penalty is nothing seen
      kpi.lowest_seen = std::min(kpi.lowest_seen, *value);
      kpi.highest_seen = std::max(kpi.highest_seen, *value);
    }
    if (!kpi.reached())
      result.remarks.push_back(fmt::format(
          "No run reached the target {} = {}: all lie in [{:.4g}, {:.4g}]. Move the ranges of the "
          "parameters that act on it.",
          target.target.name, shortest(target.target.value), kpi.lowest_seen, kpi.highest_seen));
    result.kpis.push_back(kpi);
  }
}

void verify(const Study& study, const Campaign& campaign, const CalibrationObserver& observer,
            const Vector& optimum_full, Calibration& result) {
  const auto targets = study.plain_targets();
  const int repetitions = study.verification.repetitions;
  simulate(result.data, study, campaign, Phase::verification, 0, optimum_full.transpose(),
           repetitions, progress_of(observer, "verification"));
  simulate(result.data, study, campaign, Phase::baseline, 0, result.baseline_unit.transpose(),
           repetitions, progress_of(observer, "best screening point, same seeds"));
  std::vector<double> verified, baseline;
  for (auto& kpi : result.kpis) {
    kpi.verified = kpi_over(result.data, Phase::verification, kpi.target.target.name);
    kpi.baseline = kpi_over(result.data, Phase::baseline, kpi.target.target.name);
    verified.push_back(kpi.verified.mean);
    baseline.push_back(kpi.baseline.mean);
  }
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const auto error_of = [&](const std::vector<double>& means) {
    const bool all =
        std::all_of(means.begin(), means.end(), [](double m) { return !std::isnan(m); });
    return all ? opt::weighted_error(std::span<const double>(means), targets) : kUnknown;
  };
  result.verified_error = error_of(verified);
  result.baseline_error = error_of(baseline);
  const auto note_failures = [&](MeanAndDeviation CalibratedKpi::*phase, const char* what) {
    int usable = repetitions;
    for (const auto& kpi : result.kpis) usable = std::min(usable, (kpi.*phase).count);
    if (usable < repetitions)
      result.remarks.push_back(fmt::format("{} of {} runs at the {} failed: {}.",
                                           repetitions - usable, repetitions, what,
                                           failure_summary(result.data)));
  };
  note_failures(&CalibratedKpi::verified, "calibrated point");
  note_failures(&CalibratedKpi::baseline, "best screening point");
}

}  // namespace

double CalibratedKpi::predicted_relative_error() const {
  return (predicted.mean - target.target.value) / target.target.scale;
}

double CalibratedKpi::verified_relative_error() const {
  return (verified.mean - target.target.value) / target.target.scale;
}

MeanAndDeviation kpi_over(const Dataset& data, Phase phase, const std::string& kpi) {
  std::vector<double> values;
  for (const auto& o : data.observations)
    if (const auto value = o.kpi(kpi);
        value && data.points[o.point].phase == phase && !o.outcome.failed())
      values.push_back(*value);
  MeanAndDeviation result;
  result.count = static_cast<int>(values.size());
  if (values.empty()) {
    result.mean = std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  for (const double v : values) result.mean += v;
  result.mean /= result.count;
  for (const double v : values) result.deviation += (v - result.mean) * (v - result.mean);
  result.deviation = result.count > 1 ? std::sqrt(result.deviation / (result.count - 1)) : 0.0;
  return result;
}

Calibration calibrate(const Study& study, const Campaign& campaign,
                      const CalibrationObserver& observer) {
  Calibration result;

  // Which parameters matter.
  result.screening_design = screening_design(study);
  const Matrix corners = 0.5 * (result.screening_design.array() + 1.0).matrix();
  simulate(result.data, study, campaign, Phase::screening, 0, corners, study.screening.repetitions,
           progress_of(observer, "screening"));
  write_runs(campaign.directory(), study, result.data);
  result.screening = analyse_screening(study, result.screening_design, result.data, result.remarks);
  result.baseline_unit = best_screening_point(study, result.data);
  const auto parameters = choose_parameters(result.screening, result.remarks);
  say(observer, screening_text(result.screening));
  say(observer, fmt::format("To be calibrated: {}.\n", listed(parameters)));

  // What the KPIs are as functions of them.
  learn(study, campaign, observer, parameters, result);
  note_coverage(study, result);

  // Where they meet the targets.
  const auto visited = visited_points(study, result.data, parameters);
  const auto optimum = optimise(study, result.surrogates, visited);
  result.predicted_error = optimum.expected_error;
  result.parameters = parameter_ranges(study, result.surrogates, visited, optimum);
  const Vector optimum_full = embed(study, parameters, optimum.unit.transpose()).row(0).transpose();
  result.values = study.space.complete(study.space.from_unit(optimum_full));
  for (std::size_t j = 0; j < result.kpis.size(); ++j)
    result.kpis[j].predicted = result.surrogates.models[j].predict(optimum.unit);
  for (const auto& p : result.parameters)
    if (p.is_ridge())
      result.remarks.push_back(fmt::format(
          "{} is weakly determined: every value in [{:.3g}, {:.3g}] does as well, with the others "
          "adjusted (a ridge).",
          p.name, p.lowest, p.highest));

  // Whether it is so.
  verify(study, campaign, observer, optimum_full, result);
  return result;
}

}  // namespace repose::dem_adapter

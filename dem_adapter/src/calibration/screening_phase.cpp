#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "phases.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/doe/designs.hpp"

namespace repose::dem_adapter {

Matrix screening_design(const Study& study) {
  return doe::definitive_screening_design(
             static_cast<int>(study.space.dimension()),
             {.fake_factors = study.screening.fake_factors, .seed = study.seed})
      .coded;
}

std::string failure_summary(const Dataset& data) {
  std::map<std::string, int> counts;
  for (const auto& o : data.observations)
    if (o.outcome.measurement.outcome != Outcome::finished) ++counts[o.outcome.measurement.failure];
  const auto commonest =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (commonest == counts.end()) return "no run failed";
  int all = 0;
  for (const auto& [failure, count] : counts) all += count;
  return fmt::format("{} failed, e.g. \"{}\" (all reasons are in runs.h5)", all, commonest->first);
}

doe::Screening analyse_screening(const Study& study, const Matrix& coded, const Dataset& data,
                                 std::vector<std::string>& remarks) {
  const int repetitions = study.screening.repetitions;
  std::vector<std::string> names;
  std::vector<Matrix> responses;
  for (const auto& target : study.targets) {
    names.push_back(target.target.name);
    responses.push_back(
        Matrix::Constant(coded.rows(), repetitions, std::numeric_limits<double>::quiet_NaN()));
  }
  for (const auto& o : data.observations)
    if (data.points[o.point].phase == Phase::screening)
      for (std::size_t j = 0; j < names.size(); ++j)
        if (const auto value = o.kpi(names[j]))
          responses[j](static_cast<Eigen::Index>(o.point), o.repetition) = *value;
  const auto analyse = [&](const std::vector<int>& columns) {
    std::vector<Matrix> chosen;
    for (const auto& values : responses) chosen.push_back(values(Eigen::all, columns));
    return doe::screen(coded, study.space.names(), names, chosen, study.screening.analysis);
  };

  std::vector<int> kept;
  std::string refusal;
  for (int r = 0; r < repetitions; ++r) {
    try {
      static_cast<void>(analyse({r}));
      kept.push_back(r);
    } catch (const InputError& error) {  // too many of its runs failed
      refusal = error.what();
    }
  }
  if (kept.empty())
    throw SimulationError(
        fmt::format("too many runs of the screening failed to analyse any repetition ({}); {}; "
                    "choose ranges in which the "
                    "material flows",
                    refusal, failure_summary(data)));
  if (static_cast<int>(kept.size()) < repetitions)
    remarks.push_back(fmt::format(
        "{} of {} repetitions of the screening were left out, because too many of their runs "
        "failed.",
        repetitions - static_cast<int>(kept.size()), repetitions));
  return analyse(kept);
}

std::vector<std::string> choose_parameters(const doe::Screening& screening,
                                           std::vector<std::string>& remarks) {
  std::vector<std::string> chosen;
  for (std::size_t i = 0; i < screening.factors.size(); ++i)
    if (screening.selected[i]) chosen.push_back(screening.factors[i]);
  if (!chosen.empty()) return chosen;

  std::vector<double> smallest(screening.factors.size(), 2.0);
  for (const auto& response : screening.responses)
    for (std::size_t i = 0; i < smallest.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double p =
          std::isnan(response.pooled_p_value[k]) ? response.p_value[k] : response.pooled_p_value[k];
      if (p < smallest[i]) smallest[i] = p;
    }
  std::vector<std::size_t> order(smallest.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return smallest[a] < smallest[b]; });
  order.resize(std::min<std::size_t>(2, order.size()));
  std::sort(order.begin(), order.end());
  for (const auto i : order) chosen.push_back(screening.factors[i]);
  remarks.push_back(
      fmt::format("No parameter was significant often enough; the two with the smallest p-values, "
                  "{}, were calibrated. "
                  "Widen the ranges or raise screening.repetitions before trusting the result.",
                  listed(chosen)));
  return chosen;
}

Vector best_screening_point(const Study& study, const Dataset& data) {
  const auto targets = study.plain_targets();
  double best = std::numeric_limits<double>::infinity();
  const Point* best_point = nullptr;
  for (std::size_t p = 0; p < data.points.size(); ++p) {
    if (data.points[p].phase != Phase::screening) continue;
    std::vector<double> means(targets.size(), 0.0);
    for (std::size_t j = 0; j < targets.size(); ++j) {
      int runs = 0;
      for (const auto& o : data.observations)
        if (const auto value = o.kpi(targets[j].name);
            value && o.point == p && !o.outcome.failed()) {
          means[j] += *value;
          ++runs;
        }
      means[j] /= runs;  // NaN without runs, and so is the error, which is never the best
    }
    const double error = opt::weighted_error(std::span<const double>(means), targets);
    if (error < best) {
      best = error;
      best_point = &data.points[p];
    }
  }
  if (best_point == nullptr)
    throw SimulationError(fmt::format(
        "no point of the screening has a value of every KPI; {}; leave out the KPI that "
        "is undefined, or choose other ranges",
        failure_summary(data)));
  return best_point->unit;
}

}  // namespace repose::dem_adapter

#include "repose/dem_adapter/flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kDeviations = 4.0;  // at which the Gaussian is cut off
constexpr double kNothing = 1e-9;    // of the first mass: rounding of the filter

void check(const MassCurve& curve, const FlowOptions& options) {
  if (curve.time_s.size() != curve.mass_kg.size())
    throw InputError(fmt::format("the mass curve has {} times and {} masses", curve.time_s.size(),
                                 curve.mass_kg.size()));
  for (std::size_t i = 1; i < curve.time_s.size(); ++i)
    if (!(curve.time_s[i] > curve.time_s[i - 1]))
      throw InputError(fmt::format("time {} s of the mass curve does not follow {} s",
                                   curve.time_s[i], curve.time_s[i - 1]));
  if (!(options.filter_s >= 0.0 && std::isfinite(options.filter_s)))
    throw InputError(
        fmt::format("the filter's deviation is {} s; it must be 0 or more", options.filter_s));
  if (const auto* time = std::get_if<TimeWindow>(&options.window);
      time != nullptr && !(time->from_s < time->to_s))
    throw InputError(fmt::format("the window from {} to {} s is empty", time->from_s, time->to_s));
  if (const auto* steady = std::get_if<SteadyWindow>(&options.window);
      steady != nullptr && !(steady->tolerance > 0.0 && steady->tolerance < 1.0))
    throw InputError(fmt::format("the tolerance of a steady rate is {}; it must be between 0 and 1",
                                 steady->tolerance));
  if (const auto* share = std::get_if<ShareWindow>(&options.window);
      share != nullptr && !(share->from < share->to))
    throw InputError(fmt::format("the shares {} to {} are no window", share->from, share->to));
}

/// Slope of least squares of what has flowed out through the points used; NaN for fewer than two.
double outflow_rate(const MassCurve& curve, const std::vector<bool>& is_used) {
  const auto out = [&](std::size_t i) { return curve.mass_kg.front() - curve.mass_kg[i]; };
  double n = 0.0, mean_t = 0.0, mean_m = 0.0, stt = 0.0, stm = 0.0;
  for (std::size_t i = 0; i < is_used.size(); ++i) {
    if (!is_used[i]) continue;
    n += 1.0;
    mean_t += curve.time_s[i];
    mean_m += out(i);
  }
  if (n < 2.0) return kNaN;
  mean_t /= n;
  mean_m /= n;
  for (std::size_t i = 0; i < is_used.size(); ++i) {
    if (!is_used[i]) continue;
    stt += (curve.time_s[i] - mean_t) * (curve.time_s[i] - mean_t);
    stm += (curve.time_s[i] - mean_t) * (out(i) - mean_m);
  }
  return stm / stt;
}

/// The rate at which half of the mass flows faster.
double median_rate(const MassCurve& curve, const std::vector<double>& rate) {
  std::vector<std::pair<double, double>> parts;  // rate, mass
  double total = 0.0;
  for (std::size_t i = 0; i + 1 < rate.size(); ++i) {
    const double mean = 0.5 * (rate[i] + rate[i + 1]);
    const double mass = mean * (curve.time_s[i + 1] - curve.time_s[i]);
    if (mass <= 0.0) continue;
    parts.emplace_back(mean, mass);
    total += mass;
  }
  std::sort(parts.begin(), parts.end());
  double below = 0.0;
  for (const auto& [r, mass] : parts)
    if ((below += mass) >= 0.5 * total) return r;
  return 0.0;
}

/// Rows first and last of the window; first > last if it is empty.
std::pair<std::size_t, std::size_t> found_window(const MassCurve& curve,
                                                 const std::vector<double>& rate,
                                                 double tolerance) {
  const double least = (1.0 - tolerance) * median_rate(curve, rate);
  std::size_t first = 1, last = 0;
  bool is_open = false;
  for (std::size_t i = 0; i < rate.size(); ++i) {
    if (!(rate[i] >= least && rate[i] > 0.0)) continue;
    if (!is_open) first = i;
    is_open = true;
    last = i;
  }
  return {first, last};
}

}  // namespace

FilteredCurve gaussian_filtered(const MassCurve& curve, double deviation_s) {
  const std::size_t n = curve.time_s.size();
  FilteredCurve filtered{.mass_kg = curve.mass_kg, .rate_kg_s = std::vector<double>(n, 0.0)};
  std::size_t first = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = curve.time_s[i];
    while (curve.time_s[first] < t - kDeviations * deviation_s) ++first;
    double w0 = 0.0, w1 = 0.0, w2 = 0.0, m0 = 0.0, m1 = 0.0;  // moments about t
    for (std::size_t j = first; j < n && curve.time_s[j] <= t + kDeviations * deviation_s; ++j) {
      const double d = curve.time_s[j] - t;
      const double weight =
          deviation_s > 0.0 ? std::exp(-0.5 * d * d / (deviation_s * deviation_s)) : 1.0;
      w0 += weight;
      w1 += weight * d;
      w2 += weight * d * d;
      m0 += weight * curve.mass_kg[j];
      m1 += weight * d * curve.mass_kg[j];
    }
    const double determinant = w0 * w2 - w1 * w1;
    if (!(determinant > 1e-12 * w0 * w2)) continue;  // one point has all the weight
    filtered.mass_kg[i] = (w2 * m0 - w1 * m1) / determinant;
    filtered.rate_kg_s[i] = -(w0 * m1 - w1 * m0) / determinant;
  }
  return filtered;
}

Flow discharge_flow(const MassCurve& curve, const FlowOptions& options) {
  check(curve, options);
  Flow flow{.rate_kg_s = kNaN,
            .from_s = kNaN,
            .to_s = kNaN,
            .discharged_kg = kNaN,
            .time_98_s = kNaN,
            .unsteadiness = kNaN};
  const std::size_t n = curve.time_s.size();
  if (n < 3) return flow;
  const FilteredCurve filtered = gaussian_filtered(curve, options.filter_s);
  flow.discharged_kg = filtered.mass_kg.front() - filtered.mass_kg.back();
  if (!(flow.discharged_kg > kNothing * std::abs(filtered.mass_kg.front()))) {
    flow.discharged_kg = 0.0;
    return flow;
  }
  std::vector<double> out(n);  // discharged until then
  for (std::size_t i = 0; i < n; ++i) out[i] = filtered.mass_kg.front() - filtered.mass_kg[i];
  for (std::size_t i = 0; i < n && std::isnan(flow.time_98_s); ++i)
    if (out[i] >= 0.98 * flow.discharged_kg) flow.time_98_s = curve.time_s[i];

  std::vector<bool> is_used(n, false);
  if (const auto* share = std::get_if<ShareWindow>(&options.window)) {
    for (std::size_t i = 0; i < n; ++i)
      is_used[i] =
          out[i] >= share->from * flow.discharged_kg && out[i] <= share->to * flow.discharged_kg;
  } else if (const auto* time = std::get_if<TimeWindow>(&options.window)) {
    for (std::size_t i = 0; i < n; ++i)
      is_used[i] = curve.time_s[i] >= time->from_s && curve.time_s[i] <= time->to_s;
  } else {
    const auto [first, last] =
        found_window(curve, filtered.rate_kg_s, std::get<SteadyWindow>(options.window).tolerance);
    for (std::size_t i = first; i <= last; ++i) is_used[i] = true;
  }
  flow.rate_kg_s = outflow_rate(curve, is_used);
  double squares = 0.0, used = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (!is_used[i]) continue;
    if (std::isnan(flow.from_s)) flow.from_s = curve.time_s[i];
    flow.to_s = curve.time_s[i];
    squares += std::pow(filtered.rate_kg_s[i] / flow.rate_kg_s - 1.0, 2);
    used += 1.0;
  }
  if (options.filter_s > 0.0 && used > 0.0) flow.unsteadiness = std::sqrt(squares / used);
  return flow;
}

}  // namespace repose::dem_adapter

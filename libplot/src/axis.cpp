#include "axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::plot {
namespace {

/// Beyond this the difference of two values could overflow.
constexpr double kLargest = 1e300;
constexpr double kSmallest = 1e-300;
/// Ticks that miss a limit by rounding only count as on it.
constexpr double kTickSlack = 1e-9;

/// 1, 2 or 5 times a power of ten [Heckbert1990].
struct Step {
  double size;
  int power;  ///< floor(log10(size))
};

double power_of_ten(int power) {
  return std::pow(10.0, power);
}

Step round_step(double range, int count) {
  const double raw = range / std::max(count, 1);
  const int power = static_cast<int>(std::floor(std::log10(raw)));
  const double fraction = raw / power_of_ten(power);
  for (const double nice : {1.0, 2.0, 5.0})
    if (fraction <= nice * (1.0 + kTickSlack)) return {nice * power_of_ten(power), power};
  return {power_of_ten(power + 1), power + 1};
}

/// Data that are all equal, or that no double tells apart, lie in the middle of a wider range.
void widen_if_degenerate(double& lower, double& upper) {
  const double magnitude = std::max(std::abs(lower), std::abs(upper));
  if (upper - lower > std::max(1e-12 * magnitude, kSmallest)) return;
  const double middle = 0.5 * lower + 0.5 * upper;
  const double half = std::abs(middle) > kSmallest ? 0.1 * std::abs(middle) : 1.0;
  lower = middle - half;
  upper = middle + half;
}

void check(const Axis& axis) {
  const bool is_log = axis.scale == Scale::log;
  for (const auto& limit : {axis.lower, axis.upper})
    if (limit &&
        (!std::isfinite(*limit) || std::abs(*limit) > kLargest || (is_log && *limit < kSmallest)))
      throw InputError(fmt::format("a limit of the axis \"{}\" is {}; it must be finite{}",
                                   axis.label, shortest(*limit),
                                   is_log ? " and positive on a log scale" : ""));
  if (axis.lower && axis.upper && !(*axis.lower < *axis.upper))
    throw InputError(fmt::format("the axis \"{}\" goes from {} to {}; the first must be smaller",
                                 axis.label, shortest(*axis.lower), shortest(*axis.upper)));
}

/// A limit that the user gave on the wrong side of all data still leaves a range to show.
void honour_given_limits(const Axis& axis, AxisPlan& plan) {
  const bool is_log = axis.scale == Scale::log;
  const auto beyond = [&](double limit, double direction) {
    return is_log ? limit * std::pow(10.0, direction) : limit + direction * (std::abs(limit) + 1.0);
  };
  if (axis.lower) plan.lower = *axis.lower;
  if (axis.upper) plan.upper = *axis.upper;
  if (plan.lower < plan.upper) return;
  if (axis.upper)
    plan.lower = beyond(plan.upper, -1.0);
  else
    plan.upper = beyond(plan.lower, 1.0);
}

// ---- linear axes

void label_linear(AxisPlan& plan, const Step& step, const std::vector<double>& multiples) {
  double largest = 0.0;
  for (const double multiple : multiples)
    largest = std::max(largest, std::abs(multiple * step.size));
  if (largest >= 1e5 || (largest > 0.0 && largest < 1e-3))
    plan.exponent = 3 * static_cast<int>(std::floor(std::log10(largest) / 3.0 + kTickSlack));
  const int decimals = std::max(0, plan.exponent - step.power);
  for (const double multiple : multiples) {
    const double value = multiple * step.size;
    // In two factors, for 10^-308 has no inverse.
    const double scaled =
        value / power_of_ten(plan.exponent / 2) / power_of_ten(plan.exponent - plan.exponent / 2);
    plan.ticks.push_back(
        {value, fmt::format("{:.{}f}", multiple == 0.0 ? 0.0 : scaled, decimals), {}});
  }
}

AxisPlan plan_linear(const Axis& axis, Extent data, Limits limits, int count) {
  AxisPlan plan;
  plan.lower = data.is_empty() ? 0.0 : std::clamp(data.lower(), -kLargest, kLargest);
  plan.upper = data.is_empty() ? 1.0 : std::clamp(data.upper(), -kLargest, kLargest);
  widen_if_degenerate(plan.lower, plan.upper);
  honour_given_limits(axis, plan);
  const Step step = round_step(plan.upper - plan.lower, count);
  if (limits != Limits::exact) {
    if (!axis.lower) plan.lower = step.size * std::floor(plan.lower / step.size + kTickSlack);
    if (!axis.upper) plan.upper = step.size * std::ceil(plan.upper / step.size - kTickSlack);
  }
  std::vector<double> multiples;
  const double last = std::floor(plan.upper / step.size + kTickSlack);
  for (double k = std::ceil(plan.lower / step.size - kTickSlack); k <= last; k += 1.0)
    multiples.push_back(k);
  label_linear(plan, step, multiples);
  return plan;
}

// ---- log axes

/// Written out if all of the axis can be, else as powers.
Tick log_tick(double factor, int power, bool is_written_out) {
  const double value = factor * power_of_ten(power);
  if (is_written_out) return {value, fmt::format("{:.{}f}", value, std::max(0, -power)), {}};
  return {value, factor == 1.0 ? "10" : fmt::format("{:.0f}×10", factor), std::to_string(power)};
}

/// Round numbers of a log axis at or below (above) `value`, among `factors` times powers of ten.
double round_down(double value, const std::vector<double>& factors) {
  const int power = static_cast<int>(std::floor(std::log10(value) + kTickSlack));
  double best = power_of_ten(power);
  for (const double factor : factors)
    if (factor * power_of_ten(power) <= value * (1.0 + kTickSlack))
      best = factor * power_of_ten(power);
  return best;
}
double round_up(double value, const std::vector<double>& factors) {
  const int power = static_cast<int>(std::floor(std::log10(value) + kTickSlack));
  for (const double factor : factors)
    if (factor * power_of_ten(power) >= value * (1.0 - kTickSlack))
      return factor * power_of_ten(power);
  return power_of_ten(power + 1);
}

void add_log_ticks(AxisPlan& plan, const std::vector<double>& factors, int count) {
  const int first = static_cast<int>(std::floor(std::log10(plan.lower) - kTickSlack));
  const int last = static_cast<int>(std::ceil(std::log10(plan.upper) + kTickSlack));
  const bool is_written_out = plan.lower >= 0.999e-3 && plan.upper < 1.001e4;
  const int stride = std::max(1, (last - first) / std::max(count, 1));
  const auto is_shown = [&](double value) {
    return value >= plan.lower * (1.0 - kTickSlack) && value <= plan.upper * (1.0 + kTickSlack);
  };
  for (int power = first; power <= last; ++power) {
    for (const double factor : factors)
      if (power % stride == 0 && is_shown(factor * power_of_ten(power)))
        plan.ticks.push_back(log_tick(factor, power, is_written_out));
    if (last - first > 8) continue;
    for (int factor = 2; factor <= 9; ++factor)
      if (is_shown(factor * power_of_ten(power)))
        plan.minor_ticks.push_back(factor * power_of_ten(power));
  }
}

AxisPlan plan_log(const Axis& axis, Extent data, Limits limits, int count) {
  AxisPlan plan;
  plan.scale = Scale::log;
  plan.lower = data.is_empty() ? 1.0 : std::clamp(data.lower(), kSmallest, kLargest);
  plan.upper = data.is_empty() ? 10.0 : std::clamp(data.upper(), kSmallest, kLargest);
  if (plan.upper / plan.lower < 1.0 + 1e-9) {
    plan.lower /= 2.0;
    plan.upper *= 2.0;
  }
  honour_given_limits(axis, plan);
  const bool is_narrow = std::log10(plan.upper / plan.lower) < 1.7;
  const std::vector<double> factors = is_narrow ? std::vector{1.0, 2.0, 5.0} : std::vector{1.0};
  if (limits != Limits::exact) {
    if (!axis.lower) plan.lower = round_down(plan.lower, factors);
    if (!axis.upper) plan.upper = round_up(plan.upper, factors);
  }
  add_log_ticks(plan, factors, count);
  return plan;
}

}  // namespace

void Extent::include(double value) {
  if (!std::isfinite(value)) return;
  lower_ = is_empty() ? value : std::min(lower_, value);
  upper_ = upper_ < lower_ ? value : std::max(upper_, value);
}

AxisPlan plan_axis(const Axis& axis, Extent data, Limits limits, int count) {
  check(axis);
  return axis.scale == Scale::log ? plan_log(axis, data, limits, count)
                                  : plan_linear(axis, data, limits, count);
}

AxisPlan plan_categories(const std::vector<std::string>& categories) {
  AxisPlan plan;
  plan.upper = std::max(1.0, static_cast<double>(categories.size()));
  for (std::size_t i = 0; i < categories.size(); ++i)
    plan.ticks.push_back({static_cast<double>(i) + 0.5, categories[i], {}});
  return plan;
}

PixelMap::PixelMap(const AxisPlan& plan, double start, double end)
    : scale_(plan.scale), start_(start), end_(end) {
  lower_ = coordinate(plan.lower);
  upper_ = coordinate(plan.upper);
}

double PixelMap::coordinate(double value) const {
  return scale_ == Scale::log ? std::log10(value) : value;
}

double PixelMap::operator()(double value) const {
  return start_ + (end_ - start_) * ((coordinate(value) - lower_) / (upper_ - lower_));
}

bool PixelMap::shows(double value) const {
  if (!std::isfinite(value) || (scale_ == Scale::log && value <= 0.0)) return false;
  const double pixel = (*this)(value);
  return pixel >= std::min(start_, end_) - 0.5 && pixel <= std::max(start_, end_) + 0.5;
}

}  // namespace repose::plot

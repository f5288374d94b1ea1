// Axes: round ticks that enclose the data, labels that say their value, and pixels.
#include "axis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::plot {
namespace {

Extent extent(std::initializer_list<double> values) {
  Extent result;
  for (const double value : values) result.include(value);
  return result;
}

/// Labels are distinct and state the value of their tick to the last digit that they print.
void expect_labels_say_values(const AxisPlan& plan) {
  std::set<std::string> labels;
  for (const Tick& tick : plan.ticks) {
    EXPECT_TRUE(labels.insert(tick.text + "^" + tick.superscript).second) << tick.text;
    if (plan.scale == Scale::log) continue;
    const std::size_t point = tick.text.find('.');
    const int decimals =
        point == std::string::npos ? 0 : static_cast<int>(tick.text.size() - point - 1);
    const double scaled = tick.value / std::pow(10.0, plan.exponent);
    // Half a digit would be rounding; ticks are multiples of the last digit, so only errors of the
    // arithmetic remain.
    EXPECT_NEAR(std::stod(tick.text), scaled,
                1e-6 * std::pow(10.0, -decimals) + 1e-14 * std::abs(scaled));
  }
}

void expect_encloses(const AxisPlan& plan, double lower, double upper) {
  ASSERT_GE(plan.ticks.size(), 2u) << lower << " " << upper;
  const double slack = 1e-8 * (plan.upper - plan.lower);
  EXPECT_LE(plan.lower, lower + slack);
  EXPECT_GE(plan.upper, upper - slack);
  EXPECT_NEAR(plan.ticks.front().value, plan.lower, slack);
  EXPECT_NEAR(plan.ticks.back().value, plan.upper, slack);
  for (std::size_t i = 1; i < plan.ticks.size(); ++i)
    EXPECT_LT(plan.ticks[i - 1].value, plan.ticks[i].value);
  expect_labels_say_values(plan);
}

TEST(Axis, RoundTicksEncloseAnyData) {
  RandomStream random(1);
  for (int i = 0; i < 2000; ++i) {
    const double scale = std::pow(10.0, random.uniform(-12.0, 12.0));
    const double a = scale * random.normal();
    const double b = a + scale * std::pow(10.0, random.uniform(-4.0, 2.0));
    const int count = 2 + static_cast<int>(random.below(8));
    const AxisPlan plan = plan_axis({}, extent({a, b}), Limits::round, count);
    expect_encloses(plan, a, b);
    // A step of 1, 2 or 5 is at most 2.5 times finer than asked, and two ends are rounded out.
    EXPECT_LE(plan.ticks.size(), static_cast<std::size_t>(count) + 3);
  }
}

TEST(Axis, RoundTicksEncloseAnyPositiveDataOnALogScale) {
  RandomStream random(2);
  for (int i = 0; i < 2000; ++i) {
    const double a = std::pow(10.0, random.uniform(-12.0, 12.0));
    const double b = a * std::pow(10.0, random.uniform(0.01, 12.0));
    const AxisPlan plan = plan_axis({.scale = Scale::log}, extent({a, b}), Limits::round, 5);
    EXPECT_LE(plan.lower, a * (1.0 + 1e-8));
    EXPECT_GE(plan.upper, b * (1.0 - 1e-8));
    EXPECT_GE(plan.ticks.size(), 1u);
    EXPECT_LE(plan.ticks.size(), 12u);
    expect_labels_say_values(plan);
  }
}

TEST(Axis, KnownCasesHaveTheTicksAPersonWouldDraw) {
  const auto labels = [](const AxisPlan& plan) {
    std::string text;
    for (const Tick& tick : plan.ticks)
      text += tick.text + (tick.superscript.empty() ? "" : "^" + tick.superscript) + " ";
    return text;
  };
  EXPECT_EQ(labels(plan_axis({}, extent({0, 1}), Limits::round, 5)), "0.0 0.2 0.4 0.6 0.8 1.0 ");
  EXPECT_EQ(labels(plan_axis({}, extent({-0.3, 0.3}), Limits::round, 4)), "-0.4 -0.2 0.0 0.2 0.4 ");
  EXPECT_EQ(labels(plan_axis({}, extent({21.3, 38}), Limits::round, 4)), "20 25 30 35 40 ");
  const AxisPlan pascals = plan_axis({}, extent({0, 2.1e6}), Limits::round, 3);
  EXPECT_EQ(labels(pascals), "0 1 2 3 ");
  EXPECT_EQ(pascals.exponent, 6);
  const Axis log{.scale = Scale::log};
  EXPECT_EQ(labels(plan_axis(log, extent({0.02, 300}), Limits::round, 5)),
            "0.01 0.1 1 10 100 1000 ");
  EXPECT_EQ(labels(plan_axis(log, extent({2e5, 2e8}), Limits::round, 5)),
            "10^5 10^6 10^7 10^8 10^9 ");
  EXPECT_EQ(labels(plan_axis(log, extent({0.3, 4}), Limits::round, 5)), "0.2 0.5 1 2 5 ");
}

TEST(Axis, IsDefinedForDegenerateData) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  const std::initializer_list<std::initializer_list<double>> cases = {
      {28.0},           {0.0},           {-3e-7},    {1e15, 1e15 + 0.125},
      {5e-324},         {0, 5e-324},     {kLargest}, {-kLargest, kLargest},
      {1e-310, 2e-310}, {-kLargest, 0.0}};
  for (const auto& values : cases)
    for (const Limits limits : {Limits::round, Limits::exact}) {
      const AxisPlan plan = plan_axis({}, extent(values), limits, 5);
      EXPECT_TRUE(std::isfinite(plan.lower) && std::isfinite(plan.upper));
      EXPECT_LT(plan.lower, plan.upper);
      EXPECT_GE(plan.ticks.size(), 2u);
      EXPECT_LE(plan.ticks.size(), 12u);
    }
  const AxisPlan empty = plan_axis({}, {}, Limits::round, 5);
  EXPECT_EQ(empty.lower, 0.0);
  EXPECT_EQ(empty.upper, 1.0);
  const AxisPlan one = plan_axis({}, extent({28.0}), Limits::round, 5);
  EXPECT_TRUE(one.lower < 28.0 && 28.0 < one.upper);
  for (const auto& values : {extent({1e-5}), extent({kLargest}), extent({1e-320}), Extent{}}) {
    const AxisPlan plan = plan_axis({.scale = Scale::log}, values, Limits::round, 5);
    EXPECT_LT(plan.lower, plan.upper);
    EXPECT_GT(plan.lower, 0.0);
    EXPECT_GE(plan.ticks.size(), 1u);
  }
}

TEST(Axis, GivenLimitsAreKept) {
  const AxisPlan plan =
      plan_axis({.lower = 0.15, .upper = 0.93}, extent({-5, 5}), Limits::round, 5);
  EXPECT_EQ(plan.lower, 0.15);
  EXPECT_EQ(plan.upper, 0.93);
  EXPECT_DOUBLE_EQ(plan.ticks.front().value, 0.2);
  EXPECT_DOUBLE_EQ(plan.ticks.back().value, 0.8);
  // A limit beyond all data still leaves something to show.
  EXPECT_GT(plan_axis({.lower = 10.0}, extent({0, 1}), Limits::round, 5).upper, 10.0);
  EXPECT_LT(plan_axis({.upper = -10.0}, extent({0, 1}), Limits::round, 5).lower, -10.0);
  EXPECT_GT(plan_axis({.lower = 10.0, .scale = Scale::log}, extent({1}), Limits::round, 5).upper,
            10.0);
}

TEST(Axis, WrongLimitsAreRefused) {
  const auto plan = [](Axis axis) { plan_axis(axis, {}, Limits::round, 5); };
  EXPECT_THROW(plan({.lower = 1.0, .upper = 1.0}), InputError);
  EXPECT_THROW(plan({.lower = std::nan("")}), InputError);
  EXPECT_THROW(plan({.upper = std::numeric_limits<double>::infinity()}), InputError);
  EXPECT_THROW(plan({.lower = 0.0, .scale = Scale::log}), InputError);
}

TEST(PixelMap, IsLinearInTheValueOrItsLogarithm) {
  const PixelMap linear(plan_axis({.lower = 10.0, .upper = 20.0}, {}, Limits::exact, 5), 300, 100);
  EXPECT_DOUBLE_EQ(linear(10.0), 300.0);
  EXPECT_DOUBLE_EQ(linear(15.0), 200.0);
  EXPECT_TRUE(linear.shows(20.0));
  EXPECT_FALSE(linear.shows(20.1));
  EXPECT_FALSE(linear.shows(std::nan("")));
  const Axis log_axis{.lower = 0.01, .upper = 100.0, .scale = Scale::log};
  const PixelMap log(plan_axis(log_axis, {}, Limits::exact, 5), 0, 400);
  EXPECT_NEAR(log(1.0), 200.0, 1e-9);
  EXPECT_FALSE(log.shows(0.0));
  EXPECT_FALSE(log.shows(-1.0));
}

}  // namespace
}  // namespace repose::plot

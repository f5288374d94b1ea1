// Expected improvement against tables computed with 60 digits, and against its definition.
#include "repose/opt/acquisition.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace repose::opt {
namespace {

struct TableRow {
  double z;
  double log_h;
};

/// log(phi(z) + z Phi(z)), mpmath with at least 60 digits.
constexpr TableRow kTable[] = {
    {-1e7, -50000000000033.15513},      {-1e4, -50000019.339619307157},
    {-1000, -500014.73445209115845},    {-100, -5010.1295788002497923},
    {-38, -730.19618340211373916},      {-20, -206.91783850942509785},
    {-10, -55.553122036122355927},      {-5, -16.744301162660990143},
    {-3, -7.8696860596030285171},       {-2.5000001, -6.2125419552858463064},
    {-2.5, -6.2125416454435128635},     {-2.4999, -6.2122318073846666294},
    {-2, -4.7687835239171141569},       {-1, -2.4851210257126413368},
    {-0.5, -1.6205162643873199193},     {0, -0.91893853320467274178},
    {0.5, -0.35982768374506381859},     {0.9, 0.0004310441737820508654},
    {0.9024, 0.0023873066739667959927}, {1, 0.080026218849306940029},
    {2, 0.69738354578822831219},        {5, 1.6094379231264313851},
    {10, 2.302585092994045684},
};

TEST(LogImprovementIntegral, AgreesWithSixtyDigits) {
  for (const auto& [z, expected] : kTable)
    EXPECT_NEAR(log_improvement_integral(z), expected, std::max(1e-15, 1e-14 * std::abs(expected)))
        << "z = " << z;
}

TEST(ExpectedImprovement, AgreesWithSixtyDigits) {
  for (const auto& [z, log_h] : kTable) {
    if (z < -38) continue;
    const double expected = std::exp(log_h);  // itself good to |log h| eps
    EXPECT_NEAR(expected_improvement({.mean = -z, .variance = 1.0}, 0.0), expected,
                3e-13 * expected)
        << "z = " << z;
  }
}

struct Published {
  double best, mean, sigma, value;
};

TEST(ExpectedImprovement, AgreesWithReferenceValues) {
  constexpr Published kValues[] = {{1, 0.5, 0.3, 0.5059479655014173},
                                   {1, 1, 0.3, 0.1196826841204298},
                                   {1, 1.5, 0.3, 0.005947965501417251},
                                   {1, 3, 0.3, 5.648511899504679e-13},
                                   {0, 0, 1, 0.3989422804014327},
                                   {0, 5, 1, 5.346165533833156e-08},
                                   {0, 10, 1, 7.474560254595003e-25},
                                   {0, -2, 0.5, 2.000003572629216},
                                   {1, 2, 0, 0.0}};
  for (const Published& p : kValues) {
    const Gaussian prediction{p.mean, p.sigma * p.sigma};
    // the references were summed as phi + z Phi, which loses a factor z^2 <= 100 of eps each
    EXPECT_NEAR(expected_improvement(prediction, p.best), p.value, 1e-12 * p.value);
    if (p.value > 0.0) {
      EXPECT_NEAR(log_expected_improvement(prediction, p.best), std::log(p.value), 1e-12);
    }
  }
}

TEST(ExpectedImprovement, OfACertainPredictionIsItsGain) {
  EXPECT_EQ(expected_improvement({2.0, 0.0}, 5.0), 3.0);
  EXPECT_EQ(expected_improvement({5.0, 0.0}, 2.0), 0.0);
  EXPECT_EQ(log_expected_improvement({2.0, 0.0}, 5.0), std::log(3.0));
  EXPECT_EQ(log_expected_improvement({5.0, 0.0}, 2.0), -std::numeric_limits<double>::infinity());
}

TEST(LogExpectedImprovement, IsFiniteAndOrderedFarInTheTail) {
  double previous = log_expected_improvement({1e3, 1.0}, 0.0);
  for (double mean = 1e4; mean < 1e100; mean *= 10) {
    const double value = log_expected_improvement({mean, 1.0}, 0.0);
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_LT(value, previous);
    previous = value;
  }
}

TEST(LogExpectedImprovement, IsContinuousWhereItsFormChanges) {
  const double below = log_improvement_integral(std::nextafter(-2.5, -3.0));
  EXPECT_NEAR(below, log_improvement_integral(-2.5), 2e-14);
}

// d log EI/d mu = -Phi/(sigma h); in the tail h = phi/z^2 (1 - 3/z^2 + ...), so that it tends to
// z/sigma (1 + 2/z^2), and d/d sigma to (z^2 + 3 - ...)/sigma.
TEST(LogExpectedImprovementGradient, EqualsDifferencesAndIsExactFarInTheTail) {
  for (const double mean : {-3.0, -0.5, 0.0, 1.0, 2.4, 2.6, 6.0, 30.0})
    for (const double sigma : {0.2, 1.0, 4.0}) {
      const auto value = [](double m, double s) {
        return log_expected_improvement({m, s * s}, 0.0);
      };
      const auto g = log_expected_improvement_gradient({mean, sigma * sigma}, 0.0);
      EXPECT_EQ(g.value, value(mean, sigma));
      const double h = 1e-4 * sigma;  // fourth order: h^4 of truncation, 1e-16/h of rounding
      const auto slope = [h](const auto& f) {
        return (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
      };
      const double by_mean = slope([&](double step) { return value(mean + step, sigma); });
      const double by_sigma = slope([&](double step) { return value(mean, sigma + step); });
      const double size = 1e-9 * (1.0 + std::abs(g.value)) / sigma;
      EXPECT_NEAR(g.by_mean, by_mean, size);
      EXPECT_NEAR(g.by_standard_deviation, by_sigma, 10.0 * size);
    }
  for (const double z : {-1e4, -1e8, -1e100}) {
    const auto g = log_expected_improvement_gradient({-z, 1.0}, 0.0);
    EXPECT_NEAR(g.by_mean / (z * (1.0 + 2.0 / (z * z))), 1.0, 1e-14);
    EXPECT_NEAR(g.by_standard_deviation / (z * z), 1.0, 4.0 / (z * z) + 1e-14);
  }
  const auto certain = log_expected_improvement_gradient({2.0, 0.0}, 5.0);
  EXPECT_EQ(certain.by_mean, -1.0 / 3.0);
  EXPECT_EQ(certain.by_standard_deviation, 0.0);
  EXPECT_EQ(log_expected_improvement_gradient({5.0, 0.0}, 2.0).by_mean, 0.0);
}

TEST(LowerConfidenceBound, IsMeanLessKappaDeviations) {
  EXPECT_DOUBLE_EQ(lower_confidence_bound({3.0, 4.0}, 1.5), 0.0);
}

}  // namespace
}  // namespace repose::opt

// The weighted error of several quantities: closed forms against quadrature, draws against closed
// forms.
#include "repose/opt/composite.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/opt/acquisition.hpp"

namespace repose::opt {
namespace {

/// Integral of f(h) over h ~ N(mean, variance), split at `kink`: Simpson on 12 standard deviations,
/// 4000 intervals on each side of the kink, error below 1e-13 for smooth pieces.
template <class F>
double expectation(const Gaussian& g, double kink, const F& f) {
  const double sigma = g.standard_deviation();
  const auto piece = [&](double from, double to) {
    constexpr int kIntervals = 4000;
    const double step = (to - from) / kIntervals;
    double sum = 0.0;
    for (int i = 0; i <= kIntervals; ++i) {
      const double h = from + i * step;
      const double z = (h - g.mean) / sigma;
      const double weight = (i == 0 || i == kIntervals) ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
      sum += weight * f(h) * std::exp(-0.5 * z * z);
    }
    return sum * step / 3.0 / (sigma * std::sqrt(2.0 * std::numbers::pi));
  };
  const double low = g.mean - 12.0 * sigma;
  const double high = g.mean + 12.0 * sigma;
  const double middle = std::clamp(kink, low, high);
  return piece(low, middle) + piece(middle, high);
}

TEST(WeightedError, MeanAndVarianceEqualQuadrature) {
  const Target target{.name = "angle", .value = 30.0, .weight = 2.0};
  for (const double mean : {25.0, 29.5, 30.0, 31.0, 60.0})
    for (const double sigma : {0.1, 1.0, 5.0}) {
      const Gaussian kpi{mean, sigma * sigma};
      const auto g = [](double h) { return 2.0 * std::abs(h - 30.0) / 30.0; };
      const Gaussian error = weighted_error(std::span(&kpi, 1), std::span(&target, 1));
      const double expected = expectation(kpi, 30.0, g);
      const double square = expectation(kpi, 30.0, [&](double h) { return g(h) * g(h); });
      EXPECT_NEAR(error.mean, expected, 1e-11);
      EXPECT_NEAR(error.variance, square - expected * expected, 1e-11);
    }
}

TEST(WeightedError, OfSquaresEqualsQuadrature) {
  const Target target{.name = "angle", .value = 30.0, .weight = 2.0, .penalty = Penalty::squared};
  for (const double mean : {25.0, 30.0, 31.0})
    for (const double sigma : {0.1, 5.0}) {
      const Gaussian kpi{mean, sigma * sigma};
      const auto g = [](double h) { return 2.0 * (h - 30.0) * (h - 30.0) / 900.0; };
      const Gaussian error = weighted_error(std::span(&kpi, 1), std::span(&target, 1));
      const double expected = expectation(kpi, 30.0, g);
      const double square = expectation(kpi, 30.0, [&](double h) { return g(h) * g(h); });
      EXPECT_NEAR(error.mean, expected, 1e-11);
      EXPECT_NEAR(error.variance, square - expected * expected, 1e-11);
    }
}

// E max(0, m - u^2), u ~ N(0, 1): the integral over |u| < sqrt(m), m (2 Phi(sqrt m) - 1) less
// int u^2 phi = 2 Phi(sqrt m) - 1 - 2 sqrt(m) phi(sqrt m).
TEST(CompositeExpectedImprovement, OfOneSquareIsItsIntegral) {
  const Target target{.name = "a", .value = 1.0, .penalty = Penalty::squared};
  const Gaussian kpi{1.0, 1.0};
  const double m = 0.8;
  const double root = std::sqrt(m);
  const double inside = std::erf(root / std::numbers::sqrt2);
  const double density = std::exp(-0.5 * m) / std::sqrt(2.0 * std::numbers::pi);
  const double exact = m * inside - (inside - 2.0 * root * density);
  const Matrix normals = scrambled_normals(16384, 1, 3);
  EXPECT_NEAR(composite_expected_improvement(std::span(&kpi, 1), std::span(&target, 1), m, normals),
              exact, 1e-3 * exact);  // quasi-random: error about 1/n
}

TEST(WeightedError, AddsIndependentQuantitiesAndHonoursScales) {
  const std::vector<Target> targets{{.name = "a", .value = -4.0, .weight = 1.0},
                                    {.name = "b", .value = 0.0, .weight = 3.0, .scale = 0.5}};
  const std::vector<Gaussian> kpis{{-3.0, 0.2}, {0.1, 0.01}};
  const Gaussian both = weighted_error(kpis, targets);
  const Gaussian a = weighted_error(std::span(kpis).first(1), std::span(targets).first(1));
  const Gaussian b = weighted_error(std::span(kpis).last(1), std::span(targets).last(1));
  EXPECT_NEAR(both.mean, a.mean + b.mean, 1e-15);
  EXPECT_NEAR(both.variance, a.variance + b.variance, 1e-15);
  const std::array known{-3.0, 0.1};
  EXPECT_NEAR(weighted_error(known, targets), 1.0 / 4.0 + 3.0 * 0.1 / 0.5, 1e-15);
}

TEST(WeightedError, OfCertainQuantitiesIsThePlainSum) {
  const Target target{.name = "a", .value = 2.0, .weight = 1.0};
  const Gaussian kpi{2.5, 0.0};
  const Gaussian error = weighted_error(std::span(&kpi, 1), std::span(&target, 1));
  EXPECT_EQ(error.mean, 0.25);
  EXPECT_EQ(error.variance, 0.0);
}

TEST(WeightedError, OfAnUncertainTargetIsItsExpectation) {
  const Target target{.name = "a", .value = 2.0, .standard_deviation = 0.3};
  const std::array known{2.2};
  const double expected =
      expectation({2.0, 0.09}, 2.2, [](double t) { return std::abs(2.2 - t) / 2.0; });
  EXPECT_NEAR(weighted_error(known, std::span(&target, 1)), expected, 1e-12);
  const Gaussian kpi{2.2, 0.16};
  const Gaussian wider{2.2, 0.25};
  const Target exact{.name = "a", .value = 2.0};
  EXPECT_NEAR(weighted_error(std::span(&kpi, 1), std::span(&target, 1)).mean,
              weighted_error(std::span(&wider, 1), std::span(&exact, 1)).mean, 1e-15);
}

TEST(ScrambledNormals, HaveTheMomentsOfANormal) {
  constexpr Eigen::Index kDraws = 4096;
  const Matrix z = scrambled_normals(kDraws, 5, 3);
  EXPECT_TRUE(z.allFinite());
  const Matrix covariance = z.transpose() * z / double(kDraws);
  // a net of 2^12 points: errors fall as 1/n up to logarithms and tails, far below 1/sqrt(n) =
  // 0.016
  EXPECT_LT(z.colwise().mean().cwiseAbs().maxCoeff(), 0.003);
  EXPECT_LT((covariance - Matrix::Identity(5, 5)).cwiseAbs().maxCoeff(), 0.01);
  EXPECT_EQ(z, scrambled_normals(kDraws, 5, 3));
  EXPECT_NE(z, scrambled_normals(kDraws, 5, 4));
}

TEST(ScrambledUniforms, FillEveryHalvingOfEachAxisEqually) {
  const Matrix u = scrambled_uniforms(256, 7, 9);
  for (Eigen::Index k = 0; k < 7; ++k)
    for (int cell = 0; cell < 256; ++cell)
      EXPECT_EQ(((u.col(k).array() * 256.0).floor() == double(cell)).count(), 1)
          << k << ", " << cell;
}

TEST(CompositeExpectedImprovement, OfOneQuantityEqualsQuadrature) {
  const Target target{.name = "a", .value = 10.0, .weight = 1.0};
  const Matrix normals = scrambled_normals(1 << 14, 1, 5);
  for (const double mean : {9.0, 10.0, 12.0}) {
    const Gaussian kpi{mean, 1.0};
    const double best = 0.08;
    const auto gain = [&](double h) { return std::max(0.0, best - std::abs(h - 10.0) / 10.0); };
    // the gain has three kinks; the middle one is split, the others cost Simpson O(step^2) = 1e-6
    const double expected = expectation(kpi, 10.0, gain);
    const double drawn =
        composite_expected_improvement(std::span(&kpi, 1), std::span(&target, 1), best, normals);
    EXPECT_NEAR(drawn, expected, 1e-3 * expected + 2e-6);
    EXPECT_NEAR(log_composite_expected_improvement(std::span(&kpi, 1), std::span(&target, 1), best,
                                                   normals),
                std::log(drawn), 1e-3);
  }
}

TEST(CompositeExpectedImprovement, FarFromAKinkIsExpectedImprovementOfANormal) {
  // all h > t: the error is linear in h, hence normal
  const std::vector<Target> targets{{.name = "a", .value = 1.0, .weight = 0.5},
                                    {.name = "b", .value = 2.0, .weight = 1.5}};
  const std::vector<Gaussian> kpis{{2.0, 0.01}, {3.0, 0.02}};
  const Gaussian error = weighted_error(kpis, targets);
  const Matrix normals = scrambled_normals(1 << 14, 2, 6);
  const double best = error.mean - 0.5 * error.standard_deviation();
  const double expected = expected_improvement(error, best);
  EXPECT_NEAR(composite_expected_improvement(kpis, targets, best, normals), expected,
              2e-3 * expected);
}

TEST(LogCompositeExpectedImprovement, OrdersPointsWithoutAnyImprovingDraw) {
  const Target target{.name = "a", .value = 10.0};
  const Matrix normals = scrambled_normals(64, 1, 5);
  double previous = 0.0;
  for (double mean = 15.0; mean < 1e6; mean *= 2.0) {
    const Gaussian kpi{mean, 0.01};
    EXPECT_EQ(
        composite_expected_improvement(std::span(&kpi, 1), std::span(&target, 1), 0.1, normals), 0);
    const double value =
        log_composite_expected_improvement(std::span(&kpi, 1), std::span(&target, 1), 0.1, normals);
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_LT(value, previous);
    previous = value;
  }
}

TEST(CheckTargets, NamesWhatIsWrong) {
  const auto message = [](const Target& target) -> std::string {
    try {
      check_targets(std::span(&target, 1));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({.name = "flow", .value = 2.0}), "");
  EXPECT_NE(message({.name = "flow", .value = 0.0}).find("'flow'"), std::string::npos);
  EXPECT_EQ(message({.name = "flow", .value = 0.0, .scale = 1.0}), "");
  EXPECT_NE(message({.name = "flow", .value = 2.0, .weight = -1.0}).find("weight is -1"),
            std::string::npos);
  EXPECT_NE(message({.name = "flow", .value = std::nan("")}), "");
  EXPECT_NE(message({.name = "flow", .value = 2.0, .weight = 0.0}), "");
  EXPECT_THROW(check_targets({}), InputError);
  EXPECT_THROW(weighted_error(std::vector<Gaussian>(2), std::vector<Target>(1)), InputError);
}

TEST(LogCompositeExpectedImprovementGradient, EqualsDifferencesNearAndFarFromTheTargets) {
  const std::vector<Target> targets{
      {.name = "a", .value = 4.0},
      {.name = "b", .value = -2.0, .weight = 0.5},
      {.name = "c", .value = 1.0, .standard_deviation = 0.3},
      {.name = "d", .value = 2.0, .weight = 0.7, .penalty = Penalty::squared}};
  const Matrix normals = scrambled_normals(64, 4, 5);
  for (const double shift : {0.0, 0.3, 3.0}) {
    std::vector<Gaussian> kpis{{4.1 + shift, 0.04}, {-2.2, 0.09}, {1.1 + shift, 0.01}, {2.3, 0.05}};
    const double best = 0.2;
    const auto g = log_composite_expected_improvement_gradient(kpis, targets, best, normals);
    EXPECT_DOUBLE_EQ(g.value, log_composite_expected_improvement(kpis, targets, best, normals));
    // piecewise smooth with 64 kinks: steps short enough to cross none but by chance
    const double h = 1e-7;
    for (std::size_t j = 0; j < kpis.size(); ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      const auto at = [&](double mean_step, double sd_step) {
        auto moved = kpis;
        const double sd = kpis[j].standard_deviation() + sd_step;
        moved[j] = {kpis[j].mean + mean_step, sd * sd};
        return log_composite_expected_improvement(moved, targets, best, normals);
      };
      const double by_mean = (at(h, 0.0) - at(-h, 0.0)) / (2.0 * h);
      const double by_sd = (at(0.0, h) - at(0.0, -h)) / (2.0 * h);
      EXPECT_NEAR(g.by_mean[k], by_mean, 1e-6 * std::max(1.0, std::abs(by_mean)));
      EXPECT_NEAR(g.by_standard_deviation[k], by_sd, 1e-6 * std::max(1.0, std::abs(by_sd)));
    }
  }
}

}  // namespace
}  // namespace repose::opt

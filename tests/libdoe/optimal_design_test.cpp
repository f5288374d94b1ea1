// D-optimal designs against designs whose determinant is known.
#include "repose/doe/optimal_design.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/doe/factorial.hpp"

namespace repose::doe {
namespace {

TEST(DOptimalDesign, IsTheFactorialWhereThereIsOne) {
  for (int k = 1; k <= 5; ++k) {
    const auto linear = d_optimal_design(k, 1 << k, terms_of(ModelOrder::linear, k));
    EXPECT_NEAR(linear.d_efficiency, 1.0, 1e-12) << k;
    if (k < 2) continue;
    // Interactions as well: only all combinations have determinant 2^k to the power of columns.
    const auto design =
        d_optimal_design(k, 1 << k, terms_of(ModelOrder::interactions, k), {.starts = 40});
    EXPECT_NEAR(design.d_efficiency, 1.0, 1e-12) << k;
  }
}

TEST(DOptimalDesign, ReachesTheLargestDeterminantsOfSaturatedDesigns) {
  // Largest determinants of n x n matrices of +-1: 4, 16, 48, 160, 576, 4096 for n = 3 to 8
  // [Williamson1946]; a design of n runs for the linear model in n - 1 factors is such a matrix.
  const std::vector<double> published{4, 16, 48, 160, 576, 4096};
  for (int n = 3; n <= 8; ++n) {
    const auto design =
        d_optimal_design(n - 1, n, terms_of(ModelOrder::linear, n - 1), {.starts = 100});
    const double largest = published[static_cast<std::size_t>(n - 3)];
    EXPECT_NEAR(design.d_efficiency, std::pow(largest * largest, 1.0 / n) / n, 1e-12) << n;
  }
}

TEST(DOptimalDesign, SharesRunsEquallyBetweenThreeLevelsOfAQuadratic) {
  // One factor: |X'X| = 4 m^3 for m runs at each of -1, 0, 1.
  for (const int m : {1, 2, 5}) {
    const auto design = d_optimal_design(1, 3 * m, terms_of(ModelOrder::quadratic, 1));
    EXPECT_NEAR(design.d_efficiency, std::cbrt(4.0) / 3.0, 1e-12);
    EXPECT_EQ((design.coded.array() == 0.0).count(), m);
  }
}

/// |M(w)|^(1/p) of the best weights on the 3^k grid by the multiplicative algorithm
/// [Silvey1978], an upper bound for every exact design on it.
double continuous_optimum(int factors, const std::vector<Term>& terms) {
  const Matrix x =
      model_matrix(full_factorial(std::vector<int>(static_cast<std::size_t>(factors), 3)), terms);
  const auto p = static_cast<double>(x.cols());
  Vector w = Vector::Constant(x.rows(), 1.0 / static_cast<double>(x.rows()));
  for (int i = 0; i < 3000; ++i) {
    const Matrix inverse = (x.transpose() * w.asDiagonal() * x).inverse();
    w.array() *= (x * inverse).cwiseProduct(x).rowwise().sum().array() / p;
  }
  return std::pow((x.transpose() * w.asDiagonal() * x).determinant(), 1.0 / p);
}

TEST(DOptimalDesign, ComesCloseToTheContinuousOptimumAndNeverAboveIt) {
  for (int k = 2; k <= 3; ++k) {
    const auto terms = terms_of(ModelOrder::quadratic, k);
    const double bound = continuous_optimum(k, terms);
    for (const int runs : {12 * (k - 1), 36}) {
      const auto design = d_optimal_design(k, runs, terms, {.starts = 20});
      EXPECT_LE(design.d_efficiency, bound * (1.0 + 1e-9));
      EXPECT_GE(design.d_efficiency, 0.98 * bound) << k << " factors, " << runs << " runs";
      EXPECT_EQ(design.efficiencies.size(), 20u);
    }
  }
}

TEST(DOptimalDesign, CompletesAHalfFractionToTheFactorial) {
  OptimalDesignOptions options;
  options.existing = fractional_factorial(3, {"C=AB"}).coded;
  const auto terms = terms_of(ModelOrder::interactions, 3);
  EXPECT_EQ(d_efficiency(options.existing, terms), 0.0);
  const auto design = d_optimal_design(3, 4, terms, options);
  EXPECT_EQ(design.coded.topRows(4), options.existing);
  EXPECT_NEAR(design.d_efficiency, 1.0, 1e-12);
  for (Eigen::Index i = 4; i < 8; ++i) EXPECT_EQ(design.coded.row(i).prod(), -1.0);
}

TEST(DOptimalDesign, KeepsExistingRunsOfAnyLevelsAndImprovesOnThem) {
  OptimalDesignOptions options;
  options.existing = Matrix(3, 2);
  options.existing << 0.1, 0.2, -0.3, 0.7, 0.5, -0.6;
  const auto terms = terms_of(ModelOrder::linear, 2);
  const auto design = d_optimal_design(2, 1, terms, options);
  EXPECT_EQ(design.coded.topRows(3), options.existing);
  double best = 0.0;  // the four corners tried one by one
  for (const double a : {-1.0, 1.0})
    for (const double b : {-1.0, 1.0}) {
      Matrix tried(4, 2);
      tried << options.existing, a, b;
      best = std::max(best, d_efficiency(tried, terms));
    }
  EXPECT_DOUBLE_EQ(design.d_efficiency, best);
}

TEST(DOptimalDesign, ObeysConstraintsAndGivenLevels) {
  OptimalDesignOptions options;
  options.levels = {{-1, -0.5, 0, 0.5, 1}, {-1, -0.5, 0, 0.5, 1}, {-1, 1}};
  options.allowed = [](const Vector& x) { return x[0] + x[1] <= 0.5; };
  const auto terms = terms_of(ModelOrder::quadratic, 3, {2});
  EXPECT_EQ(terms.size(), 8u);
  const auto design = d_optimal_design(3, 20, terms, options);
  EXPECT_TRUE(((design.coded.col(0) + design.coded.col(1)).array() <= 0.5).all());
  EXPECT_TRUE((design.coded.col(2).array().abs() == 1.0).all());
  EXPECT_GT(design.d_efficiency, 0.0);
  // The forbidden corner is where the optimum without constraints has runs: it costs something.
  options.allowed = {};
  EXPECT_LT(design.d_efficiency, d_optimal_design(3, 20, terms, options).d_efficiency);
}

TEST(DOptimalDesign, ComesFromItsSeed) {
  const auto terms = terms_of(ModelOrder::quadratic, 4);
  const auto design = d_optimal_design(4, 18, terms, {.starts = 3, .seed = 5});
  EXPECT_EQ(design.coded, d_optimal_design(4, 18, terms, {.starts = 3, .seed = 5}).coded);
  EXPECT_NE(design.coded, d_optimal_design(4, 18, terms, {.starts = 3, .seed = 6}).coded);
  EXPECT_NEAR(design.d_efficiency, d_efficiency(design.coded, terms), 1e-15);
}

TEST(DOptimalDesign, RefusesWhatCannotBeDone) {
  const auto linear = terms_of(ModelOrder::linear, 3);
  EXPECT_THROW(d_optimal_design(3, 3, linear), InputError);
  EXPECT_THROW(d_optimal_design(2, 8, linear), InputError);
  EXPECT_THROW(d_optimal_design(3, 8, linear, {.starts = 0}), InputError);
  OptimalDesignOptions options;
  options.levels = {{-1, 1}, {-1, 1}};
  EXPECT_THROW(d_optimal_design(3, 8, linear, options), InputError);
  options.levels = {{-1, 1}, {1, -1}, {-1, 1}};
  EXPECT_THROW(d_optimal_design(3, 8, linear, options), InputError);
  options.levels = {};
  options.existing = Matrix::Zero(2, 2);
  EXPECT_THROW(d_optimal_design(3, 8, linear, options), InputError);
  options.existing = {};
  options.allowed = [](const Vector&) { return false; };
  EXPECT_THROW(d_optimal_design(3, 8, linear, options), InputError);
  options.allowed = [](const Vector& x) { return x[0] == 1.0; };  // no effect of the first factor
  EXPECT_THROW(d_optimal_design(3, 8, linear, options), InputError);
  options.allowed = {};
  options.levels = {{-1, 1}, {-1, 1}, {-1, 1}};  // two levels and a quadratic
  EXPECT_THROW(d_optimal_design(3, 20, terms_of(ModelOrder::quadratic, 3), options), InputError);
}

}  // namespace
}  // namespace repose::doe

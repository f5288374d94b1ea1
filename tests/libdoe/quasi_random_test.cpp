// Sobol' and Halton sequences: published points, and the nets that theory promises.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/doe/space_filling.hpp"

namespace repose::doe {
namespace {

using Eigen::Index;
using SobolScrambling = SobolOptions::Scrambling;
using HaltonScrambling = HaltonOptions::Scrambling;

TEST(SobolPoints, BeginAsPublished) {
  // The first ten points in three dimensions of Joe and Kuo's table new-joe-kuo-6.
  Matrix expected(10, 3);
  expected << 0, 0, 0, .5, .5, .5, .75, .25, .25, .25, .75, .75, .375, .375, .625, .875, .875, .125,
      .625, .125, .875, .125, .625, .375, .1875, .3125, .9375, .6875, .8125, .4375;
  EXPECT_EQ(sobol_points(10, 3, {.scrambling = SobolScrambling::none}), expected);
}

/// The largest number of points in one of the cells of 2^a x 2^b equal boxes.
int fullest_box(const Matrix& x, Index i, Index j, int a, int b) {
  std::map<std::pair<double, double>, int> counts;
  int most = 0;
  for (Index row = 0; row < x.rows(); ++row)
    most = std::max(
        most,
        ++counts[{std::floor(std::ldexp(x(row, i), a)), std::floor(std::ldexp(x(row, j), b))}]);
  return most;
}

TEST(SobolPoints, AreNetsOfTheQualityThatTheirPolynomialsGive) {
  // In dimensions i and j the first 2^m points are a (t, m, 2)-net, 2^t points in every box of
  // volume 2^(t-m), with t = e_i + e_j - 2 for primitive polynomials of degree e
  // [Niederreiter1988].
  const std::vector<int> degree{1, 1, 2, 3, 3, 4, 4, 5};
  for (const auto scrambling :
       {SobolScrambling::none, SobolScrambling::digital_shift, SobolScrambling::owen})
    for (const int m : {6, 9}) {
      const Matrix x = sobol_points(Index{1} << m, 8, {.scrambling = scrambling, .seed = 4});
      for (Index i = 0; i < 8; ++i) {
        EXPECT_EQ(fullest_box(x, i, i, m, 0), 1) << i;  // each column: one point a cell
        for (Index j = 0; j < i; ++j) {
          const int t =
              degree[static_cast<std::size_t>(i)] + degree[static_cast<std::size_t>(j)] - 2;
          for (int a = 0; a <= m - t; ++a)
            EXPECT_EQ(fullest_box(x, i, j, a, m - t - a), 1 << t) << i << ' ' << j << ' ' << a;
        }
      }
    }
}

TEST(SobolPoints, AreUniformAndUncorrelatedOverScramblings) {
  // Mean over n = 4000 seeds of u and of (u - 1/2)(v - 1/2) for one and the same point: five
  // standard errors, sqrt(1/12/n) and 1/12/sqrt(n), are exceeded once in two million tests.
  constexpr int kSeeds = 4000;
  for (const auto scrambling : {SobolScrambling::digital_shift, SobolScrambling::owen}) {
    double sum = 0.0, product = 0.0;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Matrix x = sobol_points(4, 2, {.scrambling = scrambling, .seed = seed});
      sum += x(3, 0);
      product += (x(3, 0) - 0.5) * (x(3, 1) - 0.5);
    }
    EXPECT_NEAR(sum / kSeeds, 0.5, 5.0 * std::sqrt(1.0 / 12.0 / kSeeds));
    EXPECT_NEAR(product / kSeeds, 0.0, 5.0 / 12.0 / std::sqrt(kSeeds));
  }
}

double error_of_mean(Index points, SobolScrambling scrambling) {
  // Integral of prod_j (1 + (u_j - 1/2)) = 1 in 3 dimensions, root of the mean square of 40 errors.
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Matrix x = sobol_points(points, 3, {.scrambling = scrambling, .seed = seed});
    const double error = (x.array() + 0.5).rowwise().prod().mean() - 1.0;
    sum += error * error;
  }
  return std::sqrt(sum / 40.0);
}

TEST(SobolPoints, IntegrateSmoothFunctionsAtTheRateOfNestedScrambling) {
  // [Owen1997]: error n^-3/2 up to logarithms, 64 for 16 times as many points; random points: 4.
  const double ratio =
      error_of_mean(256, SobolScrambling::owen) / error_of_mean(4096, SobolScrambling::owen);
  EXPECT_GT(ratio, 30.0);
  EXPECT_LT(ratio, 130.0);
}

TEST(HaltonPoints, BeginAsRadicalInverses) {
  Matrix expected(6, 3);
  expected << 1. / 2, 1. / 3, 1. / 5, 1. / 4, 2. / 3, 2. / 5, 3. / 4, 1. / 9, 3. / 5, 1. / 8,
      4. / 9, 4. / 5, 5. / 8, 7. / 9, 1. / 25, 3. / 8, 2. / 9, 6. / 25;
  EXPECT_TRUE(
      halton_points(6, 3, {.scrambling = HaltonScrambling::none}).isApprox(expected, 1e-15));
}

TEST(HaltonPoints, HaveOnePointInEveryElementaryBox) {
  for (const auto scrambling : {HaltonScrambling::none, HaltonScrambling::permuted}) {
    // 2^3 x 3^2 boxes, each visited once in any 72 points in sequence.
    const Matrix x = halton_points(144, 2, {.scrambling = scrambling, .seed = 9});
    for (const Index from : {0, 72}) {
      std::set<std::pair<double, double>> boxes;
      for (Index i = from; i < from + 72; ++i)
        boxes.insert({std::floor(x(i, 0) * 8.0 + 1e-12), std::floor(x(i, 1) * 9.0 + 1e-12)});
      EXPECT_EQ(boxes.size(), 72u);
    }
  }
}

TEST(HaltonPoints, LoseTheCorrelationOfLargeBasesByPermutations) {
  const auto correlation = [](HaltonScrambling scrambling) {
    Matrix x = halton_points(100, 20, {.scrambling = scrambling, .seed = 2}).rightCols(2);
    x.rowwise() -= x.colwise().mean();
    return x.col(0).normalized().dot(x.col(1).normalized());
  };
  EXPECT_GT(correlation(HaltonScrambling::none), 0.5);                // bases 67 and 71
  EXPECT_LT(std::abs(correlation(HaltonScrambling::permuted)), 0.3);  // three standard errors
}

TEST(QuasiRandomPoints, ComeFromTheirSeedAndLieInsideTheCube) {
  for (const std::uint64_t seed : {1ULL, 2ULL, ~0ULL}) {
    const Matrix s = sobol_points(1000, 6, {.seed = seed});
    EXPECT_EQ(s, sobol_points(1000, 6, {.seed = seed}));
    EXPECT_EQ(s.topRows(10), sobol_points(10, 6, {.seed = seed}));
    EXPECT_NE(s, sobol_points(1000, 6, {.seed = seed - 1}));
    EXPECT_TRUE((s.array() > 0.0).all() && (s.array() < 1.0).all());
    const Matrix h = halton_points(1000, 6, {.seed = seed});
    EXPECT_EQ(h.topRows(10), halton_points(10, 6, {.seed = seed}));
    EXPECT_NE(h, halton_points(1000, 6, {.seed = seed - 1}));
    EXPECT_TRUE((h.array() >= 0.0).all() && (h.array() < 1.0).all());
  }
}

TEST(QuasiRandomPoints, AreThoseOfTheSequenceThatAreAllowed) {
  const PointFilter below = [](const Vector& u) { return u.sum() <= 1.0; };
  const Matrix all = sobol_points(400, 2);
  const Matrix some = sobol_points(100, 2, {.allowed = below});
  Index from = 0;
  for (Index i = 0; i < some.rows(); ++i) {
    EXPECT_LE(some.row(i).sum(), 1.0);
    while (all.row(from) != some.row(i)) EXPECT_GT(all.row(from++).sum(), 1.0);
    ++from;
  }
  EXPECT_TRUE((halton_points(50, 2, {.allowed = below}).rowwise().sum().array() <= 1.0).all());
  const PointFilter none = [](const Vector&) { return false; };
  EXPECT_THROW(sobol_points(1, 2, {.allowed = none}), InputError);
  EXPECT_THROW(halton_points(1, 2, {.allowed = none}), InputError);
}

TEST(QuasiRandomPoints, RefuseSizesOutOfRange) {
  EXPECT_THROW(sobol_points(-1, 2), InputError);
  EXPECT_THROW(sobol_points(1, 0), InputError);
  EXPECT_THROW(sobol_points(1, 3668), InputError);
  EXPECT_THROW(halton_points(1, 1001), InputError);
  EXPECT_EQ(sobol_points(0, 2).rows(), 0);
  EXPECT_EQ(sobol_points(2, 3667).cols(), 3667);
}

}  // namespace
}  // namespace repose::doe

// Latin hypercubes: exact stratification, and criteria that never lose.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/doe/designs.hpp"

namespace repose::doe {
namespace {

using Criterion = LatinHypercubeOptions::Criterion;

double smallest_distance(const Matrix& x) {
  double least = 1e300;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (Eigen::Index j = 0; j < i; ++j) least = std::min(least, (x.row(i) - x.row(j)).norm());
  return least;
}

double sum_of_squared_correlations(const Matrix& x) {
  Matrix centred = x.rowwise() - x.colwise().mean();
  centred.colwise().normalize();
  const Matrix r = centred.transpose() * centred;
  return (r.squaredNorm() - r.diagonal().squaredNorm()) / 2.0;
}

TEST(LatinHypercube, HasExactlyOnePointInEveryCellOfEveryColumn) {
  for (const Criterion criterion : {Criterion::plain, Criterion::maximin, Criterion::correlation})
    for (const int points : {1, 2, 7, 49, 1000})
      for (const int dimensions : {1, 2, 7}) {
        const Matrix x = latin_hypercube(points, dimensions,
                                         {.criterion = criterion, .iterations = 200, .seed = 3});
        ASSERT_EQ(x.rows(), points);
        ASSERT_EQ(x.cols(), dimensions);
        EXPECT_TRUE((x.array() > 0.0).all() && (x.array() < 1.0).all());
        for (int j = 0; j < dimensions; ++j) {
          std::set<double> cells;
          for (int i = 0; i < points; ++i) cells.insert(std::floor(x(i, j) * points));
          EXPECT_EQ(cells.size(), static_cast<std::size_t>(points));
          EXPECT_EQ(*cells.rbegin(), points - 1.0);
        }
      }
}

TEST(LatinHypercube, MaximinIsNeverCloserThanThePlainOneOfTheSameSeed) {
  int better = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Matrix plain = latin_hypercube(20, 4, {.criterion = Criterion::plain, .seed = seed});
    const Matrix maximin = latin_hypercube(20, 4, {.iterations = 3000, .seed = seed});
    EXPECT_GE(smallest_distance(maximin), smallest_distance(plain));
    better += smallest_distance(maximin) > 1.3 * smallest_distance(plain) ? 1 : 0;
    EXPECT_EQ(latin_hypercube(20, 4, {.iterations = 0, .seed = seed}), plain);
  }
  EXPECT_EQ(better, 20);  // doing nothing would pass the line above
}

TEST(LatinHypercube, CorrelationCriterionNeverRaisesCorrelations) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Matrix plain = latin_hypercube(30, 5, {.criterion = Criterion::plain, .seed = seed});
    const Matrix improved = latin_hypercube(
        30, 5, {.criterion = Criterion::correlation, .iterations = 5000, .seed = seed});
    EXPECT_LT(sum_of_squared_correlations(improved), 0.01 * sum_of_squared_correlations(plain));
  }
}

TEST(LatinHypercube, HasTheSameBitsForTheSameSeed) {
  for (const Criterion criterion : {Criterion::plain, Criterion::maximin, Criterion::correlation}) {
    const LatinHypercubeOptions options{.criterion = criterion, .iterations = 500, .seed = 11};
    EXPECT_EQ(latin_hypercube(15, 3, options), latin_hypercube(15, 3, options));
    EXPECT_NE(latin_hypercube(15, 3, options),
              latin_hypercube(15, 3, {.criterion = criterion, .iterations = 500, .seed = 12}));
  }
}

TEST(LatinHypercube, RefusesEmptyAndTooLargeOnes) {
  EXPECT_THROW(latin_hypercube(0, 3), InputError);
  EXPECT_THROW(latin_hypercube(3, 0), InputError);
  EXPECT_THROW(latin_hypercube(1000000, 3), InputError);
  EXPECT_THROW(latin_hypercube(3, 3, {.iterations = -1}), InputError);
}

}  // namespace
}  // namespace repose::doe

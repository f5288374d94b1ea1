// Latin hypercubes: exact stratification, and criteria that never lose.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/doe/space_filling.hpp"

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

TEST(LatinHypercube, ObeysAFilterAndStaysSpread) {
  // Half of the square: the marginal densities are not uniform, so that no Latin hypercube exists.
  const PointFilter below = [](const Vector& u) { return u.sum() <= 1.0; };
  for (const Criterion criterion : {Criterion::plain, Criterion::maximin, Criterion::correlation}) {
    const LatinHypercubeOptions options{
        .criterion = criterion, .iterations = 2000, .allowed = below};
    const Matrix x = latin_hypercube(40, 2, options);
    ASSERT_EQ(x.rows(), 40);
    EXPECT_TRUE((x.rowwise().sum().array() <= 1.0).all());
    EXPECT_EQ(x, latin_hypercube(40, 2, options));
    // At least 40 cells in each column, none of them with two points.
    for (Eigen::Index j = 0; j < 2; ++j)
      EXPECT_EQ(std::set<double>(x.col(j).begin(), x.col(j).end()).size(), 40u);
  }
  // A filter that refuses nothing changes nothing.
  const PointFilter all = [](const Vector&) { return true; };
  EXPECT_EQ(latin_hypercube(40, 2, {.allowed = all}), latin_hypercube(40, 2));
  EXPECT_GT(smallest_distance(latin_hypercube(40, 2, {.allowed = below})),
            2.0 * smallest_distance(
                      latin_hypercube(40, 2, {.criterion = Criterion::plain, .allowed = below})));
  const PointFilter one_percent = [](const Vector& u) { return u[0] < 0.01; };
  EXPECT_EQ(latin_hypercube(30, 3, {.allowed = one_percent}).rows(), 30);
  EXPECT_THROW(latin_hypercube(30, 3, {.allowed = [](const Vector&) { return false; }}),
               InputError);
}

TEST(FillingPoints, TakeTheEmptyCellsOfALatinHypercube) {
  const Matrix existing = latin_hypercube(20, 3, {.iterations = 500});
  const Matrix added = filling_points(existing, 15);
  ASSERT_EQ(added.rows(), 15);
  for (Eigen::Index j = 0; j < 3; ++j) {
    std::multiset<double> cells;
    for (const double u : existing.col(j)) cells.insert(std::floor(u * 35));
    const std::set<double> taken(cells.begin(), cells.end());
    for (const double u : added.col(j)) {
      EXPECT_EQ(taken.count(std::floor(u * 35)), 0u);
      cells.insert(std::floor(u * 35));
    }
    for (const double u : added.col(j)) EXPECT_EQ(cells.count(std::floor(u * 35)), 1u);
  }
  EXPECT_EQ(added, filling_points(existing, 15));
  EXPECT_NE(added, filling_points(existing, 15, {.seed = 2}));
}

TEST(FillingPoints, KeepTheirDistanceFromPointsThatAreThere) {
  // All existing points in one quarter: random points would hit it.
  const Matrix existing = 0.5 * latin_hypercube(30, 2);
  const Matrix added = filling_points(existing, 20);
  Matrix all(50, 2);
  all << existing, added;
  double least = 1e300;
  for (Eigen::Index i = 30; i < 50; ++i)
    for (Eigen::Index j = 0; j < i; ++j) least = std::min(least, (all.row(i) - all.row(j)).norm());
  // Taking the farthest point each time gives at least half of the largest distance possible, and
  // that is no less than of a hexagonal lattice in three quarters of the square.
  EXPECT_GT(least, 0.5 * std::sqrt(2.0 * 0.75 / (std::sqrt(3.0) * 20)));
}

TEST(FillingPoints, ObeyAFilterAndRefuseWhatIsOutside) {
  const PointFilter corner = [](const Vector& u) { return u.sum() <= 0.3; };
  const Matrix added = filling_points(Matrix::Constant(4, 2, 0.9), 10, {.allowed = corner});
  EXPECT_TRUE((added.rowwise().sum().array() <= 0.3).all());
  EXPECT_EQ(filling_points(Matrix(0, 2), 5).rows(), 5);
  EXPECT_THROW(filling_points(Matrix::Constant(2, 2, 1.1), 5), InputError);
  EXPECT_THROW(filling_points(Matrix::Constant(2, 2, NAN), 5), InputError);
  EXPECT_THROW(filling_points(Matrix(2, 0), 5), InputError);
  EXPECT_THROW(filling_points(Matrix::Zero(2, 2), 0), InputError);
  EXPECT_THROW(
      filling_points(Matrix::Zero(2, 2), 1, {.allowed = [](const Vector&) { return false; }}),
      InputError);
}

}  // namespace
}  // namespace repose::doe

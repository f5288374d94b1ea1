// Effect sizes against closed forms and pure noise.
#include "repose/doe/effect_size.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "random_matrix.hpp"
#include "repose/base/error.hpp"

namespace repose::doe {
namespace {

Vector vector_of(std::initializer_list<double> values) {
  Vector v(static_cast<Eigen::Index>(values.size()));
  std::copy(values.begin(), values.end(), v.begin());
  return v;
}

TEST(CohensD, IsTheDifferenceOfMeansOverTheRootMeanVariance) {
  // Means 2 and 5, variances 1 and 4.
  EXPECT_NEAR(cohens_d(vector_of({1, 2, 3}), vector_of({3, 5, 7})), -3.0 / std::sqrt(2.5), 1e-15);
  EXPECT_TRUE(std::isinf(cohens_d(vector_of({1, 1}), vector_of({2, 2}))));
  EXPECT_TRUE(std::isnan(cohens_d(vector_of({1, 1}), vector_of({1, 1}))));
  // Three tenths are not exact in binary, nor is their mean.
  EXPECT_TRUE(std::isinf(cohens_d(Vector::Constant(3, 0.1), Vector::Constant(3, 0.2))));
  EXPECT_TRUE(std::isnan(correlation(Vector::Constant(3, 0.1), vector_of({1, 2, 3})).pearson));
  EXPECT_THROW(cohens_d(vector_of({1}), vector_of({1, 2})), InputError);
  EXPECT_THROW(cohens_d(vector_of({1, NAN}), vector_of({1, 2})), InputError);
}

TEST(CoefficientOfVariation, DividesByNMinusOneOrByN) {
  const auto cv = coefficient_of_variation(vector_of({-1, -2, -3, -4, -5}));
  EXPECT_NEAR(cv.sample, std::sqrt(2.5) / 3.0, 1e-15);
  EXPECT_NEAR(cv.population, std::sqrt(2.0) / 3.0, 1e-15);
  EXPECT_TRUE(std::isinf(coefficient_of_variation(vector_of({-1, 1})).sample));
}

TEST(Correlation, OfALineIsOneAndOfTheWorkedExampleEightTenths) {
  const Vector x = Vector::LinSpaced(5, 0.0, 4.0);
  EXPECT_NEAR(correlation(x, 3.0 - 2.0 * x.array()).pearson, -1.0, 1e-15);
  EXPECT_NEAR(correlation(x, 3.0 - 2.0 * x.array()).p, 0.0, 1e-12);
  // sum dx dy = 8, sum dx^2 = sum dy^2 = 10.
  const auto c = correlation(vector_of({1, 2, 3, 4, 5}), vector_of({2, 1, 3, 5, 4}));
  EXPECT_NEAR(c.pearson, 0.8, 1e-15);
  // P(|T| > t; 3) = 1 - 2/pi (atan(t/sqrt3) + sqrt3 t/(t^2 + 3)), t = 0.8 sqrt(3/0.36).
  const double t = 0.8 * std::sqrt(3.0 / 0.36), root = std::sqrt(3.0);
  EXPECT_NEAR(c.p, 1.0 - 2.0 / M_PI * (std::atan(t / root) + root * t / (t * t + 3.0)), 1e-14);
}

TEST(Correlation, OfRanksIsBlindToTheScale) {
  const Vector x = vector_of({1, 2, 3, 4, 5, 6}), y = vector_of({1, 8, 27, 64, 125, 216});
  EXPECT_NEAR(correlation(x, y).spearman, 1.0, 1e-15);
  EXPECT_LT(correlation(x, y).pearson, 0.95);
  // Ranks 1.5 1.5 3 and 1 2 3: sum of products of deviations 1.5, squares 1.5 and 2.
  EXPECT_NEAR(correlation(vector_of({4, 4, 9}), vector_of({1, 2, 3})).spearman,
              1.5 / std::sqrt(1.5 * 2.0), 1e-15);
  EXPECT_TRUE(std::isnan(correlation(vector_of({4, 4, 4}), vector_of({1, 2, 3})).pearson));
  EXPECT_THROW(correlation(vector_of({4, 4}), vector_of({1, 2, 3})), InputError);
}

// c4(2) = sqrt(2/pi), c4(3) = sqrt(pi)/2, c4(4) = 2 sqrt(2/(3 pi)).
TEST(CFour, HasItsClosedForms) {
  EXPECT_NEAR(c4(2), std::sqrt(2.0 / M_PI), 1e-15);
  EXPECT_NEAR(c4(3), 0.5 * std::sqrt(M_PI), 1e-15);
  EXPECT_NEAR(c4(4), 2.0 * std::sqrt(2.0 / (3.0 * M_PI)), 1e-15);
  EXPECT_NEAR(c4(1000), 1.0 - 0.25 / 999.5, 1e-7);
  EXPECT_THROW(c4(1), InputError);
}

TEST(SignalToRepetition, OfTheWorkedExampleIsTheRatioOfDeviations) {
  Matrix values(3, 3);
  values << 1, 2, 3, 2, 3, 7, 10, 11, 12;  // means 2, 4, 11; deviations 1, sqrt 7, 1
  const auto signal = signal_to_repetition(values);
  const double mean = 17.0 / 3.0;
  const double between =
      std::sqrt((std::pow(2 - mean, 2) + std::pow(4 - mean, 2) + std::pow(11 - mean, 2)) / 2.0);
  EXPECT_NEAR(signal.alpha, between / ((2.0 + std::sqrt(7.0)) / 3.0), 1e-14);
  EXPECT_NEAR(signal.floor, 0.651470, 1e-6);  // 1/(sqrt 3 * sqrt(pi)/2)
}

TEST(SignalToRepetition, OfPureNoiseIsItsFloorAndNotOne) {
  // Standard error of alpha over 20,000 runs: about floor / sqrt(2 * 20,000) = 0.003.
  for (const int repetitions : {3, 5}) {
    const auto signal = signal_to_repetition(test::random_matrix(20000, repetitions, 21));
    EXPECT_NEAR(signal.alpha, signal.floor, 0.015) << repetitions;
  }
}

TEST(SignalToRepetition, IsInfiniteIfRepetitionsAgreeExactly) {
  Matrix values(3, 3);
  values << 0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3, 0.3, 0.3;
  EXPECT_TRUE(std::isinf(signal_to_repetition(values).alpha));
}

TEST(SignalToRepetition, LeavesMissingValuesOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Matrix values(4, 3), kept(3, 2);
  values << 1, 2, nan, 5, nan, nan, nan, 4, 9, 3, nan, 8;
  kept << 1, 2, 4, 9, 3, 8;
  EXPECT_EQ(signal_to_repetition(values).alpha, signal_to_repetition(kept).alpha);
  values(0, 2) = 2.5;
  EXPECT_TRUE(std::isnan(signal_to_repetition(values).floor));  // unequal repetitions
  EXPECT_THROW(signal_to_repetition(values.topRows(2)), InputError);
}

}  // namespace
}  // namespace repose::doe

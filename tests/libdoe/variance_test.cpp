// Variance decomposition against a worked example, NIST's analyses of variance and theory.
#include "repose/doe/variance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nist.hpp"
#include "repose/base/random.hpp"

namespace repose::doe {
namespace {

TEST(VarianceDecomposition, OfThreeRunsWithThreeRepetitionsIsTheWorkedExample) {
  Matrix values(3, 3);
  values << 1, 2, 3, 2, 3, 7, 10, 11, 12;
  const VarianceDecomposition v = decompose_variance(values);
  EXPECT_NEAR(v.between_ss, 134.0, 1e-12);
  EXPECT_NEAR(v.within_ss, 18.0, 1e-12);
  EXPECT_NEAR(v.parameter_share, 0.881578947368421, 1e-14);  // 134/152
  EXPECT_NEAR(v.stochastic_share, 0.118421052631579, 1e-14);
  EXPECT_NEAR(v.unbiased_variance, 64.0 / 3.0, 1e-12);
  EXPECT_NEAR(v.unbiased_share, 0.876712328767123, 1e-14);
  EXPECT_NEAR(v.f, 67.0 / 3.0, 1e-12);
  EXPECT_EQ(v.noise_floor, 0.25);
  // P(F > f; 2, 6) = (1 + f/3)^-3
  EXPECT_NEAR(v.p_value, std::pow(1.0 + 67.0 / 9.0, -3.0), 1e-15);
}

TEST(VarianceDecomposition, OfPureNoiseHasTheNoiseFloorOnAverage) {
  RandomStream random(17);
  const int trials = 2000;
  double sum = 0.0, square = 0.0;
  for (int trial = 0; trial < trials; ++trial) {
    Matrix values(29, 5);
    for (double& value : values.reshaped()) value = random.normal();
    const VarianceDecomposition v = decompose_variance(values);
    sum += v.parameter_share;
    square += v.parameter_share * v.parameter_share;
    EXPECT_DOUBLE_EQ(v.noise_floor, 28.0 / 144.0);
  }
  const double mean = sum / trials, deviation = std::sqrt(square / trials - mean * mean);
  EXPECT_NEAR(mean, 28.0 / 144.0, 4.0 * deviation / std::sqrt(trials));  // false alarm 6e-5
}

TEST(VarianceDecomposition, LeavesMissingValuesOut) {
  const double nan = std::nan("");
  Matrix values(4, 3);
  values << 1, nan, 3, 2, 3, 7, nan, nan, nan, 10, 11, nan;
  const VarianceDecomposition v = decompose_variance(values);
  EXPECT_EQ(v.runs, 3);
  EXPECT_EQ(v.observations, 7);
  // Means 2, 4, 10.5 of 2, 3, 2 values; overall 37/7.
  const double overall = 37.0 / 7.0;
  EXPECT_NEAR(
      v.between_ss,
      2 * std::pow(2 - overall, 2) + 3 * std::pow(4 - overall, 2) + 2 * std::pow(10.5 - overall, 2),
      1e-12);
  EXPECT_NEAR(v.within_ss, 2.0 + 14.0 + 0.5, 1e-12);
  const double repetitions = (7.0 - 17.0 / 7.0) / 2.0;
  EXPECT_NEAR(v.unbiased_variance, (v.between_ss / 2 - v.within_ss / 4) / repetitions, 1e-12);
}

TEST(VarianceDecomposition, WithoutRepetitionsTestsNothing) {
  const VarianceDecomposition v = decompose_variance(Vector::LinSpaced(5, 1.0, 2.0));
  EXPECT_EQ(v.parameter_share, 1.0);
  EXPECT_EQ(v.noise_floor, 1.0);
  EXPECT_TRUE(std::isnan(v.f) && std::isnan(v.p_value) && std::isnan(v.unbiased_share));
}

TEST(VarianceDecomposition, RefusesTooFewRunsAndInfiniteValues) {
  EXPECT_THROW(decompose_variance(Matrix::Ones(1, 5)), InputError);
  EXPECT_THROW(decompose_variance(Matrix::Constant(3, 3, std::nan(""))), InputError);
  EXPECT_THROW(decompose_variance(Matrix::Constant(3, 3, INFINITY)), InputError);
}

class NistAnova : public testing::TestWithParam<test::NistAnova> {};

TEST_P(NistAnova, IsReproducedToTheDigitsThatTheInputLeaves) {
  const auto digits = test::digits_of(GetParam());
  EXPECT_GT(digits.f, GetParam().digits);
  EXPECT_GT(digits.between_ss, GetParam().digits - 0.5);
  EXPECT_GT(digits.within_ss, GetParam().digits - 0.5);
  EXPECT_GT(digits.share, GetParam().digits - 0.5);
}

INSTANTIATE_TEST_SUITE_P(StRD, NistAnova, testing::ValuesIn(test::nist_anovas()),
                         [](const auto& parameter) { return parameter.param.name; });

}  // namespace
}  // namespace repose::doe

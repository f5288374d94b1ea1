// Variance decomposition against a worked example, NIST's analyses of variance and theory.
#include "repose/doe/variance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "csv.hpp"
#include "repose/base/random.hpp"

namespace repose::doe {
namespace {

double digits(double value, double certified) {
  const double error = std::abs(value / certified - 1.0);
  return error == 0.0 ? 15.0 : std::min(15.0, -std::log10(error));
}

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

double certified(const std::string& dataset, const std::string& quantity) {
  for (const auto& row : test::read_csv("nist/certified_anova.csv").rows)
    if (row[0] == dataset && row[2] == quantity) return std::stod(row[3]);
  throw InputError(dataset + " has no " + quantity);
}

/// Treatments are runs, observations are repetitions.
Matrix read_nist(const std::string& name, int treatments, int repetitions) {
  std::istringstream text(
      read_file(std::filesystem::path(REPOSE_TEST_DATA) / "doe" / "nist" / (name + ".dat")));
  std::string line;  // the data follow the second line that begins with "Data:"
  for (int found = 0; found < 2 && std::getline(text, line);)
    found += line.rfind("Data:", 0) == 0 ? 1 : 0;
  Matrix values(treatments, repetitions);
  std::vector<int> filled(static_cast<std::size_t>(treatments), 0);
  int treatment = 0;
  double value = 0.0;
  while (text >> treatment >> value)
    values(treatment - 1, filled[static_cast<std::size_t>(treatment - 1)]++) = value;
  return values;
}

void expect_certified(const std::string& name, const Matrix& values, double digits_of_f) {
  const VarianceDecomposition v = decompose_variance(values);
  EXPECT_GT(digits(v.between_ss, certified(name, "ss_between")), digits_of_f - 0.5) << name;
  EXPECT_GT(digits(v.within_ss, certified(name, "ss_within")), digits_of_f - 0.5) << name;
  EXPECT_GT(digits(v.f, certified(name, "F")), digits_of_f - 0.5) << name;
  EXPECT_GT(digits(v.parameter_share, certified(name, "r_squared")), digits_of_f - 0.5) << name;
}

TEST(NistAnalysisOfVariance, IsReproducedForMeasuredData) {
  expect_certified("SiRstv", read_nist("SiRstv", 5, 5), 13.0);
  expect_certified("AtmWtAg", read_nist("AtmWtAg", 2, 24),
                   10.0);  // seven leading digits are constant
}

/// y_ij = C + o_i + e_j as decimals, correctly rounded: o = 0, -.1, .1, ...; e = .4, .3, .5, .3,
/// ...
Matrix simon_lesage(double constant, int repetitions) {
  Matrix values(9, repetitions);
  for (int i = 0; i < 9; ++i)
    for (int j = 0; j < repetitions; ++j) {
      const int o = i == 0 ? 0 : (i % 2 == 1 ? -1 : 1);
      const int e = j == 0 ? 4 : (j % 2 == 1 ? 3 : 5);
      values(i, j) = (10.0 * constant + o + e) / 10.0;
    }
  return values;
}

// With 13 constant digits the input itself is rounded to four digits of what varies.
TEST(NistAnalysisOfVariance, KeepsTheDigitsThatRoundedInputLeaves) {
  const char* names[] = {"SmLs01", "SmLs02", "SmLs03", "SmLs04", "SmLs05",
                         "SmLs06", "SmLs07", "SmLs08", "SmLs09"};
  const double constants[] = {1.0, 1e6, 1e12}, reached[] = {14.0, 9.2, 3.2};
  const int repetitions[] = {21, 201, 2001};
  for (int i = 0; i < 9; ++i)
    expect_certified(names[i], simon_lesage(constants[i / 3], repetitions[i % 3]), reached[i / 3]);
}

}  // namespace
}  // namespace repose::doe

// Least squares against NIST's certified regressions, tails against closed forms.
#include "repose/doe/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "csv.hpp"
#include "repose/doe/distributions.hpp"

namespace repose::doe {
namespace {

using test::Csv;
using test::read_csv;

/// Correct digits, -log10 of the relative error (absolute where the certified value is 0), at
/// most 15.
double log_relative_error(double value, double certified) {
  const double error = certified == 0.0 ? std::abs(value) : std::abs(value / certified - 1.0);
  return error == 0.0 ? 15.0 : std::min(15.0, -std::log10(error));
}

struct Problem {
  std::string name;
  int first_power;      ///< 1 leaves the intercept out
  int last_power;       ///< of the polynomial; 0: the columns themselves
  double coefficients;  ///< digits that Householder QR in doubles reaches
  double errors;        ///< the same of standard errors; 0: they are exactly zero
};

Matrix model_of(const Problem& problem, const Csv& data) {
  const auto columns = data.header.size() - 1;
  const Matrix inputs = data.numbers(1, columns);
  const int last = problem.last_power > 0 ? problem.last_power : static_cast<int>(columns);
  Matrix x(inputs.rows(), last - problem.first_power + 1);
  for (int j = problem.first_power; j <= last; ++j)
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      double value = 1.0;
      if (problem.last_power == 0)
        value = j == 0 ? 1.0 : inputs(i, j - 1);
      else
        for (int power = 0; power < j; ++power) value *= inputs(i, 0);
      x(i, j - problem.first_power) = value;
    }
  return x;
}

class NistRegression : public testing::TestWithParam<Problem> {};

TEST_P(NistRegression, IsReproducedToTheDigitsOfItsArithmetic) {
  const Problem problem = GetParam();
  const Csv data = read_csv("nist/" + problem.name + ".csv");
  const LeastSquaresFit fit = fit_least_squares(model_of(problem, data), data.numbers(0, 1));
  double coefficients = 15.0, errors = 15.0;
  int compared = 0;
  for (const std::vector<std::string>& row : read_csv("nist/certified_linear.csv").rows) {
    if (row[0] != problem.name) continue;
    const double certified = std::stod(row[2]);
    if (row[1][0] == 'B') {
      const int j = std::stoi(row[1].substr(1)) - problem.first_power;
      coefficients = std::min(coefficients, log_relative_error(fit.coefficients(j), certified));
      if (problem.errors > 0.0)
        errors = std::min(errors, log_relative_error(fit.standard_errors(j), std::stod(row[3])));
      ++compared;
    } else if (row[1] == "residual_sd" && problem.errors > 0.0) {
      EXPECT_GT(log_relative_error(fit.sigma, certified), problem.errors);
    } else if (row[1] == "residual_sd") {
      EXPECT_LT(fit.sigma, 1e-13 * data.numbers(0, 1).cwiseAbs().maxCoeff());
    } else if (row[1] == "r_squared") {
      // R2 = 1 - RSS/TSS has the error of sigma, twice, times 1 - R2.
      EXPECT_NEAR(fit.r_squared, certified,
                  2.0 * (1.0 - certified) * std::pow(10.0, -problem.errors) + 1e-12 * certified);
    }
  }
  RecordProperty("coefficient_digits", std::to_string(coefficients));
  RecordProperty("error_digits", std::to_string(errors));
  EXPECT_EQ(compared, fit.coefficients.size());
  EXPECT_GT(coefficients, problem.coefficients) << "digits: " << coefficients;
  EXPECT_GT(errors, problem.errors) << "digits: " << errors;
}

// Digits as published for this algorithm by several packages, less half a digit for the order of
// sums.
INSTANTIATE_TEST_SUITE_P(
    StRD, NistRegression,
    testing::Values(Problem{"Norris", 0, 1, 11.7, 13.0}, Problem{"Pontius", 0, 2, 11.5, 12.3},
                    Problem{"NoInt1", 1, 1, 14.5, 14.3}, Problem{"NoInt2", 1, 1, 14.5, 14.3},
                    Problem{"Filip", 0, 10, 6.9, 7.2}, Problem{"Longley", 0, 0, 10.1, 11.7},
                    Problem{"Wampler1", 0, 5, 9.0, 0.0}, Problem{"Wampler2", 0, 5, 12.0, 0.0},
                    Problem{"Wampler3", 0, 5, 9.0, 12.8}, Problem{"Wampler4", 0, 5, 7.5, 12.8},
                    Problem{"Wampler5", 0, 5, 5.5, 12.8}),
    [](const auto& parameter) { return parameter.param.name; });

TEST(LeastSquares, NamesTheColumnThatDependsOnOthers) {
  Matrix x = Matrix::Ones(6, 4);
  x.col(1) << 1, 2, 3, 4, 5, 6;
  x.col(2) << 1, 0, 1, 0, 1, 1;
  x.col(3) = 2.0 * x.col(1) - 3.0 * x.col(2) + x.col(0);
  try {
    fit_least_squares(x, Vector::Ones(6), {"1", "mu_s", "mu_r", "both"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("both depends linearly"), std::string::npos)
        << error.what();
  }
  EXPECT_THROW(fit_least_squares(Matrix::Zero(3, 1), Vector::Ones(3)), InputError);
}

TEST(LeastSquares, RefusesSizesAndValuesThatCannotBeFitted) {
  EXPECT_THROW(fit_least_squares(Matrix::Ones(2, 3), Vector::Ones(2)), InputError);
  EXPECT_THROW(fit_least_squares(Matrix::Ones(3, 1), Vector::Ones(2)), InputError);
  EXPECT_THROW(fit_least_squares(Matrix::Ones(3, 1), Vector::Ones(3), {"1", "2"}), InputError);
  Vector y = Vector::Ones(3);
  y(1) = std::nan("");
  EXPECT_THROW(fit_least_squares(Matrix::Ones(3, 1), y), InputError);
}

TEST(LeastSquares, WithoutResidualDegreesOfFreedomGivesNoTests) {
  const LeastSquaresFit fit =
      fit_least_squares(Matrix::Identity(3, 3), Vector::LinSpaced(3, 1.0, 3.0));
  EXPECT_EQ(fit.residual_df, 0);
  EXPECT_TRUE(fit.coefficients.isApprox(Vector::LinSpaced(3, 1.0, 3.0), 1e-15));
  EXPECT_TRUE(std::isnan(fit.sigma) && std::isnan(fit.p(0)));
}

// P(F > f; 2, d) = (1 + 2 f/d)^(-d/2) and P(|T| > t; 1) = 2/pi atan(1/t), P(|T| > t; 2) = 1 -
// t/sqrt(t^2 + 2).
TEST(TailProbabilities, HaveTwelveDigitsOfClosedFormsFarIntoTheTail) {
  for (const double f : {1e-8, 0.01, 0.5, 1.0, 3.0, 40.0, 1e3, 1e6, 1e20})
    for (const double df : {1.0, 3.0, 13.0, 29.0}) {
      const double exact = std::exp(-0.5 * df * std::log1p(2.0 * f / df));
      EXPECT_NEAR(f_upper_tail(f, 2.0, df), exact, 1e-12 * exact) << f << " " << df;
    }
  for (const double t : {1e-5, 0.3, 1.0, 5.0, 1e3, 1e8}) {
    const double cauchy = 2.0 / M_PI * std::atan(1.0 / t);
    EXPECT_NEAR(t_two_sided(t, 1.0), cauchy, 1e-12 * cauchy) << t;
    EXPECT_EQ(t_two_sided(-t, 1.0), t_two_sided(t, 1.0));
    const double root = std::sqrt(t * t + 2.0), two = 2.0 / (root * (root + t));
    EXPECT_NEAR(t_two_sided(t, 2.0), two, 1e-12 * two) << t;
  }
}

TEST(TailProbabilities, AreDefinedAtTheEnds) {
  EXPECT_EQ(f_upper_tail(0.0, 2.0, 3.0), 1.0);
  EXPECT_EQ(f_upper_tail(INFINITY, 2.0, 3.0), 0.0);
  EXPECT_EQ(t_two_sided(0.0, 3.0), 1.0);
  EXPECT_EQ(t_two_sided(-INFINITY, 3.0), 0.0);
  EXPECT_TRUE(std::isnan(f_upper_tail(NAN, 2.0, 3.0)));
  EXPECT_TRUE(std::isnan(f_upper_tail(1.0, 2.0, 0.0)));
}

}  // namespace
}  // namespace repose::doe

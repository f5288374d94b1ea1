// Least squares against NIST's certified regressions, tails against closed forms.
#include "repose/doe/least_squares.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nist.hpp"
#include "repose/doe/distributions.hpp"

namespace repose::doe {
namespace {

class NistRegression : public testing::TestWithParam<test::NistProblem> {};

TEST_P(NistRegression, IsReproducedToTheDigitsOfItsArithmetic) {
  const test::NistProblem problem = GetParam();
  const test::NistDigits digits = test::digits_of(problem);
  RecordProperty("coefficient_digits", std::to_string(digits.coefficients));
  RecordProperty("error_digits", std::to_string(digits.errors));
  EXPECT_GT(digits.coefficients, problem.coefficients);
  EXPECT_GT(digits.errors, problem.errors);
  EXPECT_GT(digits.sigma, problem.errors);
  // R2 = 1 - RSS/TSS has the error of sigma, twice, times 1 - R2.
  EXPECT_NEAR(digits.r_squared, digits.certified_r_squared,
              2.0 * (1.0 - digits.certified_r_squared) * std::pow(10.0, -problem.errors) + 1e-12);
}

INSTANTIATE_TEST_SUITE_P(StRD, NistRegression, testing::ValuesIn(test::nist_problems()),
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

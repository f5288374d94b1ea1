// Analysis of variance against refitting without terms, and diagnostics against leaving runs out.
#include "repose/doe/anova.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "random_matrix.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/distributions.hpp"
#include "repose/doe/least_squares.hpp"
#include "repose/doe/regression_diagnostics.hpp"

namespace repose::doe {
namespace {

using test::random_matrix;

double residual_of(const Matrix& x, const Vector& y, const std::vector<int>& columns) {
  return fit_least_squares(x(Eigen::all, columns), y).residual_ss;
}

class AnovaOfUnequalGroups : public testing::Test {
 protected:
  AnovaOfUnequalGroups() {
    x.col(0).setOnes();
    y += 2.0 * x.col(1) + x.col(3);
    full = residual_of(x, y, {0, 1, 2, 3, 4, 5});
  }
  Matrix x = random_matrix(25, 6, 1);
  Vector y = random_matrix(25, 1, 2);
  std::vector<ColumnGroup> groups{{"a", {1}, {2}}, {"c", {3, 4}, {}}, {"a*b", {2}, {}}};
  double full = 0.0;              // column 5 is always in
  const double rounding = 1e-10;  // of differences of residual sums of squares of about 100

  void expect_row(const AnovaRow& row, double ss, int df) {
    EXPECT_NEAR(row.sum_of_squares, ss, rounding) << row.term;
    EXPECT_EQ(row.df, df);
    const double f = ss / df / (full / 19.0);
    EXPECT_NEAR(row.f, f, 1e-10 * f);
    EXPECT_NEAR(row.p, f_upper_tail(f, df, 19.0), 1e-10);
  }
};

TEST_F(AnovaOfUnequalGroups, TypeOneAddsTermsInTheirOrder) {
  const auto rows = analysis_of_variance(x, y, groups, SumsOfSquares::type_one);
  const double none = residual_of(x, y, {0, 5}), a = residual_of(x, y, {0, 5, 1}),
               ac = residual_of(x, y, {0, 5, 1, 3, 4});
  expect_row(rows[0], none - a, 1);
  expect_row(rows[1], a - ac, 2);
  expect_row(rows[2], ac - full, 1);
  EXPECT_NEAR(rows[0].sum_of_squares + rows[1].sum_of_squares + rows[2].sum_of_squares, none - full,
              rounding);
}

TEST_F(AnovaOfUnequalGroups, TypeTwoLeavesOutTermsThatContainTheTestedOne) {
  const auto rows = analysis_of_variance(x, y, groups, SumsOfSquares::type_two);
  expect_row(rows[0], residual_of(x, y, {0, 5, 3, 4}) - residual_of(x, y, {0, 5, 1, 3, 4}), 1);
  expect_row(rows[1], residual_of(x, y, {0, 5, 1, 2}) - full, 2);
  expect_row(rows[2], residual_of(x, y, {0, 5, 1, 3, 4}) - full, 1);
}

TEST_F(AnovaOfUnequalGroups, TypeThreeDropsATermFromTheWholeModel) {
  const auto rows = analysis_of_variance(x, y, groups);
  expect_row(rows[0], residual_of(x, y, {0, 5, 2, 3, 4}) - full, 1);
  expect_row(rows[1], residual_of(x, y, {0, 5, 1, 2}) - full, 2);
  expect_row(rows[2], residual_of(x, y, {0, 5, 1, 3, 4}) - full, 1);
  const LeastSquaresFit fit = fit_least_squares(x, y);
  EXPECT_NEAR(rows[0].f, fit.t(1) * fit.t(1), 1e-10 * rows[0].f);
}

TEST(Anova, TypesAgreeForMainEffectsOfADefinitiveScreeningDesign) {
  const Matrix coded = definitive_screening_design(6).coded;
  const Vector y = random_matrix(coded.rows(), 1, 3);
  const std::vector<std::string> factors{"a", "b", "c", "d", "e", "f"};
  const std::vector<Term> terms{main_effect(0), main_effect(1), quadratic(0), interaction(0, 1)};
  const auto one = analysis_of_variance(coded, y, factors, terms, SumsOfSquares::type_one);
  const auto two = analysis_of_variance(coded, y, factors, terms, SumsOfSquares::type_two);
  const auto three = analysis_of_variance(coded, y, factors, terms, SumsOfSquares::type_three);
  for (std::size_t j = 0; j < 2; ++j) {
    EXPECT_NEAR(one[j].sum_of_squares, three[j].sum_of_squares, 1e-12);
    EXPECT_NEAR(two[j].sum_of_squares, three[j].sum_of_squares, 1e-12);
  }
  EXPECT_EQ(one[3].term, "a*b");
  EXPECT_NEAR(one[3].sum_of_squares, three[3].sum_of_squares, 1e-12);  // the last one
}

TEST(Anova, KeepsBlocksInTheModelAndOutOfTheTable) {
  const Matrix coded = definitive_screening_design(6).coded;
  std::vector<int> blocks;
  for (Eigen::Index i = 0; i < coded.rows(); ++i) blocks.push_back(3 + static_cast<int>(i % 3));
  const Vector y = random_matrix(coded.rows(), 1, 4);
  const std::vector<std::string> factors{"a", "b", "c", "d", "e", "f"};
  const auto rows =
      analysis_of_variance(coded, y, factors, {main_effect(2)}, SumsOfSquares::type_one, blocks);
  const Matrix with = model_matrix(coded, {main_effect(2)}, blocks);
  ASSERT_EQ(with.cols(), 4);  // intercept, c, blocks 4 and 5
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_NEAR(rows[0].sum_of_squares,
              residual_of(with, y, {0, 2, 3}) - residual_of(with, y, {0, 1, 2, 3}), 1e-12);
  EXPECT_EQ(column_names({main_effect(2)}, factors, blocks).back(), "block 5");
}

TEST(Anova, RefusesGroupsThatDoNotFit) {
  const Matrix x = random_matrix(9, 3, 5);
  const Vector y = random_matrix(9, 1, 6);
  const auto expect_refused = [&](const std::vector<ColumnGroup>& groups, const char* what) {
    try {
      analysis_of_variance(x, y, groups);
      FAIL() << what;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    }
  };
  expect_refused({{"a", {}}}, "term a has no columns");
  expect_refused({{"a", {3}}}, "column 3, which does not exist");
  expect_refused({{"a", {1}}, {"b", {1}}}, "column 1, which is named twice");
  expect_refused({{"a", {1}, {2}}}, "there are 1 terms");
  EXPECT_THROW(analysis_of_variance(x, random_matrix(8, 1, 7), {}), InputError);
}

TEST(RegressionDiagnostics, EqualFitsWithOneRowLeftOut) {
  Matrix x = random_matrix(14, 4, 8);
  x.col(0).setOnes();
  x.col(3) = x.col(2) + 0.1 * x.col(3);
  const Vector y = random_matrix(14, 1, 9);
  const LeastSquaresFit fit = fit_least_squares(x, y);
  const RegressionDiagnostics d = diagnose_regression(x, y);
  EXPECT_NEAR(d.leverage.sum(), 4.0, 1e-13);
  double press = 0.0;
  for (Eigen::Index row = 0; row < 14; ++row) {
    std::vector<Eigen::Index> others;
    for (Eigen::Index i = 0; i < 14; ++i)
      if (i != row) others.push_back(i);
    const LeastSquaresFit without = fit_least_squares(x(others, Eigen::all), y(others));
    const double left_out = x.row(row).dot(without.coefficients);
    const Vector shift = x * (fit.coefficients - without.coefficients);
    EXPECT_NEAR(d.left_out(row), left_out, 1e-11);
    EXPECT_NEAR(d.studentised_deleted(row),
                d.residual(row) / (without.sigma * std::sqrt(1.0 - d.leverage(row))), 1e-10);
    EXPECT_NEAR(d.cooks_distance(row), shift.squaredNorm() / (4.0 * fit.sigma * fit.sigma), 1e-10);
    press += std::pow(y(row) - left_out, 2);
  }
  EXPECT_NEAR(d.press, press, 1e-10 * press);
  EXPECT_NEAR(d.predicted_r_squared, 1.0 - press / fit.total_ss, 1e-11);
  EXPECT_TRUE(std::isnan(d.variance_inflation(0)));
  for (const int j : {1, 2, 3}) {  // 1/(1 - R^2) of the column on the others
    std::vector<int> others;
    for (const int i : {0, 1, 2, 3})
      if (i != j) others.push_back(i);
    const double r2 = fit_least_squares(x(Eigen::all, others), x.col(j)).r_squared;
    EXPECT_NEAR(d.variance_inflation(j), 1.0 / (1.0 - r2), 1e-9 * d.variance_inflation(j));
  }
  EXPECT_GT(d.variance_inflation(3), 10.0);
}

TEST(RegressionDiagnostics, OfAnOrthogonalDesignHaveNoInflation) {
  const Matrix coded = definitive_screening_design(12).coded;
  const Matrix x = model_matrix(coded, candidate_terms(12, CandidateTerms::main_effects));
  const RegressionDiagnostics d = diagnose_regression(x, random_matrix(x.rows(), 1, 10));
  EXPECT_TRUE(d.variance_inflation.tail(12).isApprox(Vector::Ones(12), 1e-13));
}

TEST(RegressionDiagnostics, OfAnyConstantResponseHaveNoPredictedShare) {
  for (const double value : {0.1, 12.9, 1.0 / 3.0}) {
    const auto d = diagnose_regression(Matrix::Ones(13, 1), Vector::Constant(13, value));
    EXPECT_TRUE(std::isnan(d.predicted_r_squared)) << value;
  }
}

TEST(LeastSquares, RefusesAResponseWhoseSquareNoDoubleHolds) {
  const Matrix x = random_matrix(9, 2, 5);
  EXPECT_THROW(fit_least_squares(x, 1e-200 * random_matrix(9, 1, 6)), InputError);
  EXPECT_THROW(fit_least_squares(x, 1e200 * random_matrix(9, 1, 6)), InputError);
  EXPECT_NO_THROW(fit_least_squares(x, Vector::Zero(9)));
}

TEST(RegressionDiagnostics, SayThatARowWhichAloneDeterminesACoefficientCannotBeLeftOut) {
  Matrix x = Matrix::Zero(6, 2);
  x.col(0).setOnes();
  x(4, 1) = 1.0;
  const RegressionDiagnostics d = diagnose_regression(x, Vector::LinSpaced(6, 0.0, 5.0));
  EXPECT_NEAR(d.leverage(4), 1.0, 1e-14);
  EXPECT_TRUE(std::isnan(d.left_out(4)) && std::isnan(d.cooks_distance(4)));
  EXPECT_TRUE(std::isnan(d.press));
  EXPECT_FALSE(std::isnan(d.left_out(0)));
}

// Pure error within the repeated points, the rest of the residual about their means.
TEST(LackOfFitTest, SplitsTheResidualAtRepeatedRuns) {
  Matrix x(7, 2);
  x.col(0).setOnes();
  x.col(1) << 0, 0, 1, 1, 1, 2, 3;
  Vector y(7);
  y << 1, 3, 2, 4, 6, 9, 2;
  const LackOfFit test = lack_of_fit(x, y, x);
  EXPECT_NEAR(test.pure_ss, 2.0 + 8.0, 1e-13);
  EXPECT_EQ(test.pure_df, 3);
  EXPECT_EQ(test.lack_df, 2);
  const double residual = fit_least_squares(x, y).residual_ss;
  EXPECT_NEAR(test.lack_ss, residual - 10.0, 1e-12);
  EXPECT_NEAR(test.f, (residual - 10.0) / 2.0 / (10.0 / 3.0), 1e-12);
  EXPECT_NEAR(test.p, f_upper_tail(test.f, 2.0, 3.0), 1e-14);
  EXPECT_TRUE(std::isnan(lack_of_fit(x.bottomRows(3), y.tail(3), x.bottomRows(3)).p));
  // Rows alike in the model that differ in a factor left out are no repeats.
  Matrix points(7, 2);
  points << x.col(1), Vector::LinSpaced(7, 0.0, 6.0);
  EXPECT_EQ(lack_of_fit(x, y, points).pure_df, 0);
  EXPECT_THROW(lack_of_fit(x, y, points.topRows(3)), InputError);
}

TEST(InformationCriteriaTest, AreMinusTwiceTheLogLikelihoodPlusTheirPenalties) {
  // Ten residuals of +-1: sigma^2 = 1, ln L = -5 (ln 2 pi + 1).
  const InformationCriteria criteria = information_criteria(10.0, 10, 2);
  const double likelihood = 10.0 * (std::log(2.0 * M_PI) + 1.0);
  EXPECT_NEAR(criteria.bic, likelihood + 3.0 * std::log(10.0), 1e-12);
  EXPECT_NEAR(criteria.aicc, likelihood + 6.0 + 24.0 / 6.0, 1e-12);
  EXPECT_TRUE(std::isinf(information_criteria(1.0, 5, 3).aicc));
  EXPECT_EQ(information_criteria(0.0, 5, 1).bic, -INFINITY);
  EXPECT_THROW(information_criteria(-1.0, 5, 1), InputError);
}

}  // namespace
}  // namespace repose::doe

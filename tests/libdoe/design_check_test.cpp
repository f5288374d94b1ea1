// The check of a design against the two designs of the thesis, and what the check says it can find.
#include "repose/doe/design_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/math/distributions/non_central_f.hpp>
#include <cmath>

#include "csv.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/distributions.hpp"
#include "repose/doe/least_squares.hpp"

namespace repose::doe {
namespace {

using test::read_csv;

TEST(DesignCheck, AcceptsThePrintedDesignOfFifteenFactors) {
  const DesignCheck check = check_design(read_csv("dsd_15_factors_coded.csv").numbers(1, 15));
  EXPECT_TRUE(check.is_definitive_screening());
  EXPECT_TRUE(check.is_orthogonal());
  EXPECT_EQ(check.centre_runs, std::vector<int>{25});
  EXPECT_EQ(check.pairs.size(), 18u);
  EXPECT_EQ(check.pairs.front(), (std::pair<int, int>{0, 12}));
  EXPECT_TRUE(check.orphans.empty());
  EXPECT_EQ(check.column_sum_max, 0.0);
  EXPECT_TRUE(check.aliases.empty());
  EXPECT_EQ(check.alias_rms, 0.0);
  EXPECT_EQ(check.residual_df, 21);
  EXPECT_EQ(check.two_stage_df, 3);
  // X^T X = diag(37, 34, ..., 34): exact but for rounding of a determinant of order 16.
  EXPECT_NEAR(check.d_efficiency, std::pow(37.0 * std::pow(34.0, 15), 1.0 / 16) / 37, 1e-13);
  for (const double error : check.standard_error) EXPECT_NEAR(error, 1 / std::sqrt(34.0), 1e-14);
}

TEST(DesignCheck, RefusesThePrintedDesignOfTwelveFactors) {
  const DesignCheck check = check_design(read_csv("dsd_12_factors_coded.csv").numbers(1, 12));
  EXPECT_FALSE(check.is_definitive_screening());
  EXPECT_TRUE(check.centre_runs.empty());
  EXPECT_EQ(check.orphans,
            (std::vector<int>{0, 7, 9, 14, 15, 18, 20}));  // runs 1, 8, 10, 15, 16, 19, 21
  EXPECT_EQ(check.pairs.size(), 11u);
  EXPECT_EQ(check.gram_offdiagonal_max, 5.0);
  EXPECT_NEAR(check.correlation_max, 0.190, 0.0005);  // computed independently, three digits
  EXPECT_NEAR(check.alias_max, 0.42, 0.005);          // two digits
  ASSERT_EQ(check.problems.size(), 3u);
  EXPECT_EQ(check.problems[0], "there is no centre run");
  EXPECT_EQ(check.problems[1], "runs without a mirror image: 1, 8, 10, 15, 16, 19 and 21");
  // mu_s_ss carries the most, of mu_s_ss*C_r_pg; computed independently, two and three digits.
  EXPECT_EQ(check.aliases.front().factor, 3);
  EXPECT_EQ(check.aliases.front().second_order, interaction(3, 8));
  EXPECT_EQ(std::abs(check.aliases.front().coefficient), check.alias_max);
  EXPECT_NEAR(check.alias_rms, 0.118, 0.0005);
  EXPECT_NEAR(check.d_efficiency, 0.911, 0.0005);
}

TEST(DesignCheck, AcceptsTheRepairedDesignsOfTwelveFactors) {
  const DesignCheck completed =
      check_design(read_csv("dsd_12_factors_completed_37.csv").numbers(2, 12));
  EXPECT_TRUE(completed.is_definitive_screening());
  EXPECT_TRUE(completed.is_orthogonal());
  const DesignCheck valid = check_design(read_csv("dsd_12_factors_valid_29.csv").numbers(1, 12));
  EXPECT_TRUE(valid.is_definitive_screening());
  EXPECT_TRUE(valid.is_orthogonal());
  EXPECT_NEAR(valid.d_efficiency, std::pow(29.0 * std::pow(26.0, 12), 1.0 / 13) / 29, 1e-13);
}

Matrix appended(const Matrix& coded, const Matrix& runs) {
  Matrix all(coded.rows() + runs.rows(), coded.cols());
  all << coded, runs;
  return all;
}

std::vector<std::vector<double>> sorted_rows(const Matrix& coded) {
  std::vector<std::vector<double>> rows;
  for (Eigen::Index i = 0; i < coded.rows(); ++i) {
    const Vector row = coded.row(i);
    rows.emplace_back(row.begin(), row.end());
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

TEST(MissingRuns, CompleteThePrintedDesignOfTwelveFactorsToThirtySevenRuns) {
  const Matrix printed = read_csv("dsd_12_factors_coded.csv").numbers(1, 12);
  const Matrix missing = missing_runs(printed);
  EXPECT_EQ(missing.rows(), 8);
  EXPECT_EQ(missing.row(0), -printed.row(0));
  EXPECT_TRUE(missing.row(7).isZero(0.0));
  const Matrix completed = appended(printed, missing);
  EXPECT_EQ(sorted_rows(completed),
            sorted_rows(read_csv("dsd_12_factors_completed_37.csv").numbers(2, 12)));
  EXPECT_TRUE(check_design(completed).is_definitive_screening());
}

TEST(MissingRuns, AreNoneInACompleteDesignAndThoseTakenOutOfIt) {
  for (const int factors : {3, 6, 12, 21}) {
    const Matrix whole =
        definitive_screening_design(factors, {.run_order = RunOrder::structured}).coded;
    EXPECT_EQ(missing_runs(whole).rows(), 0);
    EXPECT_EQ(missing_runs(whole).cols(), factors);
    std::vector<Eigen::Index> kept{1, 3};  // without 0, 2 and the centre run at the end
    for (Eigen::Index run = 4; run + 1 < whole.rows(); ++run) kept.push_back(run);
    const Matrix rest = whole(kept, Eigen::all);
    EXPECT_EQ(sorted_rows(appended(rest, missing_runs(rest))), sorted_rows(whole)) << factors;
  }
}

// The alias matrix and the standard errors by the normal equations, of a design without structure.
TEST(DesignCheck, AgreesWithTheNormalEquations) {
  RandomStream random(8);
  Matrix coded(14, 4);
  for (double& level : coded.reshaped()) level = 2.0 * random.uniform() - 1.0;
  const DesignCheck check = check_design(coded);
  const Matrix x = model_matrix(coded, candidate_terms(4, CandidateTerms::main_effects));
  const LeastSquaresFit fit = fit_least_squares(x, coded.col(0));  // any response
  ASSERT_EQ(check.aliases.size(), 40u);                            // 4 main effects x 10
  for (const Alias& alias : check.aliases) {
    const Vector z = term_column(coded, alias.second_order);
    const double expected = (fit.unscaled_covariance * (x.transpose() * z))(alias.factor + 1);
    EXPECT_NEAR(alias.coefficient, expected, 1e-12);
  }
  for (int j = 0; j < 4; ++j)
    EXPECT_NEAR(check.standard_error(j), std::sqrt(fit.unscaled_covariance(j + 1, j + 1)), 1e-13);
}

TEST(TTestPower, IsTheTailOfTheNoncentralF) {
  for (const double df : {1.0, 2.0, 3.0, 21.0, 400.0})
    for (const double alpha : {0.2, 0.01, 1e-4})
      for (const double effect : {0.0, 0.3, 2.0, 7.0, 30.0}) {
        const double critical = t_critical(alpha, df);
        const double expected =
            effect == 0.0 ? alpha
                          : cdf(complement(boost::math::non_central_f(1.0, df, effect * effect),
                                           critical * critical));
        EXPECT_NEAR(t_test_power(effect, df, alpha), expected, 1e-9)
            << df << " " << alpha << " " << effect;
        EXPECT_EQ(t_test_power(-effect, df, alpha), t_test_power(effect, df, alpha));
      }
}

// With the error of the fake factors alone an effect of Table B.2 (3 df) is significant at 0.01
// from 1.00 standard deviations of a run, of a design of order 14 (2 df) from 1.95.
TEST(TTestPower, CriticalEffectsOfDefinitiveScreeningDesignsAreThoseComputedIndependently) {
  EXPECT_NEAR(t_critical(0.01, 3) / std::sqrt(34.0), 1.00, 0.005);
  EXPECT_NEAR(t_critical(0.01, 2) / std::sqrt(26.0), 1.95, 0.005);
  for (const double df : {1.0, 5.0, 80.0})
    EXPECT_NEAR(t_two_sided(t_critical(0.01, df), df), 0.01, 1e-13) << df;
}

TEST(TTestPower, RefusesWhatIsNoTest) {
  EXPECT_THROW(t_critical(0.0, 3), InputError);
  EXPECT_THROW(t_critical(0.01, 0), InputError);
  EXPECT_THROW(t_test_power(std::nan(""), 3, 0.01), InputError);
  EXPECT_EQ(t_test_power(1e300, 1, 0.01), 1.0);
}

TEST(DesignCheck, FindsOtherLevelsSeveralZerosAndConfoundedFactors) {
  Matrix coded = definitive_screening_design(6, {.run_order = RunOrder::structured}).coded;
  coded(2, 3) = 0.5;
  const DesignCheck levels = check_design(coded);
  EXPECT_EQ(levels.problems.front(), "runs with levels other than low, middle and high: 3");
  EXPECT_EQ(levels.orphans, (std::vector<int>{2, 3}));

  Matrix twins = definitive_screening_design(6).coded;
  twins.col(1) = twins.col(0);
  const DesignCheck confounded = check_design(twins);
  EXPECT_TRUE(std::isinf(confounded.alias_max));
  EXPECT_FALSE(confounded.is_definitive_screening());

  EXPECT_THROW(check_design(Matrix()), InputError);
  EXPECT_THROW(check_design(Matrix::Constant(3, 2, 1.5)), InputError);
  EXPECT_THROW(check_design(Matrix::Constant(3, 2, std::nan(""))), InputError);
}

TEST(HalfNormalQuantiles, AreWhereTheNormalDistributionHasTheirProbability) {
  for (const int count : {1, 2, 15, 500}) {
    const Vector q = half_normal_quantiles(count);
    ASSERT_EQ(q.size(), count);
    for (int i = 0; i < count; ++i)
      EXPECT_NEAR(std::erf(q(i) / std::sqrt(2.0)), (i + 0.5) / count, 1e-14);
  }
  EXPECT_EQ(half_normal_quantiles(0).size(), 0);
  EXPECT_THROW(half_normal_quantiles(-1), InputError);
}

TEST(DesignCheck, RepairsADesignWithTwoLevelFactorsByMirroredCentreRuns) {
  const Design design = definitive_screening_design(
      7, {.two_level_factors = {2, 5}, .run_order = RunOrder::structured});
  const Matrix damaged = design.coded.topRows(design.coded.rows() - 3);  // a mirror image and both
  const DesignCheck check = check_design(damaged);
  EXPECT_FALSE(check.is_definitive_screening());
  EXPECT_EQ(check.two_level_factors, (std::vector<int>{2, 5}));
  const Matrix added = missing_runs(damaged);
  ASSERT_EQ(added.rows(), 3);
  EXPECT_EQ(added.row(0), design.coded.row(design.coded.rows() - 3));
  Matrix repaired(damaged.rows() + 3, damaged.cols());
  repaired << damaged, added;
  EXPECT_TRUE(check_design(repaired).is_definitive_screening());
}

}  // namespace
}  // namespace repose::doe

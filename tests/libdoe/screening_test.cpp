// Screening: the vote of the thesis, recovery of known factors, error rates, failed runs.
#include "repose/doe/screening.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "csv.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/distributions.hpp"

namespace repose::doe {
namespace {

using Method = ScreeningOptions::Method;

std::vector<std::string> letters(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.emplace_back(1, static_cast<char>('a' + i));
  return names;
}

Matrix noisy(const Vector& mean, int repetitions, double sigma, std::uint64_t seed) {
  RandomStream random(seed);
  Matrix values(mean.size(), repetitions);
  for (double& value : values.reshaped()) value = sigma * random.normal();
  return values.colwise() + mean;
}

TEST(Vote, OnTheCountsOfTableFiveSelectsTheSevenFactorsOfTheThesis) {
  const test::Csv table = test::read_csv("sensitivity_counts_table_5_5.csv");
  std::vector<Vector> counts;
  for (const std::size_t column : {1u, 3u, 5u, 7u}) counts.push_back(table.numbers(column, 1));
  const std::vector<bool> selected = vote(counts, 5, 0.8);
  int number = 0;
  for (std::size_t i = 0; i < selected.size(); ++i) {
    EXPECT_EQ(selected[i], table.rows[i][table.column("selected_at_least_4_of_5")] == "yes")
        << table.rows[i][0];
    number += selected[i] ? 1 : 0;
  }
  EXPECT_EQ(number, 7);
}

TEST(Vote, CountsAShareOfTenRepetitionsWithoutRounding) {
  Vector counts(3);
  counts << 6, 7, 8;
  EXPECT_EQ(vote({counts}, 10, 0.7), (std::vector<bool>{false, true, true}));
  EXPECT_THROW(vote({counts}, 10, 0.0), InputError);
  EXPECT_THROW(vote({counts, Vector::Zero(2)}, 10, 0.5), InputError);
  EXPECT_THROW(vote({}, 10, 0.5), InputError);
}

TEST(FalseDiscoveryRates, AreThePValuesAdjustedByBenjaminiAndHochberg) {
  // The 15 p values of [BenjaminiHochberg1995], section 3.2; at rate 0.05 the first four are found.
  Vector p(15);
  p << 0.0001, 0.0004, 0.0019, 0.0095, 0.0201, 0.0278, 0.0298, 0.0344, 0.0459, 0.3240, 0.4262,
      0.5719, 0.6528, 0.7590, 1.0;
  const Vector rates = false_discovery_rates(p);
  EXPECT_EQ((rates.array() <= 0.05).count(), 4);
  EXPECT_DOUBLE_EQ(rates(3), 0.0095 * 15 / 4);
  EXPECT_DOUBLE_EQ(rates(4), 0.0201 * 15 / 5);
  EXPECT_DOUBLE_EQ(rates(5), 0.0298 * 15 / 7);  // that of the seventh is smaller than its own
  EXPECT_EQ(rates(14), 1.0);
  const Vector reversed = false_discovery_rates(p.reverse());
  EXPECT_EQ(reversed, rates.reverse());
  Vector with_gap(2);
  with_gap << std::nan(""), 0.03;
  EXPECT_TRUE(std::isnan(false_discovery_rates(with_gap)(0)));
  EXPECT_EQ(false_discovery_rates(with_gap)(1), 0.03);
  EXPECT_THROW(false_discovery_rates(Vector::Constant(1, 1.5)), InputError);
}

TEST(Screening, AdjustsThePooledTestsOfAllResponsesTogether) {
  const Matrix x = definitive_screening_design(5).coded;
  const Screening result =
      screen(x, letters(5), {"one", "two"},
             {noisy(2.0 * x.col(0), 3, 1.0, 3), noisy(Vector::Zero(x.rows()), 3, 1.0, 5)});
  Vector p(10);
  p << result.responses[0].pooled_p_value, result.responses[1].pooled_p_value;
  const Vector rates = false_discovery_rates(p);
  EXPECT_EQ(result.responses[0].false_discovery_rate, rates.head(5));
  EXPECT_EQ(result.responses[1].false_discovery_rate, rates.tail(5));
}

class ScreeningMethod : public testing::TestWithParam<Method> {};

TEST_P(ScreeningMethod, RecoversKnownFactorsFromNoisyResponses) {
  const Matrix x = definitive_screening_design(7).coded;  // 21 runs
  const double sigma = 1.0;
  const Vector first = 50.0 + 4.0 * x.col(0).array() - 4.0 * x.col(2).array();
  const Vector second = -3.0 * x.col(5) + 4.0 * x.col(5).cwiseProduct(x.col(0)) + 3.0 * x.col(0);
  const Screening result =
      screen(x, letters(7), {"angle", "flow"},
             {noisy(first, 5, sigma, 1), noisy(second, 5, sigma, 2)}, {.method = GetParam()});
  EXPECT_EQ(result.repetitions, 5);
  EXPECT_EQ(result.selected, (std::vector<bool>{true, false, true, false, false, true, false}));
  const ResponseScreening& angle = result.responses[0];
  EXPECT_EQ(angle.count(0), 5.0);
  EXPECT_EQ(angle.sign(0), 1.0);
  EXPECT_EQ(angle.sign(2), -1.0);
  // Coefficients of orthogonal columns with 18 non-zero levels; five standard errors of the mean of
  // five.
  EXPECT_NEAR(angle.effect(0), 4.0, 5.0 * sigma / std::sqrt(18.0 * 5.0));
  EXPECT_NEAR(angle.effect(2), -4.0, 5.0 * sigma / std::sqrt(18.0 * 5.0));
  EXPECT_LT(angle.p_value(0), 0.01);
  EXPECT_LT(angle.pooled_p_value(0), 1e-20);
  EXPECT_GT(angle.variance.parameter_share, 0.9);
}

INSTANTIATE_TEST_SUITE_P(Methods, ScreeningMethod,
                         testing::Values(Method::stepwise, Method::fit_dsd),
                         [](const auto& parameter) {
                           return parameter.param == Method::stepwise ? "Stepwise" : "TwoStage";
                         });

// The first step decides whether anything enters: the smallest of 15 p values, each uniform, is
// below 0.01 with probability at most 15 * 0.01 (Bonferroni) and at least that less 105 * 0.01^2
// (the squared correlations of orthogonal columns are negatively associated).
TEST(Screening, OfNoiseFindsAFactorAsOftenAsDerived) {
  const Matrix x = test::read_csv("dsd_15_factors_coded.csv").numbers(1, 15);
  const int trials = 2000;
  const Screening result =
      screen(x, letters(15), {"noise"}, {noisy(Vector::Zero(37), trials, 1.0, 23)},
             {.candidates = CandidateTerms::main_effects});
  int with_a_factor = 0;
  for (const FinalModel& model : result.responses[0].models)
    with_a_factor += model.terms.empty() ? 0 : 1;
  const double rate = static_cast<double>(with_a_factor) / trials;
  const double four_deviations = 4.0 * std::sqrt(0.15 * 0.85 / trials);  // false alarm 6e-5
  EXPECT_GT(rate, 0.15 - 0.0105 - four_deviations);
  EXPECT_LT(rate, 0.15 + four_deviations);
  for (const bool selected : result.selected) EXPECT_FALSE(selected);
}

TEST(Screening, PooledPValuesOfNoiseAreUniform) {
  const Matrix x = definitive_screening_design(3).coded;
  const int trials = 500;
  int below = 0, tests = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Screening result =
        screen(x, letters(3), {"noise"},
               {noisy(Vector::Zero(x.rows()), 4, 2.0, 100 + static_cast<std::uint64_t>(trial))},
               {.candidates = CandidateTerms::main_effects});
    for (const double p : result.responses[0].pooled_p_value) {
      below += p < 0.2 ? 1 : 0;
      ++tests;
    }
  }
  EXPECT_NEAR(static_cast<double>(below) / tests, 0.2, 4.0 * std::sqrt(0.2 * 0.8 / tests));
}

TEST(Screening, PooledPValueEqualsTheFitToAllValues) {
  const Matrix x = definitive_screening_design(4).coded;
  Matrix y = noisy(0.4 * x.col(1), 3, 1.0, 9);
  y(2, 1) = y(5, 0) = y(5, 2) = std::nan("");
  const Screening result = screen(x, letters(4), {"y"}, {y});
  std::vector<std::pair<Eigen::Index, Eigen::Index>> present;
  for (Eigen::Index i = 0; i < y.rows(); ++i)
    for (Eigen::Index r = 0; r < y.cols(); ++r)
      if (!std::isnan(y(i, r))) present.emplace_back(i, r);
  Matrix stacked(static_cast<Eigen::Index>(present.size()), 5);
  Vector all(stacked.rows());
  for (Eigen::Index row = 0; row < stacked.rows(); ++row) {
    const auto [i, r] = present[static_cast<std::size_t>(row)];
    stacked(row, 0) = 1.0;
    stacked.row(row).tail(4) = x.row(i);
    all(row) = y(i, r);
  }
  const LeastSquaresFit fit = fit_least_squares(stacked, all);
  const VarianceDecomposition v = decompose_variance(y);
  for (int j = 0; j < 4; ++j) {
    const double t =
        fit.coefficients(j + 1) / std::sqrt(fit.unscaled_covariance(j + 1, j + 1) * v.within_ms);
    EXPECT_NEAR(result.responses[0].pooled_p_value(j), t_two_sided(t, v.observations - v.runs),
                1e-12);
  }
}

TEST(Screening, LeavesAFailedRunOutOfItsRepetitionOnly) {
  const Matrix x = definitive_screening_design(6, {.run_order = RunOrder::structured}).coded;
  const Matrix y = noisy(3.0 * x.col(4), 3, 1.0, 4);
  Matrix with_failure = y;
  with_failure(0, 1) = std::nan("");
  for (const Method method : {Method::stepwise, Method::fit_dsd}) {
    const Screening whole = screen(x, letters(6), {"y"}, {y}, {.method = method});
    const Screening failed = screen(x, letters(6), {"y"}, {with_failure}, {.method = method});
    EXPECT_EQ(failed.responses[0].models[0].terms, whole.responses[0].models[0].terms);
    EXPECT_EQ(failed.responses[0].models[2].terms, whole.responses[0].models[2].terms);
    EXPECT_TRUE(failed.selected[4]);
    EXPECT_EQ(failed.responses[0].variance.observations, 3 * 17 - 1);
  }
  const Screening shortened =
      screen(x.bottomRows(16), letters(6), {"y"}, {Matrix(y.bottomRows(16).col(1))});
  const Screening failed = screen(x, letters(6), {"y"}, {with_failure});
  EXPECT_EQ(failed.responses[0].models[1].terms, shortened.responses[0].models[0].terms);
}

TEST(Screening, SaysHowManyRunsARepetitionNeeds) {
  const Matrix x = definitive_screening_design(6).coded;
  Matrix y = noisy(x.col(0), 2, 1.0, 1);
  y.col(1).head(10).setConstant(std::nan(""));
  try {
    screen(x, letters(6), {"shear_angle_deg"}, {y});
    FAIL();
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(
                  "shear_angle_deg, repetition 2: 7 runs have a value; 6 factors need at least 8"),
              std::string::npos)
        << message;
  }
}

TEST(Screening, AnalysesADesignThatIsNoDefinitiveScreeningDesign) {
  const Matrix x = test::read_csv("dsd_12_factors_coded.csv").numbers(1, 12);
  const Screening result = screen(x, letters(12), {"y"}, {noisy(5.0 * x.col(3), 5, 1.0, 6)});
  EXPECT_TRUE(result.selected[3]);
  EXPECT_THROW(
      screen(x, letters(12), {"y"}, {noisy(x.col(3), 5, 1.0, 6)}, {.method = Method::fit_dsd}),
      InputError);
}

TEST(Screening, OfAConstantResponseSelectsNothing) {
  const Matrix x = definitive_screening_design(5).coded;
  for (const Method method : {Method::stepwise, Method::fit_dsd}) {
    const Screening result =
        screen(x, letters(5), {"y"}, {Matrix::Constant(x.rows(), 3, 0.1)}, {.method = method});
    EXPECT_TRUE((result.responses[0].count.array() == 0.0).all());
    for (const bool selected : result.selected) EXPECT_FALSE(selected);
  }
}

TEST(Screening, OfOneRepetitionHasNoPooledTest) {
  const Matrix x = definitive_screening_design(5).coded;
  const Screening result = screen(x, letters(5), {"y"}, {noisy(5.0 * x.col(1), 1, 1.0, 8)});
  EXPECT_TRUE(result.selected[1]);
  EXPECT_TRUE(result.responses[0].pooled_p_value.array().isNaN().all());
}

TEST(Screening, WithBlocksSeesThroughTheirLevels) {
  const Matrix x = definitive_screening_design(6).coded;
  std::vector<int> blocks(static_cast<std::size_t>(x.rows()), 1);
  Vector levels = Vector::Zero(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (x(i, 0) * x(i, 1) > 0.0) {  // the same for both runs of a pair
      blocks[static_cast<std::size_t>(i)] = 2;
      levels(i) = 30.0;
    }
  const Matrix values = noisy(2.0 * x.col(3), 3, 0.5, 9).colwise() + levels;
  for (const auto method : {Method::stepwise, Method::fit_dsd}) {
    const auto with = screen(x, letters(6), {"angle"}, {values}, {.method = method}, blocks);
    EXPECT_TRUE(with.selected[3]);
    EXPECT_EQ(with.responses[0].models[0].fit.names.back(), "block 2");
    EXPECT_LT(with.responses[0].models[0].fit.sigma, 2.0);
    const auto without = screen(x, letters(6), {"angle"}, {values}, {.method = method});
    EXPECT_GT(without.responses[0].models[0].fit.sigma, 3.0);
  }
  EXPECT_THROW(screen(x, letters(6), {"angle"}, {values}, {}, {1, 2}), InputError);
}

TEST(Screening, PoolsNothingOfRepetitionsThatAgreeExactly) {
  const Matrix x = definitive_screening_design(6).coded;
  const Vector exact = 41.3 + 2.1 * x.col(1).array() - 0.7 * x.col(4).array();
  const Matrix noise = noisy(Vector::Zero(x.rows()), 3, 1.0, 5);
  const auto alone = screen(x, letters(6), {"noise"}, {noise});
  const auto result = screen(x, letters(6), {"exact", "constant", "noise"},
                             {exact.replicate(1, 3), Matrix::Constant(x.rows(), 3, 12.9), noise});
  for (int r : {0, 1})
    EXPECT_TRUE(result.responses[static_cast<std::size_t>(r)].pooled_p_value.array().isNaN().all());
  // They are no part of the family of tests.
  EXPECT_EQ(result.responses[2].false_discovery_rate, alone.responses[0].false_discovery_rate);
  EXPECT_EQ(result.selected, (std::vector<bool>{false, true, false, false, true, false}));
}

TEST(Screening, GoesOnWithoutABlockThatFailedAltogether) {
  const Matrix x = definitive_screening_design(6).coded;
  std::vector<int> blocks(static_cast<std::size_t>(x.rows()), 1);
  Matrix values = noisy(2.0 * x.col(3), 3, 0.5, 9);
  for (const Eigen::Index run : {2, 5}) {
    blocks[static_cast<std::size_t>(run)] = 2;
    values.row(run).setConstant(std::nan(""));
  }
  const auto result = screen(x, letters(6), {"angle"}, {values}, {}, blocks);
  EXPECT_TRUE(result.selected[3]);
  EXPECT_LT(result.responses[0].pooled_p_value(3), 1e-6);
}

TEST(Screening, KeepsBothStagesOfTheTwoStageAnalysis) {
  const Matrix x = definitive_screening_design(6).coded;
  const Matrix values = noisy(2.0 * x.col(3), 3, 0.5, 9);
  const auto result = screen(x, letters(6), {"angle"}, {values}, {.method = Method::fit_dsd});
  const auto direct = fit_definitive_screening(x, values.col(1), letters(6));
  ASSERT_TRUE(result.responses[0].models[1].two_stage.has_value());
  EXPECT_EQ(result.responses[0].models[1].two_stage->stage1_sigma, direct.stage1_sigma);
  EXPECT_FALSE(screen(x, letters(6), {"angle"}, {values}).responses[0].models[0].two_stage);
}

TEST(Screening, DiagnosesItsFinalModels) {
  const Matrix x = definitive_screening_design(6).coded;
  Matrix values = noisy(2.0 * x.col(3) + x.col(1), 3, 0.5, 9);
  values(4, 1) = std::nan("");
  const auto result = screen(x, letters(6), {"angle"}, {values});
  const FinalModel& model = result.responses[0].models[1];
  ASSERT_EQ(model.runs.size(), static_cast<std::size_t>(x.rows() - 1));
  EXPECT_EQ(std::count(model.runs.begin(), model.runs.end(), 4), 0);
  const Matrix used = x(model.runs, Eigen::all);
  const Vector y = values.col(1)(model.runs);
  EXPECT_EQ(model.diagnostics.press, diagnose_regression(model_matrix(used, model.terms), y).press);
  EXPECT_NEAR(result.responses[0].run_means(4), 0.5 * (values(4, 0) + values(4, 2)), 1e-14);
  EXPECT_EQ(result.responses[0].signal.alpha, signal_to_repetition(values).alpha);
}

TEST(Screening, RefusesInputThatDoesNotFit) {
  const Matrix x = definitive_screening_design(5).coded;
  const Matrix y = noisy(x.col(1), 2, 1.0, 8);
  EXPECT_THROW(screen(x, letters(4), {"y"}, {y}), InputError);
  EXPECT_THROW(screen(x, letters(5), {"y", "z"}, {y}), InputError);
  EXPECT_THROW(screen(x, letters(5), {"y", "z"}, {y, y.leftCols(1)}), InputError);
  EXPECT_THROW(screen(x, letters(5), {"y"}, {y.topRows(4)}), InputError);
  EXPECT_THROW(screen(x, letters(5), {"y"}, {y}, {.alpha = 1.0}), InputError);
  Matrix infinite = y;
  infinite(0, 0) = INFINITY;
  EXPECT_THROW(screen(x, letters(5), {"y"}, {infinite}), InputError);
}

}  // namespace
}  // namespace repose::doe

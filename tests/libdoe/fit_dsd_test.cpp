// The two-stage analysis against the numbers of an independent program.
#include "repose/doe/fit_dsd.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "csv.hpp"
#include "expected.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"

namespace repose::doe {
namespace {

using test::expect_relative;

std::set<std::string> names_of(const std::vector<Term>& terms,
                               const std::vector<std::string>& factors) {
  std::set<std::string> names;
  for (const Term& term : terms) names.insert(term_name(term, factors));
  return names;
}

std::set<std::string> names_of(const nlohmann::json& terms) {
  std::set<std::string> names;
  for (const auto& term : terms) names.insert(test::our_name(term));
  return names;
}

class TwoStageAnalysis : public testing::TestWithParam<const char*> {};

TEST_P(TwoStageAnalysis, GivesTheNumbersOfAnIndependentProgram) {
  const test::Case example = test::read_case(GetParam());
  const auto& factors = example.factors;
  const FitDsdResult result = fit_definitive_screening(example.coded, example.y, factors);
  const auto expected = test::read_expected("dsd_fit_expected.json").at(GetParam())["result"];

  EXPECT_EQ(result.pairs, expected["m"].get<int>());
  EXPECT_EQ(result.centre_runs, expected["n_centre"].get<int>());
  EXPECT_EQ(result.fake_df, expected["df_fake"].get<int>());
  expect_relative(result.fake_ss, expected["ss_fake"]);
  expect_relative(result.alpha, expected["alpha1"]);
  for (std::size_t j = 0; j < factors.size(); ++j) {
    SCOPED_TRACE(factors[j]);
    const auto i = static_cast<Eigen::Index>(j);
    // Small coefficients are differences of responses of order one printed to 4 decimals.
    EXPECT_NEAR(result.main_effects(i), expected["b"][factors[j]].get<double>(), 1e-14);
    expect_relative(result.t(i), expected["t"][factors[j]]);
    expect_relative(result.p(i), expected["p"][factors[j]]);
  }
  std::set<std::string> active;
  for (std::size_t j = 0; j < result.active.size(); ++j) {
    const std::string& name = factors[static_cast<std::size_t>(result.active[j])];
    active.insert(name);
    const auto i = static_cast<Eigen::Index>(j);
    expect_relative(result.active_t(i), expected["stage1_terms"][name][2]);
    expect_relative(result.active_p(i), expected["stage1_terms"][name][3]);
  }
  EXPECT_EQ(active, names_of(expected["active"]));
  expect_relative(result.stage1_sigma, expected["stage1_rmse"]);
  EXPECT_EQ(result.stage1_df, expected["stage1_df"].get<int>());

  expect_relative(result.second_ss, expected["ss_second"]);
  EXPECT_EQ(result.second_df, expected["df_second"].get<int>());
  expect_relative(result.second_f, expected["F_second"]);
  expect_relative(result.second_p, expected["p_second"]);
  ASSERT_EQ(result.steps.size(), expected["steps"].size());
  for (std::size_t i = 0; i < result.steps.size(); ++i) {
    const FitDsdResult::Step& step = result.steps[i];
    EXPECT_TRUE(step.exhaustive);
    EXPECT_EQ(names_of(step.terms, factors), names_of(expected["steps"][i][1]));
    expect_relative(step.residual_ss, expected["steps"][i][2]);
    expect_relative(step.f, expected["steps"][i][3]);
    expect_relative(step.p, expected["steps"][i][4]);
  }
  EXPECT_EQ(names_of(result.second_order, factors), names_of(expected["second"]));

  test::expect_estimates(result.fit, expected["combined"]);
  expect_relative(result.fit.sigma, expected["combined_rmse"]);
  expect_relative(result.fit.r_squared, expected["combined_r2"]);
  EXPECT_EQ(result.fit.residual_df, expected["combined_df"].get<int>());
}

INSTANTIATE_TEST_SUITE_P(Cases, TwoStageAnalysis,
                         testing::Values("A_6factor_2fake", "C_15factor_37run_B2"));

Vector noise(Eigen::Index n, double sigma, std::uint64_t seed) {
  RandomStream random(seed);
  Vector values(n);
  for (double& value : values) value = sigma * random.normal();
  return values;
}

const std::vector<std::string> kSixNames{"a", "b", "c", "d", "e", "f"};

TEST(FitDsd, FindsClearEffectsWithoutFakeFactors) {
  const Matrix x = definitive_screening_design(6, {.fake_factors = 0}).coded;
  const Vector y = 5.0 * x.col(0) - 4.0 * x.col(3) + 6.0 * x.col(0).cwiseProduct(x.col(3)) +
                   noise(x.rows(), 0.1, 3);
  const FitDsdResult result = fit_definitive_screening(x, y, kSixNames);
  EXPECT_EQ(result.fake_df + result.centre_df, 0);
  EXPECT_TRUE(std::isnan(result.p(0)));
  const auto active = [&](int f) {
    return std::find(result.active.begin(), result.active.end(), f) != result.active.end();
  };
  EXPECT_TRUE(active(0) && active(3));
  EXPECT_LT(result.active.size(), 6u);
  EXPECT_TRUE(names_of(result.second_order, kSixNames).count("a*d"));
}

TEST(FitDsd, UsesReplicatedCentreRunsAsPureError) {
  const Matrix x = definitive_screening_design(6, {.centre_runs = 3}).coded;
  const Vector y = 2.0 * x.col(1) + noise(x.rows(), 1.0, 5);
  const FitDsdResult result = fit_definitive_screening(x, y, kSixNames);
  double mean = 0.0, ss = 0.0;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (x.row(i).isZero(0.0)) mean += y(i) / 3.0;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (x.row(i).isZero(0.0)) ss += (y(i) - mean) * (y(i) - mean);
  EXPECT_EQ(result.centre_df, 2);
  EXPECT_NEAR(result.centre_ss, ss, 1e-12);
  EXPECT_EQ(result.second_df, 8);  // eight pairs' means and the centre's, less the overall mean
}

TEST(FitDsd, LeavesOutARunWhoseMirrorImageFailed) {
  const Matrix x = definitive_screening_design(6, {.run_order = RunOrder::structured}).coded;
  const Vector y = 3.0 * x.col(2) + noise(x.rows(), 0.5, 7);
  const Eigen::Index n = x.rows();
  const FitDsdResult one_missing =
      fit_definitive_screening(x.bottomRows(n - 1), y.tail(n - 1), kSixNames);
  const FitDsdResult pair_missing =
      fit_definitive_screening(x.bottomRows(n - 2), y.tail(n - 2), kSixNames);
  EXPECT_EQ(one_missing.pairs, 7);
  EXPECT_EQ(one_missing.main_effects, pair_missing.main_effects);
  EXPECT_EQ(one_missing.fit.coefficients, pair_missing.fit.coefficients);
}

TEST(FitDsd, FallsBackToGreedySearchBeyondItsBudgetAndSaysSo) {
  const test::Case example = test::read_case("A_6factor_2fake");
  const FitDsdResult result =
      fit_definitive_screening(example.coded, example.y, example.factors, {.subset_budget = 20.0});
  ASSERT_GE(result.steps.size(), 3u);
  EXPECT_TRUE(result.steps[0].exhaustive);               // 15 subsets of one
  EXPECT_FALSE(result.steps[1].exhaustive);              // 105 of two
  for (std::size_t i = 1; i < result.steps.size(); ++i)  // greedy subsets contain each other
    for (const Term& term : result.steps[i - 1].terms)
      EXPECT_NE(std::find(result.steps[i].terms.begin(), result.steps[i].terms.end(), term),
                result.steps[i].terms.end());
}

TEST(FitDsd, WeakHeredityAdmitsInteractionsOfOneActiveFactor) {
  const Matrix x = definitive_screening_design(6).coded;
  const Vector y =
      5.0 * x.col(0) + 5.0 * x.col(0).cwiseProduct(x.col(1)) + noise(x.rows(), 0.05, 2);
  const FitDsdResult strong = fit_definitive_screening(x, y, kSixNames);
  const FitDsdResult weak = fit_definitive_screening(x, y, kSixNames, {.heredity = Heredity::weak});
  EXPECT_FALSE(names_of(strong.second_order, kSixNames).count("a*b"));
  EXPECT_TRUE(names_of(weak.second_order, kSixNames).count("a*b"));
}

TEST(FitDsd, RefusesADesignWithoutEnoughPairs) {
  const Matrix d1 = test::read_csv("dsd_12_factors_coded.csv").numbers(1, 12);
  try {
    fit_definitive_screening(d1, Vector::LinSpaced(29, 0.0, 1.0),
                             std::vector<std::string>(12, "x"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("need at least 12 pairs"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace repose::doe

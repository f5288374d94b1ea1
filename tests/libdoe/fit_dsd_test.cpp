// The two-stage analysis against the numbers of an independent program.
#include "repose/doe/fit_dsd.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
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
    EXPECT_TRUE(step.exact);
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

TEST(FitDsd, KeepsTheBestSubsetMetWhenTheBudgetRunsOutAndSaysSo) {
  const test::Case example = test::read_case("A_6factor_2fake");
  const FitDsdResult exact = fit_definitive_screening(example.coded, example.y, example.factors);
  const FitDsdResult cut =
      fit_definitive_screening(example.coded, example.y, example.factors, {.search_budget = 1});
  ASSERT_GE(cut.steps.size(), 3u);
  EXPECT_TRUE(cut.steps[0].exact);  // one node shows the best single term
  EXPECT_FALSE(cut.steps[1].exact);
  for (std::size_t i = 0; i < std::min(cut.steps.size(), exact.steps.size()); ++i)
    EXPECT_GE(cut.steps[i].residual_ss, exact.steps[i].residual_ss * (1.0 - 1e-12));
}

/// What the best `size` of the terms leave of y, by fitting all subsets.
double least_residual(const Matrix& x, const Vector& y, const std::vector<Term>& terms,
                      std::size_t size, std::vector<Term> chosen = {}, std::size_t from = 0) {
  if (chosen.size() == size) return fit_least_squares(model_matrix(x, chosen), y).residual_ss;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t next = from; next < terms.size(); ++next) {
    chosen.push_back(terms[next]);
    try {
      least = std::min(least, least_residual(x, y, terms, size, chosen, next + 1));
    } catch (const InputError&) {  // linearly dependent
    }
    chosen.pop_back();
  }
  return least;
}

TEST(FitDsd, BranchAndBoundFindsTheBestOfAllSubsets) {
  // Even in all factors, so that stage 2 sees y itself; main effects make five factors active.
  for (const std::uint64_t seed : {11u, 12u, 13u, 14u}) {
    const Matrix x = definitive_screening_design(6, {.seed = seed}).coded;
    const Vector even = x.col(0).cwiseProduct(x.col(1)) + x.col(2).cwiseAbs2() -
                        x.col(3).cwiseProduct(x.col(4)) + 0.7 * x.col(1).cwiseProduct(x.col(3));
    Vector y = 9.0 * (x.col(0) + x.col(1) + x.col(2) + x.col(3) + x.col(4)) + 3.0 * even;
    y += noise(x.rows(), 0.2, seed);
    const FitDsdResult result =
        fit_definitive_screening(x, y, kSixNames, {.alpha_second = 0.999, .most_second_order = 4});
    ASSERT_EQ(result.active.size(), 5u);
    // The even part is orthogonal to main effects: fits of the mean of y(x) and y(-x).
    Vector mean = y;
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      for (Eigen::Index j = 0; j < x.rows(); ++j)
        if ((x.row(i) + x.row(j)).isZero(0.0)) mean(i) = 0.5 * (y(i) + y(j));
    std::vector<Term> candidates;
    for (const Term& term : candidate_terms(5, CandidateTerms::main_and_second_order))
      if (term.kind != Term::Kind::main_effect) candidates.push_back(term);
    ASSERT_GE(result.steps.size(), 3u);
    for (std::size_t size = 1; size <= result.steps.size(); ++size) {
      const FitDsdResult::Step& step = result.steps[size - 1];
      EXPECT_TRUE(step.exact);
      const double expected = least_residual(x, mean, candidates, size);
      EXPECT_NEAR(step.residual_ss, expected, 1e-10 * expected) << size << " terms";
    }
  }
}

TEST(FitDsd, WeakHeredityAdmitsInteractionsOfOneActiveFactor) {
  const Matrix x = definitive_screening_design(6).coded;
  const Vector y =
      5.0 * x.col(0) + 5.0 * x.col(0).cwiseProduct(x.col(1)) + noise(x.rows(), 0.05, 2);
  const FitDsdResult strong = fit_definitive_screening(x, y, kSixNames);
  const FitDsdResult weak =
      fit_definitive_screening(x, y, kSixNames, {.interactions = Heredity::weak});
  EXPECT_FALSE(names_of(strong.second_order, kSixNames).count("a*b"));
  EXPECT_TRUE(names_of(weak.second_order, kSixNames).count("a*b"));
}

TEST(FitDsd, QuadraticsHaveTheirOwnHeredity) {
  const Matrix x = definitive_screening_design(6).coded;
  const Vector y = 5.0 * x.col(0) + 5.0 * x.col(1).cwiseAbs2() + noise(x.rows(), 0.05, 2);
  const FitDsdResult strong = fit_definitive_screening(x, y, kSixNames);
  const FitDsdResult none =
      fit_definitive_screening(x, y, kSixNames, {.quadratics = Heredity::none});
  EXPECT_FALSE(names_of(strong.second_order, kSixNames).count("b^2"));
  EXPECT_TRUE(names_of(none.second_order, kSixNames).count("b^2"));
}

TEST(FitDsd, BlocksAreInEveryModelAndNotInTheError) {
  const Matrix x =
      definitive_screening_design(6, {.centre_runs = 2, .run_order = RunOrder::structured}).coded;
  const auto half = (x.rows() - 2) / 4;  // pairs in the first block; one centre run in each
  std::vector<int> blocks(static_cast<std::size_t>(x.rows()), 2);
  int pairs = 0, centres = 0;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    for (Eigen::Index j = i; j < x.rows(); ++j)
      if ((x.row(i) + x.row(j)).isZero(0.0) && !x.row(i).isZero(0.0) && pairs++ < half)
        blocks[static_cast<std::size_t>(i)] = blocks[static_cast<std::size_t>(j)] = 1;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (x.row(i).isZero(0.0) && centres++ == 0) blocks[static_cast<std::size_t>(i)] = 1;
  Vector y = 3.0 * x.col(0) + 2.0 * x.col(4) + 4.0 * x.col(0).cwiseProduct(x.col(4)) +
             noise(x.rows(), 0.1, 4);
  const FitDsdResult without = fit_definitive_screening(x, y, kSixNames, {}, blocks);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (blocks[static_cast<std::size_t>(i)] == 2) y(i) += 50.0;
  const FitDsdResult result = fit_definitive_screening(x, y, kSixNames, {}, blocks);
  // A block of its own level changes nothing but that level.
  EXPECT_EQ(names_of(result.second_order, kSixNames), (std::set<std::string>{"a*e"}));
  EXPECT_EQ(result.second_order, without.second_order);
  EXPECT_NEAR(result.second_ss, without.second_ss, 1e-9 * result.second_ss);
  EXPECT_NEAR(result.fit.sigma, without.fit.sigma, 1e-9 * result.fit.sigma);
  EXPECT_EQ(result.second_df, 8);  // eight pairs and two centres, less two blocks
  EXPECT_EQ(result.centre_df, 0);  // the centre runs stand in different blocks
  EXPECT_EQ(result.fit.names.back(), "block 2");
  EXPECT_NEAR(result.fit.coefficients.tail(1)(0) - without.fit.coefficients.tail(1)(0), 50.0, 1e-9);

  std::swap(blocks[0], blocks[1]);
  blocks[0] = blocks[0] == 1 ? 2 : 1;
  EXPECT_THROW(fit_definitive_screening(x, y, kSixNames, {}, blocks), InputError);
}

TEST(FitDsd, RefusesThresholdsAndBudgetsThatCannotBe) {
  const Matrix x = definitive_screening_design(6).coded;
  const Vector y = x.col(0) + noise(x.rows(), 1.0, 1);
  EXPECT_THROW(fit_definitive_screening(x, y, kSixNames, {.alpha_second = 1.0}), InputError);
  EXPECT_THROW(fit_definitive_screening(x, y, kSixNames, {.search_budget = 0}), InputError);
  EXPECT_THROW(fit_definitive_screening(x, y, kSixNames, {}, {1, 2}), InputError);
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

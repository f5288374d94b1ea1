// Stepwise regression against the paths of an independent program.
#include "repose/doe/stepwise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "csv.hpp"
#include "expected.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/regression_diagnostics.hpp"

namespace repose::doe {
namespace {

using test::our_name;

std::string step_text(const StepwiseStep& step, const std::vector<std::string>& factors) {
  std::string text = step.action == StepwiseStep::Action::enter ? "enter " : "leave ";
  for (const Term& term : step.entered_with) text += term_name(term, factors) + " ";
  return text + term_name(step.term, factors);
}

/// The same of an expected step, e.g. ["enter", "X1+X3+X1*X3", p], with main effects in sorted
/// order.
std::string expected_text(const nlohmann::json& step, const std::vector<std::string>& factors) {
  std::vector<std::string> names(1);
  for (const char c : step[1].get<std::string>()) {
    if (c == '+')
      names.emplace_back();
    else
      names.back() += c;
  }
  std::string text = step[0].get<std::string>() + " ";
  for (const std::string& factor : factors)
    for (std::size_t i = 0; i + 1 < names.size(); ++i)
      if (names[i] == factor) text += factor + " ";
  return text + our_name(names.back());
}

struct RuleCase {
  const char* data;
  const char* key;
  HierarchyRule rule;
};

class StepwisePath : public testing::TestWithParam<RuleCase> {};

TEST_P(StepwisePath, AndFinalModelAreThoseOfAnIndependentProgram) {
  const auto [data, key, rule] = GetParam();
  const test::Case example = test::read_case(data);
  const auto candidates = candidate_terms(static_cast<int>(example.factors.size()),
                                          CandidateTerms::main_and_second_order);
  const StepwiseResult result =
      stepwise_regression(example.coded, example.y, example.factors, candidates, {.rule = rule});
  const auto expected =
      test::read_expected("dsd_stepwise_expected.json").at(std::string(data) + "/" + key);
  ASSERT_EQ(result.path.size(), expected["history"].size());
  for (std::size_t i = 0; i < result.path.size(); ++i) {
    EXPECT_EQ(step_text(result.path[i], example.factors),
              expected_text(expected["history"][i], example.factors));
    test::expect_relative(result.path[i].p, expected["history"][i][2]);
  }
  test::expect_estimates(result.fit, expected["estimates"]);
  test::expect_relative(result.fit.sigma, expected["rmse"]);
  test::expect_relative(result.fit.r_squared, expected["r2"]);
  EXPECT_EQ(result.fit.residual_df, expected["df_error"].get<int>());
  EXPECT_EQ(result.anova.size(), result.terms.size());
  EXPECT_EQ(result.termination, StepwiseResult::Termination::no_candidate);
}

constexpr const char* kSix = "A_6factor_2fake";
constexpr const char* kFifteen = "C_15factor_37run_B2";
INSTANTIATE_TEST_SUITE_P(Rules, StepwisePath,
                         testing::Values(RuleCase{kSix, "combine14", HierarchyRule::combine},
                                         RuleCase{kSix, "combine13", HierarchyRule::combine_joint},
                                         RuleCase{kSix, "none", HierarchyRule::none},
                                         RuleCase{kFifteen, "combine14", HierarchyRule::combine},
                                         RuleCase{kFifteen, "combine13",
                                                  HierarchyRule::combine_joint},
                                         RuleCase{kFifteen, "none", HierarchyRule::none}),
                         [](const auto& parameter) {
                           return std::string(parameter.param.data).substr(0, 1) +
                                  parameter.param.key;
                         });

TEST(Stepwise, UnderRestrictNoTermStandsWithoutItsMainEffects) {
  const test::Case example = test::read_case(kFifteen);
  const auto candidates = candidate_terms(15, CandidateTerms::main_and_second_order);
  const StepwiseResult result = stepwise_regression(example.coded, example.y, example.factors,
                                                    candidates, {.rule = HierarchyRule::restrict});
  EXPECT_GT(result.terms.size(), 4u);
  for (const StepwiseStep& step : result.path) EXPECT_TRUE(step.entered_with.empty());
  for (const Term& term : result.terms)
    for (const Term& precedent : precedents(term))
      EXPECT_NE(std::find(result.terms.begin(), result.terms.end(), precedent), result.terms.end());
}

TEST(Stepwise, BackwardEqualsDroppingTheLargestPUntilAllAreBelowTheThreshold) {
  const test::Case example = test::read_case(kFifteen);
  std::vector<Term> terms = candidate_terms(15, CandidateTerms::main_effects);
  const StepwiseResult result =
      stepwise_regression(example.coded, example.y, example.factors, terms,
                          {.direction = StepDirection::backward, .p_leave = 0.05});
  while (true) {  // the slow twin
    const LeastSquaresFit fit = fit_least_squares(model_matrix(example.coded, terms), example.y);
    Eigen::Index worst = 0;
    if (fit.p.tail(fit.p.size() - 1).maxCoeff(&worst) <= 0.05) break;
    terms.erase(terms.begin() + worst);
  }
  EXPECT_EQ(result.terms, terms);
  EXPECT_EQ(result.path.size(), 15u - terms.size());
}

/// The criterion of a model by fitting it.
double criterion_of(const test::Case& example, const std::vector<Term>& terms, StoppingRule rule) {
  const LeastSquaresFit fit = fit_least_squares(model_matrix(example.coded, terms), example.y);
  const InformationCriteria criteria = information_criteria(
      fit.residual_ss, static_cast<int>(example.y.size()), static_cast<int>(terms.size()) + 1);
  return rule == StoppingRule::bic ? criteria.bic : criteria.aicc;
}

class StepwiseCriterion : public testing::TestWithParam<StoppingRule> {};

TEST_P(StepwiseCriterion, ForwardTakesTheBestModelOfTheGreedyPath) {
  const test::Case example = test::read_case(kFifteen);
  const auto candidates = candidate_terms(15, CandidateTerms::main_effects);
  const StepwiseResult result =
      stepwise_regression(example.coded, example.y, example.factors, candidates,
                          {.stop = GetParam(), .direction = StepDirection::forward});
  std::vector<Term> terms, best;  // the slow twin
  double least = criterion_of(example, terms, GetParam());
  while (terms.size() < candidates.size()) {
    std::vector<Term> next;
    double next_value = std::numeric_limits<double>::infinity();
    for (const Term& candidate : candidates) {
      if (std::find(terms.begin(), terms.end(), candidate) != terms.end()) continue;
      std::vector<Term> trial = terms;
      trial.push_back(candidate);
      const double value = criterion_of(example, trial, GetParam());
      if (value < next_value) {
        next_value = value;
        next = trial;
      }
    }
    terms = next;
    const StepwiseStep& step = result.path.at(terms.size() - 1);
    EXPECT_EQ(step.term, terms.back());
    EXPECT_NEAR(GetParam() == StoppingRule::bic ? step.bic : step.aicc, next_value, 1e-9);
    if (next_value < least) {
      least = next_value;
      best = terms;
    }
  }
  EXPECT_EQ(result.terms, best);
  EXPECT_EQ(result.chosen, best.size());
  EXPECT_EQ(result.path.size(), candidates.size());
}

TEST_P(StepwiseCriterion, MixedEndsWhereNoSingleStepImproves) {
  const test::Case example = test::read_case(kFifteen);
  const auto candidates = candidate_terms(15, CandidateTerms::main_and_second_order);
  const StepwiseResult result =
      stepwise_regression(example.coded, example.y, example.factors, candidates,
                          {.stop = GetParam(), .rule = HierarchyRule::none});
  const double here = criterion_of(example, result.terms, GetParam());
  ASSERT_FALSE(result.terms.empty());
  for (const Term& candidate : candidates) {
    std::vector<Term> other = result.terms;
    const auto at = std::find(other.begin(), other.end(), candidate);
    if (at == other.end())
      other.push_back(candidate);
    else
      other.erase(at);
    EXPECT_GE(criterion_of(example, other, GetParam()), here - 1e-9);
  }
}

TEST_P(StepwiseCriterion, BackwardIsNeverWorseThanAllCandidates) {
  const test::Case example = test::read_case(kFifteen);
  const auto candidates = candidate_terms(15, CandidateTerms::main_effects);
  const StepwiseResult result =
      stepwise_regression(example.coded, example.y, example.factors, candidates,
                          {.stop = GetParam(), .direction = StepDirection::backward});
  for (const StepwiseStep& step : result.path) EXPECT_EQ(step.action, StepwiseStep::Action::leave);
  EXPECT_EQ(result.path.size(), candidates.size());
  EXPECT_LE(criterion_of(example, result.terms, GetParam()),
            criterion_of(example, candidates, GetParam()) + 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Criteria, StepwiseCriterion,
                         testing::Values(StoppingRule::aicc, StoppingRule::bic),
                         [](const auto& parameter) {
                           return parameter.param == StoppingRule::bic ? "Bic" : "Aicc";
                         });

TEST(Stepwise, KeepsBlocksInEveryModel) {
  const Matrix coded = definitive_screening_design(6).coded;
  std::vector<int> blocks;
  Vector y = coded.col(1);
  for (Eigen::Index i = 0; i < coded.rows(); ++i) {
    blocks.push_back(static_cast<int>(i % 2));
    y(i) += 100.0 * blocks.back() + 0.05 * std::sin(7.0 * static_cast<double>(i));
  }
  const std::vector<std::string> factors{"a", "b", "c", "d", "e", "f"};
  const auto terms = candidate_terms(6, CandidateTerms::main_effects);
  const StepwiseResult with = stepwise_regression(coded, y, factors, terms, {}, blocks);
  EXPECT_EQ(with.fit.names.back(), "block 1");
  EXPECT_NEAR(with.fit.coefficients.tail(1)(0), 100.0, 0.1);
  EXPECT_EQ(with.terms.front(), main_effect(1));
  EXPECT_TRUE(stepwise_regression(coded, y, factors, terms).terms.empty());
}

TEST(Stepwise, BackwardNeedsAResidualToBeginWith) {
  const Matrix coded = definitive_screening_design(6).coded;
  try {
    stepwise_regression(coded, coded.col(0), {"a", "b", "c", "d", "e", "f"},
                        candidate_terms(6, CandidateTerms::main_and_second_order),
                        {.direction = StepDirection::backward});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("all 28 columns, and 17 runs"), std::string::npos)
        << error.what();
  }
}

TEST(Stepwise, ForwardNeverRemoves) {
  const test::Case example = test::read_case(kFifteen);
  const auto candidates = candidate_terms(15, CandidateTerms::main_and_second_order);
  const StepwiseResult result = stepwise_regression(
      example.coded, example.y, example.factors, candidates,
      {.direction = StepDirection::forward, .rule = HierarchyRule::combine_joint});
  for (const StepwiseStep& step : result.path) EXPECT_EQ(step.action, StepwiseStep::Action::enter);
}

TEST(Stepwise, FindsAnExactModelAndStops) {
  const Matrix coded = definitive_screening_design(6).coded;
  const std::vector<std::string> factors{"a", "b", "c", "d", "e", "f"};
  const Vector y = 3.0 + 2.0 * coded.col(1).array() - coded.col(4).array() * coded.col(1).array() +
                   4.0 * coded.col(4).array();
  const StepwiseResult result = stepwise_regression(
      coded, y, factors, candidate_terms(6, CandidateTerms::main_and_second_order), {});
  EXPECT_EQ(result.termination, StepwiseResult::Termination::exact_fit);
  ASSERT_EQ(result.terms.size(), 3u);
  EXPECT_LT(result.fit.sigma, 1e-13);
}

TEST(Stepwise, OfAConstantResponseHasNoTerms) {
  const Matrix coded = definitive_screening_design(3).coded;
  const StepwiseResult result =
      stepwise_regression(coded, Vector::Constant(coded.rows(), 0.1), {"a", "b", "c"},
                          candidate_terms(3, CandidateTerms::main_and_second_order), {});
  EXPECT_TRUE(result.terms.empty());
}

TEST(Stepwise, BackwardLeavesNothingOfAConstantAndOnlyTheTruthOfAnExactResponse) {
  const Matrix coded = definitive_screening_design(6).coded;
  const std::vector<std::string> factors{"a", "b", "c", "d", "e", "f"};
  const auto terms = candidate_terms(6, CandidateTerms::main_effects);
  for (const auto stop : {StoppingRule::p_value, StoppingRule::aicc, StoppingRule::bic}) {
    const StepwiseOptions options{.stop = stop, .direction = StepDirection::backward};
    for (const double value : {0.0, 5.0, 0.1})
      EXPECT_TRUE(
          stepwise_regression(coded, Vector::Constant(coded.rows(), value), factors, terms, options)
              .terms.empty())
          << value;
    const Vector exact = 41.3 + 2.1 * coded.col(1).array() - 0.7 * coded.col(4).array();
    const StepwiseResult result = stepwise_regression(coded, exact, factors, terms, options);
    EXPECT_EQ(result.terms, (std::vector<Term>{main_effect(1), main_effect(4)}));
    EXPECT_EQ(result.termination, StepwiseResult::Termination::exact_fit);
  }
}

TEST(Stepwise, RefusesWhatItCannotAnalyse) {
  const Matrix coded = definitive_screening_design(3).coded;
  const Vector y = Vector::LinSpaced(coded.rows(), 0.0, 1.0);
  const auto terms = candidate_terms(3, CandidateTerms::main_effects);
  EXPECT_THROW(stepwise_regression(coded, y, {"a", "b"}, terms), InputError);
  EXPECT_THROW(stepwise_regression(coded, y.head(4), {"a", "b", "c"}, terms), InputError);
  EXPECT_THROW(stepwise_regression(coded, y, {"a", "b", "c"}, {}), InputError);
  EXPECT_THROW(stepwise_regression(coded, y, {"a", "b", "c"}, {main_effect(3)}), InputError);
  EXPECT_THROW(stepwise_regression(coded, y, {"a", "b", "c"}, terms, {.p_enter = 0.0}), InputError);
}

}  // namespace
}  // namespace repose::doe

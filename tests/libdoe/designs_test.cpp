// Conference matrices and definitive screening designs, in integers.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "repose/base/error.hpp"
#include "repose/doe/design_check.hpp"
#include "repose/doe/designs.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {
namespace {

using Eigen::MatrixXi;

TEST(ConferenceMatrix, HasZeroDiagonalSignsElsewhereAndOrthogonalRowsForEveryOrder) {
  const std::set<int> do_not_exist{22, 34, 58};
  for (int n = 4; n <= 64; n += 2) {
    if (do_not_exist.count(n)) continue;
    const MatrixXi c = conference_matrix(n);
    ASSERT_EQ(c.rows(), n);
    const MatrixXi identity = MatrixXi::Identity(n, n);
    EXPECT_EQ(c.cwiseAbs(), MatrixXi::Ones(n, n) - identity) << n;
    EXPECT_EQ(c * c.transpose(), (n - 1) * identity) << n;
    EXPECT_EQ(c.transpose() * c, (n - 1) * identity) << n;
  }
}

TEST(ConferenceMatrix, IsBuiltOrRefusedForEveryOrderUpTo128) {
  int built = 0;
  for (int n = 66; n <= 128; n += 2) {
    try {
      const MatrixXi c = conference_matrix(n);
      EXPECT_EQ(c * c.transpose(), (n - 1) * MatrixXi::Identity(n, n)) << n;
      EXPECT_EQ(conference_order(n - 1), n);
      ++built;
    } catch (const InputError&) {
      EXPECT_GT(conference_order(n), n);
    }
  }
  // One above the 17 odd prime powers 67 ... 127, and twice 36, 40, 44, 48, 52, 56, 60 where that
  // is no such order.
  EXPECT_GE(built, 17);
}

TEST(ConferenceMatrix, IsSkewForMultiplesOfFourAndSymmetricOtherwise) {
  for (const int n : {4, 8, 12, 16, 20, 24, 28, 32, 36, 40, 52, 56, 64}) {
    const MatrixXi c = conference_matrix(n);
    EXPECT_EQ(c.bottomRightCorner(n - 1, n - 1).transpose(), -c.bottomRightCorner(n - 1, n - 1))
        << n;
  }
  for (const int n : {6, 10, 14, 18, 26, 30, 46, 50}) {
    const MatrixXi c = conference_matrix(n);
    EXPECT_EQ(c.transpose(), c) << n;
  }
}

std::string message_of_order(int order) {
  try {
    conference_matrix(order);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ConferenceMatrix, RefusesImpossibleOrdersAndNamesTheNextOne) {
  EXPECT_NE(message_of_order(22).find("22 does not exist, because 21"), std::string::npos);
  EXPECT_NE(message_of_order(22).find("is 24"), std::string::npos);
  EXPECT_NE(message_of_order(66).find("66 is not built here; the next one that is, is 68"),
            std::string::npos);
  for (const int order : {-4, 0, 2, 5, 130})
    EXPECT_THROW(conference_matrix(order), InputError) << order;
}

/// Column sums 0, main effects orthogonal to each other and to all second-order effects, in
/// integers.
void expect_definitive(const Matrix& coded, int runs, int order) {
  const MatrixXi x = coded.cast<int>();
  ASSERT_EQ(x.cast<double>(), coded);
  const int k = static_cast<int>(x.cols());
  EXPECT_EQ(x.rows(), runs);
  EXPECT_TRUE((x.colwise().sum().array() == 0).all());
  EXPECT_EQ(x.transpose() * x, 2 * (order - 1) * MatrixXi::Identity(k, k));
  for (const Term& term : candidate_terms(k, CandidateTerms::main_and_second_order)) {
    if (term.kind == Term::Kind::main_effect) continue;
    const Eigen::VectorXi column = term_column(coded, term).cast<int>();
    EXPECT_TRUE(((x.transpose() * column).array() == 0).all());
  }
}

int expected_order(int factors, int fake) {
  int order = std::max(6, factors + factors % 2 + fake);
  while (order == 22 || order == 34 || order == 58) order += 2;
  return order;
}

TEST(DefinitiveScreeningDesign, SeparatesMainEffectsFromEachOtherAndFromSecondOrderOnes) {
  for (int factors = 3; factors <= 50; ++factors)
    for (const int fake : {0, 2}) {
      SCOPED_TRACE(testing::Message() << factors << " factors, " << fake << " fake");
      const int order = expected_order(factors, fake);
      for (const int centre : {1, 3})
        expect_definitive(
            definitive_screening_design(factors, {.fake_factors = fake, .centre_runs = centre})
                .coded,
            2 * order + centre, order);
    }
}

TEST(DefinitiveScreeningDesign, PassesTheCheckOfDesigns) {
  for (int factors = 3; factors <= 15; ++factors)
    for (const int fake : {0, 2}) {
      const DesignCheck check = check_design(
          definitive_screening_design(factors, {.fake_factors = fake, .centre_runs = 2}).coded);
      EXPECT_TRUE(check.is_definitive_screening());
      EXPECT_TRUE(check.is_orthogonal());
      EXPECT_EQ(check.alias_max, 0.0);
      EXPECT_EQ(static_cast<int>(check.pairs.size()), expected_order(factors, fake));
      EXPECT_EQ(check.centre_runs.size(), 2u);
      EXPECT_TRUE(check.two_level_factors.empty());
    }
}

TEST(DefinitiveScreeningDesign, KeepsPairsInOneBlockAndBlocksOrthogonalToMainEffects) {
  using BlockCentres = DefinitiveScreeningOptions::BlockCentres;
  for (const int factors : {3, 6, 12, 15, 21, 50})
    for (const int blocks : {2, 3, factors})
      for (const auto centres : {BlockCentres::each_block, BlockCentres::first_block})
        for (const bool two_level : {false, true}) {
          SCOPED_TRACE(testing::Message() << factors << " factors, " << blocks << " blocks");
          DefinitiveScreeningOptions options{.blocks = blocks, .block_centres = centres};
          if (two_level) options.two_level_factors = {0, factors - 1};
          const Design design = definitive_screening_design(factors, options);
          Matrix sums = Matrix::Zero(blocks, factors);
          std::vector<int> runs(static_cast<std::size_t>(blocks), 0);
          std::vector<int> centre_runs = runs;
          std::map<int, std::set<int>> blocks_of_pair;
          for (std::size_t i = 0; i < design.block.size(); ++i) {
            const auto block = static_cast<std::size_t>(design.block[i] - 1);
            sums.row(design.block[i] - 1) += design.coded.row(static_cast<Eigen::Index>(i));
            ++runs.at(block);
            if (design.pair_id[i] == 0) ++centre_runs[block];
            if (design.pair_id[i] > 0) blocks_of_pair[design.pair_id[i]].insert(design.block[i]);
          }
          EXPECT_TRUE(sums.isZero(0.0));
          for (const auto& [pair, of] : blocks_of_pair) EXPECT_EQ(of.size(), 1u);
          const int per_set = two_level ? 2 : 1;
          for (std::size_t b = 0; b < runs.size(); ++b)
            EXPECT_EQ(centre_runs[b], b == 0 || centres == BlockCentres::each_block ? per_set : 0);
          const auto [least, most] = std::minmax_element(runs.begin(), runs.end());
          EXPECT_LE(*most - *least, 2 + per_set);
          EXPECT_TRUE(std::is_sorted(design.block.begin(), design.block.end()));
        }
}

TEST(DefinitiveScreeningDesign, FoldsTwoLevelFactorsOverWithSmallInnerProducts) {
  for (int factors = 3; factors <= 24; ++factors)
    for (int two_level = 1; two_level <= std::min(6, factors - 1); ++two_level) {
      SCOPED_TRACE(testing::Message() << factors << " factors, " << two_level << " two-level");
      DefinitiveScreeningOptions options{};
      for (int j = 0; j < two_level; ++j)
        options.two_level_factors.push_back(factors - 1 - j);  // any columns
      const MatrixXi x = definitive_screening_design(factors, options).coded.cast<int>();
      const int order = expected_order(factors, 2);
      EXPECT_EQ(x.rows(), 2 * order + 2);
      EXPECT_TRUE((x.rightCols(two_level).array().abs() == 1).all());
      EXPECT_TRUE((x.colwise().sum().array() == 0).all());
      for (const Term& term : candidate_terms(factors, CandidateTerms::main_and_second_order)) {
        if (term.kind == Term::Kind::main_effect) continue;
        const Eigen::VectorXi column = term_column(x.cast<double>(), term).cast<int>();
        EXPECT_TRUE(((x.transpose() * column).array() == 0).all());
      }
      MatrixXi gram = x.transpose() * x;
      EXPECT_TRUE((gram.topLeftCorner(factors - two_level, factors - two_level) -
                   2 * (order - 1) * MatrixXi::Identity(factors - two_level, factors - two_level))
                      .isZero());
      gram.diagonal().setZero();
      EXPECT_LE(gram.topRightCorner(factors - two_level, two_level).cwiseAbs().maxCoeff(), 2);
      EXPECT_LE(gram.cwiseAbs().maxCoeff(), 6);  // the bound of any choice of signs
      const DesignCheck check = check_design(x.cast<double>());
      EXPECT_TRUE(check.is_definitive_screening());
      EXPECT_EQ(static_cast<int>(check.two_level_factors.size()), two_level);
      // Where one factor alone has a middle, the pair of its zeros are centre runs as well.
      EXPECT_EQ(check.centre_runs.size(), factors - two_level == 1 ? 4u : 2u);
    }
}

TEST(DefinitiveScreeningDesign, KeepsTwoLevelFactorsOrthogonalIfAsked) {
  using Rule = DefinitiveScreeningOptions::TwoLevelRule;
  for (int factors = 3; factors <= 24; ++factors)
    for (int two_level = 1; two_level <= std::min(4, factors - 1); ++two_level) {
      DefinitiveScreeningOptions options{.two_level_rule = Rule::orthogonal};
      for (int j = 0; j < two_level; ++j) options.two_level_factors.push_back(j);
      const MatrixXi x = definitive_screening_design(factors, options).coded.cast<int>();
      EXPECT_EQ(x.rows(), 2 * expected_order(factors, 2) + 4);
      EXPECT_TRUE((x.colwise().sum().array() == 0).all());
      const MatrixXi gram = x.transpose() * x;
      const MatrixXi diagonal = gram.diagonal().asDiagonal();
      EXPECT_EQ(gram, diagonal) << factors << ' ' << two_level;
      int worst = 0;
      for (const Term& term : candidate_terms(factors, CandidateTerms::main_and_second_order)) {
        if (term.kind != Term::Kind::interaction) continue;
        const Eigen::VectorXi column = term_column(x.cast<double>(), term).cast<int>();
        worst = std::max(worst, (x.transpose() * column).cwiseAbs().maxCoeff());
      }
      // Pairs give 2 for each two-level factor of the three, centre runs 2 if all three are.
      EXPECT_LE(worst, two_level >= 3 ? 8 : 4);
    }
}

TEST(DefinitiveScreeningDesign, HasTheRunCountsOfTheLiterature) {
  EXPECT_EQ(definitive_screening_design(6, {.fake_factors = 0}).coded.rows(),
            13);  // 2k + 1, even k
  EXPECT_EQ(definitive_screening_design(7, {.fake_factors = 0}).coded.rows(), 17);  // 2k + 3, odd k
  EXPECT_EQ(definitive_screening_design(12).coded.rows(), 29);                      // Table D.1
  EXPECT_EQ(definitive_screening_design(15).coded.rows(), 37);                      // Table B.2
  EXPECT_EQ(definitive_screening_design(21, {.fake_factors = 0}).coded.rows(), 49);  // no C(22)
}

TEST(DefinitiveScreeningDesign, NumbersPairsAndCentreRunsInAnyOrder) {
  const Design design = definitive_screening_design(7, {.centre_runs = 2, .seed = 5});
  for (std::size_t i = 0; i < design.pair_id.size(); ++i) {
    const auto row = design.coded.row(static_cast<Eigen::Index>(i));
    if (design.pair_id[i] == 0) {
      EXPECT_TRUE(row.isZero(0.0));
    } else {
      int partners = 0;
      for (std::size_t j = 0; j < design.pair_id.size(); ++j)
        if (j != i && design.pair_id[j] == design.pair_id[i]) {
          ++partners;
          EXPECT_EQ(row, -design.coded.row(static_cast<Eigen::Index>(j)));
        }
      EXPECT_EQ(partners, 1);
    }
  }
}

TEST(DefinitiveScreeningDesign, HasOneOrderForOneSeedAndAnotherForAnother) {
  const Design one = definitive_screening_design(8, {.seed = 7});
  EXPECT_EQ(one.coded, definitive_screening_design(8, {.seed = 7}).coded);
  EXPECT_NE(one.coded, definitive_screening_design(8, {.seed = 8}).coded);
  const Design structured = definitive_screening_design(8, {.run_order = RunOrder::structured});
  EXPECT_EQ(structured.pair_id.front(), 1);
  EXPECT_EQ(structured.pair_id.back(), 0);
}

TEST(DefinitiveScreeningDesign, RefusesOptionsOutOfRange) {
  EXPECT_THROW(definitive_screening_design(2), InputError);
  EXPECT_THROW(definitive_screening_design(101), InputError);
  EXPECT_THROW(definitive_screening_design(6, {.fake_factors = -1}), InputError);
  EXPECT_THROW(definitive_screening_design(6, {.centre_runs = 0}), InputError);
  EXPECT_THROW(definitive_screening_design(6, {.blocks = 7}), InputError);
  EXPECT_THROW(definitive_screening_design(6, {.two_level_factors = {6}}), InputError);
  EXPECT_THROW(definitive_screening_design(6, {.two_level_factors = {1, 1}}), InputError);
  EXPECT_THROW(definitive_screening_design(3, {.two_level_factors = {0, 1, 2}}), InputError);
  using Rule = DefinitiveScreeningOptions::TwoLevelRule;
  EXPECT_THROW(definitive_screening_design(
                   9, {.two_level_factors = {0, 1, 2, 3, 4}, .two_level_rule = Rule::orthogonal}),
               InputError);
  EXPECT_THROW(definitive_screening_design(
                   9, {.two_level_factors = {0}, .two_level_rule = Rule::orthogonal, .blocks = 2}),
               InputError);
}

}  // namespace
}  // namespace repose::doe

// Conference matrices and definitive screening designs, in integers.
#include <gtest/gtest.h>

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
  for (int factors = 3; factors <= 15; ++factors)
    for (const int fake : {0, 2})
      for (const int centre : {1, 3}) {
        SCOPED_TRACE(testing::Message() << factors << " factors, " << fake << " fake, " << centre);
        const Design design =
            definitive_screening_design(factors, {.fake_factors = fake, .centre_runs = centre});
        const int order = expected_order(factors, fake);
        expect_definitive(design.coded, 2 * order + centre, order);
        const DesignCheck check = check_design(design.coded);
        EXPECT_TRUE(check.is_definitive_screening());
        EXPECT_TRUE(check.is_orthogonal());
        EXPECT_EQ(check.alias_max, 0.0);
        EXPECT_EQ(static_cast<int>(check.pairs.size()), order);
        EXPECT_EQ(static_cast<int>(check.centre_runs.size()), centre);
      }
}

TEST(DefinitiveScreeningDesign, KeepsItsPropertiesForManyFactors) {
  for (const int factors : {16, 21, 22, 25, 33, 35, 39, 45, 50}) {
    SCOPED_TRACE(factors);
    const int order = expected_order(factors, 2);
    expect_definitive(definitive_screening_design(factors).coded, 2 * order + 1, order);
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
}

}  // namespace
}  // namespace repose::doe

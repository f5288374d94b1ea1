// Factorial designs: published fractions, exhaustive twins, orthogonality in integers.
#include "repose/doe/factorial.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <set>

#include "repose/base/error.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {
namespace {

using Eigen::MatrixXi;

TEST(FullFactorial, HasEveryCombinationOnce) {
  const Matrix x = full_factorial({2, 3, 4});
  ASSERT_EQ(x.rows(), 24);
  std::set<std::vector<double>> runs;
  for (Eigen::Index i = 0; i < 24; ++i) runs.insert({x(i, 0), x(i, 1), x(i, 2)});
  EXPECT_EQ(runs.size(), 24u);
  EXPECT_EQ(std::set<double>(x.col(1).begin(), x.col(1).end()), (std::set<double>{-1, 0, 1}));
  EXPECT_DOUBLE_EQ(x(6, 2), -1.0 / 3.0);
  EXPECT_THROW(full_factorial({2, 1}), InputError);
  EXPECT_THROW(full_factorial({}), InputError);
  EXPECT_THROW(full_factorial(std::vector<int>(21, 2)), InputError);
}

/// The defining relation found without generators: products of columns that are constant.
std::set<FactorProduct> constant_products(const Matrix& coded) {
  std::set<FactorProduct> found;
  for (FactorProduct p = 1; p < FactorProduct{1} << coded.cols(); ++p) {
    Vector product = Vector::Ones(coded.rows());
    for (Eigen::Index j = 0; j < coded.cols(); ++j)
      if ((p >> j & 1U) != 0) product.array() *= coded.col(j).array();
    if (std::abs(product.sum()) == static_cast<double>(coded.rows())) found.insert(p);
  }
  return found;
}

TEST(FractionalFactorial, HasTheDefiningRelationOfItsColumns) {
  const auto design = fractional_factorial(7, {"E=ABC", "F=BCD", "G=ACD"});
  EXPECT_EQ(design.coded.rows(), 16);
  EXPECT_EQ(design.resolution, 4);
  EXPECT_EQ(design.defining_relation.size(), 7u);
  EXPECT_EQ(
      constant_products(design.coded),
      std::set<FactorProduct>(design.defining_relation.begin(), design.defining_relation.end()));
  std::vector<std::string> words;
  for (const auto word : design.defining_relation) words.push_back(product_name(word));
  EXPECT_EQ(words,
            (std::vector<std::string>{"ABCE", "ABFG", "ACDG", "ADEF", "BCDF", "BDEG", "CEFG"}));
  const MatrixXi x = design.coded.cast<int>();
  EXPECT_EQ(x.transpose() * x, 16 * MatrixXi::Identity(7, 7));
  EXPECT_FALSE(design.is_minimum_aberration);  // nobody asked
}

TEST(FractionalFactorial, RefusesGeneratorsThatMeanNothing) {
  for (const std::vector<std::string>& generators : {std::vector<std::string>{"E=AB", "E=AC"},
                                                     {"E=AB", "F=AB"},
                                                     {"E=AB"},
                                                     {"F=AG", "E=AB"},
                                                     {"E=A", "F=AB"},
                                                     {"EF=AB", "F=AC"},
                                                     {"E", "F=AB"},
                                                     {"E=AIB", "F=AB"},
                                                     {"E=AAB", "F=AB"},
                                                     {"E=EF", "F=AB"},
                                                     {"A=BC", "F=AB"}}) {
    EXPECT_THROW(fractional_factorial(generators.size() == 1 ? 4 : 6, generators), InputError)
        << generators.front();
  }
  EXPECT_THROW(fractional_factorial(0, {}), InputError);
  EXPECT_THROW(fractional_factorial(26, {}), InputError);
  EXPECT_THROW(fractional_factorial(20, {}), InputError);
}

struct Published {
  int factors, runs;
  std::vector<int> pattern;  ///< numbers of words of length 3, 4, ...
};

TEST(MinimumAberration, HasTheWordLengthPatternsOfTheCatalogue) {
  // [ChenSunWu1993], the first design of each table; trailing lengths left out are 0.
  const std::vector<Published> catalogue{
      {4, 8, {0, 1}},
      {5, 8, {2, 1}},
      {6, 8, {4, 3}},
      {7, 8, {7, 7, 0, 0, 1}},
      {5, 16, {0, 0, 1}},
      {6, 16, {0, 3}},
      {7, 16, {0, 7}},
      {8, 16, {0, 14, 0, 0, 0, 1}},
      {9, 16, {4, 14, 8, 0, 4, 1}},
      {10, 16, {8, 18, 16, 8, 8, 5}},
      {11, 16, {12, 26, 28, 24, 20, 13, 4}},
      {12, 16, {16, 39, 48, 48, 48, 39, 16, 0, 0, 1}},
      {15, 16, {35, 105, 168, 280, 435, 435, 280, 168, 105, 35, 0, 0, 1}},
      {6, 32, {0, 0, 0, 1}},
      {7, 32, {0, 1, 2}},
      {8, 32, {0, 3, 4}},
      {9, 32, {0, 6, 8, 0, 0, 1}},
      {10, 32, {0, 10, 16, 0, 0, 5}},
      {11, 32, {0, 25, 0, 27, 0, 10, 0, 1}},
      {12, 32, {0, 38, 0, 52, 0, 33, 0, 4}},
      {13, 32, {0, 55, 0, 96, 0, 87, 0, 16, 0, 1}},
      {16, 32, {0, 140, 0, 448, 0, 870, 0, 448, 0, 140, 0, 0, 0, 1}},
      {7, 64, {0, 0, 0, 0, 1}},
      {8, 64, {0, 0, 2, 1}},
      {9, 64, {0, 1, 4, 2}},
      {10, 64, {0, 2, 8, 4, 0, 1}},
      {11, 64, {0, 4, 14, 8, 0, 3, 2}},
      {12, 64, {0, 6, 24, 16, 0, 9, 8}},
      {9, 128, {0, 0, 0, 3}},
      {10, 128, {0, 0, 3, 3, 1}},
      {11, 128, {0, 0, 6, 6, 2, 1}},
  };
  for (const auto& [factors, runs, published] : catalogue) {
    const auto design = minimum_aberration(factors, runs);
    auto pattern = design.word_length_pattern();
    pattern.erase(pattern.begin(), pattern.begin() + 3);
    auto expected = published;
    expected.resize(pattern.size(), 0);
    EXPECT_EQ(pattern, expected) << factors << " factors, " << runs << " runs";
    EXPECT_TRUE(design.is_minimum_aberration) << factors << " factors, " << runs << " runs";
    const MatrixXi x = design.coded.cast<int>();
    EXPECT_EQ(x.transpose() * x, runs * MatrixXi::Identity(factors, factors));
  }
}

TEST(MinimumAberration, IsThatOfAnExhaustiveSearchWithoutSymmetries) {
  for (int factors = 5; factors <= 8; ++factors) {
    std::vector<FactorProduct> products;
    for (FactorProduct p = 3; p < 16; ++p)
      if (std::popcount(p) >= 2) products.push_back(p);
    std::vector<int> best;
    for (unsigned set = 0; set < 1U << products.size(); ++set) {
      if (std::popcount(set) != factors - 4) continue;
      std::vector<std::string> generators;
      for (std::size_t i = 0; i < products.size(); ++i)
        if ((set >> i & 1U) != 0)
          generators.push_back(product_name(FactorProduct{1} << (4 + generators.size())) + "=" +
                               product_name(products[i]));
      const auto pattern = fractional_factorial(factors, generators).word_length_pattern();
      if (best.empty() || pattern < best) best = pattern;
    }
    EXPECT_EQ(minimum_aberration(factors, 16).word_length_pattern(), best) << factors;
  }
}

TEST(MinimumAberration, SaysWhenTheSearchEndedEarly) {
  const auto design = minimum_aberration(15, 64, 1000);
  EXPECT_FALSE(design.is_minimum_aberration);
  EXPECT_GE(design.resolution, 4);
  EXPECT_EQ(design.coded.cols(), 15);
  EXPECT_TRUE(minimum_aberration(5, 32).is_minimum_aberration);
  EXPECT_EQ(minimum_aberration(5, 32).resolution, 0);
  for (const int runs : {0, 3, 6, 131072}) EXPECT_THROW(minimum_aberration(5, runs), InputError);
  EXPECT_THROW(minimum_aberration(8, 8), InputError);
  EXPECT_THROW(minimum_aberration(3, 16), InputError);
  EXPECT_THROW(minimum_aberration(7, 16, 0), InputError);
}

TEST(HadamardMatrix, ExistsForEveryMultipleOfFourUpToOneHundred) {
  for (int n = 1; n <= 100; n += n < 4 ? (n == 1 ? 1 : 2) : 4) {
    const MatrixXi h = hadamard_matrix(n);
    EXPECT_EQ(h * h.transpose(), n * MatrixXi::Identity(n, n)) << n;
    EXPECT_EQ(h.cwiseAbs(), MatrixXi::Ones(n, n));
    EXPECT_EQ(h.col(0), Eigen::VectorXi::Ones(n));
  }
  for (const int n : {-4, 0, 3, 6, 260}) EXPECT_THROW(hadamard_matrix(n), InputError);
}

TEST(PlackettBurman, IsOrthogonalAndFoldedOverClearOfInteractions) {
  for (int factors = 1; factors <= 99; ++factors) {
    const MatrixXi x = plackett_burman(factors).cast<int>();
    const auto runs = static_cast<int>(x.rows());
    EXPECT_EQ(runs, 4 * (factors / 4 + 1));
    EXPECT_EQ(x.transpose() * x, runs * MatrixXi::Identity(factors, factors));
    EXPECT_TRUE((x.colwise().sum().array() == 0).all());
  }
  const Matrix folded = plackett_burman(11, FoldOverRuns::appended);
  ASSERT_EQ(folded.rows(), 24);
  for (const Term& term : candidate_terms(11, CandidateTerms::main_and_second_order))
    if (term.kind == Term::Kind::interaction) {
      EXPECT_TRUE((folded.transpose() * term_column(folded, term)).isZero(0.0));
    }
  EXPECT_THROW(plackett_burman(0), InputError);
  EXPECT_THROW(plackett_burman(100), InputError);
}

}  // namespace
}  // namespace repose::doe

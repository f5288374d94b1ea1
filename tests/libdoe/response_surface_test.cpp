// Designs for quadratic models: the properties they are named for.
#include "repose/doe/response_surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <map>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/model_terms.hpp"

namespace repose::doe {
namespace {

using Kind = CentralCompositeOptions::Kind;
using Alpha = CentralCompositeOptions::Alpha;

Matrix quadratic_model(const Matrix& coded) {
  return model_matrix(coded, candidate_terms(static_cast<int>(coded.cols()),
                                             CandidateTerms::main_and_second_order));
}

/// x'(X'X)^-1 x at the rows of `at`.
Vector prediction_variance(const Matrix& design, const Matrix& at) {
  const Matrix x = quadratic_model(design), rows = quadratic_model(at);
  const Matrix inverse = (x.transpose() * x).inverse();
  return (rows * inverse).cwiseProduct(rows).rowwise().sum();
}

Matrix points_on_sphere(Eigen::Index points, Eigen::Index dimensions, double radius) {
  RandomStream random(3);
  Matrix x = Matrix::NullaryExpr(points, dimensions, [&] { return random.normal(); });
  x.rowwise().normalize();
  return radius * x;
}

TEST(CentralComposite, HasThePublishedRunsAndDistances) {
  // [BoxHunter1957]: 2^(1/2), 2^(3/4), 2, and from 5 factors on with fractions.
  const std::vector<std::pair<int, double>> published{
      {4, 1.414}, {8, 1.682}, {16, 2.0}, {16, 2.0}, {32, 2.378}, {64, 2.828}, {64, 2.828}};
  for (int k = 2; k <= 8; ++k) {
    const auto design = central_composite(k, {.kind = Kind::circumscribed, .centre_runs = 5});
    const auto [runs, alpha] = published[static_cast<std::size_t>(k - 2)];
    EXPECT_EQ(design.factorial_runs, runs) << k;
    EXPECT_EQ(design.coded.rows(), runs + 2 * k + 5);
    EXPECT_NEAR(design.alpha, alpha, 5e-4);
    EXPECT_EQ(design.coded.maxCoeff(), design.alpha);
  }
  EXPECT_EQ(central_composite(11).factorial_runs, 128);
}

TEST(CentralComposite, PredictsEquallyWellInAllDirectionsIfRotatable) {
  for (int k = 2; k <= 7; ++k) {
    const auto design = central_composite(k, {.kind = Kind::circumscribed});
    const Vector v = prediction_variance(design.coded, points_on_sphere(20, k, 1.3));
    EXPECT_LT(v.maxCoeff() - v.minCoeff(), 1e-12 * v.maxCoeff() * 1e2) << k;
    const Vector faces =
        prediction_variance(central_composite(k).coded, points_on_sphere(20, k, 1.3));
    EXPECT_GT(faces.maxCoeff() - faces.minCoeff(), 0.01) << k;  // face-centred ones do not
  }
}

TEST(CentralComposite, HasUncorrelatedQuadraticsIfOrthogonal) {
  for (int k = 2; k <= 7; ++k)
    for (const int centre_runs : {1, 4, 9}) {
      const auto design = central_composite(
          k, {.kind = Kind::circumscribed, .alpha = Alpha::orthogonal, .centre_runs = centre_runs});
      Matrix squares = design.coded.array().square();
      squares.rowwise() -= squares.colwise().mean().eval();
      Matrix gram = squares.transpose() * squares;
      gram.diagonal().setZero();
      EXPECT_LT(gram.cwiseAbs().maxCoeff(), 1e-12 * static_cast<double>(design.coded.rows()));
    }
  EXPECT_DOUBLE_EQ(
      central_composite(2,
                        {.kind = Kind::circumscribed, .alpha = Alpha::orthogonal, .centre_runs = 1})
          .alpha,
      1.0);
}

TEST(CentralComposite, StaysInTheRangesUnlessCircumscribed) {
  for (int k = 2; k <= 8; ++k) {
    const auto inscribed = central_composite(k, {.kind = Kind::inscribed});
    const auto outside = central_composite(k, {.kind = Kind::circumscribed});
    EXPECT_EQ(inscribed.coded.cwiseAbs().maxCoeff(), 1.0);
    EXPECT_TRUE((inscribed.alpha * inscribed.coded).isApprox(outside.coded, 1e-15));
    const auto faces = central_composite(k);
    EXPECT_EQ(faces.alpha, 1.0);
    for (const double level : faces.coded.reshaped()) EXPECT_EQ(level * level * level, level);
  }
}

TEST(CentralComposite, RefusesSizesOutOfRange) {
  EXPECT_THROW(central_composite(1), InputError);
  EXPECT_THROW(central_composite(12), InputError);
  EXPECT_THROW(central_composite(3, {.centre_runs = 0}), InputError);
}

TEST(BoxBehnken, HasThePublishedNumbersOfRuns) {
  const std::map<int, int> published{{3, 15},  {4, 27},   {5, 46},   {6, 54},  {7, 62},
                                     {9, 130}, {10, 170}, {11, 188}, {12, 204}};
  for (const auto& [k, runs] : published) EXPECT_EQ(box_behnken(k).rows(), runs) << k;
  EXPECT_EQ(box_behnken(3, 1).rows(), 13);
  for (const int k : {2, 8, 13}) EXPECT_THROW(box_behnken(k), InputError);
  EXPECT_THROW(box_behnken(3, 0), InputError);
}

TEST(BoxBehnken, SeparatesMainEffectsAndInteractionsAndFitsTheQuadraticModel) {
  for (const int k : {3, 4, 5, 6, 7, 9, 10, 11, 12}) {
    const Matrix coded = box_behnken(k);
    const Matrix gram = coded.transpose() * coded;
    // Every factor is varied equally often, and all runs but the centre lie on one sphere.
    EXPECT_TRUE(gram.isApprox(gram(0, 0) * Matrix::Identity(k, k), 0.0)) << k;
    const Vector radius = coded.rowwise().squaredNorm();
    for (const double r : radius) EXPECT_TRUE(r == 0.0 || r == radius[0]);
    for (const Term& term : candidate_terms(k, CandidateTerms::main_and_second_order))
      if (term.kind != Term::Kind::main_effect) {
        EXPECT_TRUE((coded.transpose() * term_column(coded, term)).isZero(0.0));
      }
    const Matrix x = quadratic_model(coded);
    EXPECT_EQ(Eigen::ColPivHouseholderQR<Matrix>(x).rank(), x.cols()) << k;
  }
}

TEST(BoxBehnken, IsRotatableForFourAndSevenFactors) {
  for (const int k : {4, 7}) {
    const Vector v = prediction_variance(box_behnken(k), points_on_sphere(20, k, 1.1));
    EXPECT_LT(v.maxCoeff() - v.minCoeff(), 1e-10 * v.maxCoeff());
  }
  const Vector v = prediction_variance(box_behnken(5), points_on_sphere(20, 5, 1.1));
  EXPECT_GT(v.maxCoeff() - v.minCoeff(), 1e-4);
}

}  // namespace
}  // namespace repose::doe

// Parts of transferred models: their coefficients and what they say of their doubt, against dense
// least squares and the law of total variance.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/linear_model.hpp"
#include "transfer_data.hpp"

namespace repose::surrogate {
namespace {

using enum TransferMethod;
using test::altered;
using test::bumps;
using test::sampled;
using Case = test::TransferCase;

Matrix queries() {
  return sampled(bumps, 20, 0.0, 3).x;
}

/// Of observations about the function, as the source has it.
double noise_of(const Regressor& source, const Matrix& x) {
  const Predictions p = source.predict_with_variances(x);
  return (p.observation_variance - p.function_variance).mean();
}

TEST(ShiftAndScale, HasTheVariancesOfLeastSquaresAndOfItsSource) {
  const Case c;
  const Matrix q = queries();
  const Eigen::Index n = c.target.rows();
  Matrix design(n, 2);
  design << Vector::Ones(n), c.model.model.predict(c.target.x);
  const Matrix inverse = (design.transpose() * design).inverse();
  const Vector coefficients = inverse * design.transpose() * c.target.y;
  const double residual =
      (c.target.y - design * coefficients).squaredNorm() / static_cast<double>(n - 2);
  const double noise = noise_of(c.model.model, c.target.x);
  ASSERT_GT(residual, noise);
  const Predictions source = c.model.model.predict_with_variances(q);
  const Predictions found = c.by(shift_and_scale).model.predict_with_variances(q);
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Vector at{{1.0, source.mean[i]}};
    const double function = residual * at.dot(inverse * at) + residual - noise +
                            coefficients[1] * coefficients[1] * source.function_variance[i];
    EXPECT_NEAR(found.mean[i], at.dot(coefficients), 1e-10);
    EXPECT_NEAR(found.function_variance[i], function, 1e-10);
    EXPECT_NEAR(found.observation_variance[i], function + noise, 1e-10);
  }
}

TEST(ShiftAndScale, IsNoSurerThanItsSourceOfATargetThatIsThisWithAShift) {
  for (const Eigen::Index rows : {1, 2, 3}) {
    Case c(altered, rows);
    c.target.y = c.model.model.predict(c.target.x).array() + 1.0;
    const Predictions source = c.model.model.predict_with_variances(queries());
    const Predictions found = c.by(shift_and_scale).model.predict_with_variances(queries());
    const double noise = noise_of(c.model.model, c.target.x);
    const Vector more = found.function_variance - source.function_variance;
    if (rows > 1)  // no residuals: the source's noise, over the rows
      EXPECT_LT((more.array() - noise / static_cast<double>(rows)).abs().maxCoeff(), 1e-10) << rows;
    else  // and without rows to spare, what the source's observations have
      EXPECT_GT(more.minCoeff(), noise);
    EXPECT_LT((found.observation_variance - found.function_variance).array().maxCoeff() - noise,
              1e-10);
  }
}

TEST(ShiftAndScale, DoesNotKnowItsVarianceFromOneRowAndASourceThatHasNone) {
  for (const char* source : {"linear-svm", "boosted-ensemble"}) {
    Case c(altered, 1);
    c.model = pretrained(source, c.source, 1);
    const Predictions one = c.by(shift_and_scale).model.predict_with_variances(queries());
    EXPECT_TRUE(one.mean.allFinite()) << source;
    EXPECT_TRUE(one.function_variance.array().isNaN().all()) << source;
    EXPECT_TRUE(one.observation_variance.array().isNaN().all()) << source;
    c.target = sampled(altered, 3, 0.05, 2);
    const Predictions three = c.by(shift_and_scale).model.predict_with_variances(queries());
    EXPECT_GT(three.observation_variance.minCoeff(), 0.0) << source;
  }
}

TEST(ShiftAndScale, TakesWeightsAsRepeats) {
  Case c(altered, 5), repeated = c;
  c.target.weights = Vector{{1.0, 2.0, 1.0, 3.0, 1.0}};
  const std::vector<Eigen::Index> rows{0, 1, 1, 2, 3, 3, 3, 4};
  repeated.target = selected_rows(repeated.target, rows);
  const Predictions a = c.by(shift_and_scale).model.predict_with_variances(queries());
  const Predictions b = repeated.by(shift_and_scale).model.predict_with_variances(queries());
  EXPECT_LT((a.mean - b.mean).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((a.function_variance - b.function_variance).cwiseAbs().maxCoeff(), 1e-10);
}

TEST(Transfer, RefusesWeightsWhereAProcessWouldIgnoreThem) {
  Case c;
  c.target.weights = Vector::Constant(8, 2.0);
  for (const TransferMethod method :
       {retrained, target_only, source_basis, coregionalised, weighted})
    EXPECT_THROW(c.by(method), InputError) << to_string(method);
  c.model = {LinearModel::fit(c.source), linear_model_trainer("linear")};
  const Transfer found = c.by(weighted);
  for (const TransferPart& part : found.parts)
    EXPECT_EQ(part.failure, "") << to_string(part.method);
  EXPECT_TRUE(std::isfinite(found.correlation));
}

TEST(SourceBasis, HasTheVariancesOfAProcessOnTheSourcesMeanAndOfTheSource) {
  const Case c;
  const GaussianProcess& source = *gaussian_process(c.model.model);
  const BasisFunctions mean{.names = {"source"}, .evaluate = [&source](const Vector& x) {
                              return Vector::Constant(1, source.predict(x).mean);
                            }};
  const auto target = GaussianProcess::fit(c.target.x, c.target.y, c.target.inputs,
                                           {.kernel = source.kernel(), .functions = mean});
  const double scale = target.coefficients()[1];
  const Matrix q = queries();
  const Predictions own = GaussianProcessRegressor(target).predict_with_variances(q);
  const Predictions of_source = GaussianProcessRegressor(source).predict_with_variances(q);
  const Predictions found = c.by(source_basis).model.predict_with_variances(q);
  const Vector added = scale * scale * of_source.function_variance;
  EXPECT_LT((found.mean - own.mean).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((found.function_variance - own.function_variance - added).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((found.observation_variance - own.observation_variance - added).cwiseAbs().maxCoeff(),
            1e-12);
}

TEST(Weighted, HasTheVariancesOfTheMixtureOfItsParts) {
  const Case c;
  const Matrix q = queries();
  const Transfer found = c.by(weighted);
  const Predictions mixture = found.model.predict_with_variances(q);
  Vector mean = Vector::Zero(q.rows()), function = mean, observation = mean;
  for (const TransferPart& part : found.parts)
    if (part.weight > 0.0) mean += part.weight * c.by(part.method).model.predict(q);
  for (const TransferPart& part : found.parts) {
    const Predictions p = c.by(part.method).model.predict_with_variances(q);
    const Vector off = (p.mean - mean).cwiseAbs2();
    function += part.weight * (p.function_variance + off);
    observation += part.weight * (p.observation_variance + off);
  }
  EXPECT_LT((mixture.mean - mean).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((mixture.function_variance - function).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((mixture.observation_variance - observation).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace repose::surrogate

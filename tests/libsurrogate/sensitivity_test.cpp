// Sobol' indices, partial dependence and joint draws against closed forms and dense algebra.
#include "repose/surrogate/sensitivity.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "gp_data.hpp"
#include "repose/base/error.hpp"
#include "repose/opt/composite.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::Sample;
using test::uniform_points;

/// sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 over [-pi, pi]^3 [Saltelli2008, p. 179 f.].
double ishigami(const Vector& x) {
  return std::sin(x[0]) + 7.0 * std::pow(std::sin(x[1]), 2) +
         0.1 * std::pow(x[2], 4) * std::sin(x[0]);
}

struct Ishigami {
  static constexpr double kPi = std::numbers::pi;
  static constexpr double kA = 7.0, kB = 0.1;
  double first1 = 0.5 * std::pow(1.0 + kB * std::pow(kPi, 4) / 5.0, 2);
  double second = kA * kA / 8.0;
  double both13 = kB * kB * std::pow(kPi, 8) * 8.0 / 225.0;
  double variance = first1 + second + both13;
};

GaussianProcess ishigami_model(Eigen::Index n) {
  const Matrix x = (2.0 * opt::scrambled_uniforms(n, 3, 5).array() - 1.0) * std::numbers::pi;
  const opt::Bounds box{Vector::Constant(3, -std::numbers::pi),
                        Vector::Constant(3, std::numbers::pi)};
  return GaussianProcess::fit(
      x, at_rows(x, ishigami), box,
      {.kernel = {Correlation::squared_exponential}, .noise = Noise::none, .starts = 2});
}

constexpr SensitivityOptions kFine{.points = 2048, .draws = 50};

/// From 250 points, Q2 = 0.995.
const std::vector<InputSensitivity>& ishigami_indices() {
  static const auto indices = sobol_indices(ishigami_model(250), kFine);
  return indices;
}

// 2048 points integrate to about 0.02 here, half the width of the bootstrap's intervals
TEST(SobolIndices, OfTheIshigamiFunctionAreThoseInClosedForm) {
  const Ishigami exact;
  const auto& s = ishigami_indices();
  const double first[] = {exact.first1 / exact.variance, exact.second / exact.variance, 0.0};
  const double total[] = {(exact.first1 + exact.both13) / exact.variance,
                          exact.second / exact.variance, exact.both13 / exact.variance};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(s[k].first.value, first[k], 0.03) << k;
    EXPECT_NEAR(s[k].total.value, total[k], 0.03) << k;
    EXPECT_TRUE(s[k].first.lower <= first[k] && first[k] <= s[k].first.upper) << k;
    EXPECT_TRUE(s[k].total.lower <= total[k] && total[k] <= s[k].total.upper) << k;
  }
}

TEST(SobolIndices, AndJointDrawsRepeatTheirBitsAndChangeWithTheSeed) {
  const auto model = ishigami_model(40);
  const SensitivityOptions options{.points = 64, .draws = 10, .seed = 3};
  const auto once = sobol_indices(model, options);
  const auto again = sobol_indices(model, options);
  const auto other = sobol_indices(model, {.points = 64, .draws = 10, .seed = 4});
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(once[k].first.value, again[k].first.value);
    EXPECT_EQ(once[k].total.lower, again[k].total.lower);
    EXPECT_NE(once[k].first.value, other[k].first.value);
  }
  const Matrix x = model.points().topRows(5);
  EXPECT_EQ(joint_sample(model, x, 4, 9), joint_sample(model, x, 4, 9));
}

TEST(SobolIndices, AreLessCertainWhereTheModelIs) {
  const auto little = sobol_indices(ishigami_model(30), kFine);
  const auto& much = ishigami_indices();
  EXPECT_GT(little[0].total.upper - little[0].total.lower,
            1.5 * (much[0].total.upper - much[0].total.lower));
}

TEST(SobolIndices, OfAPlaneAreTheSquaresOfItsSlopes) {
  const Matrix x = uniform_points(20, 2, 3);
  const Vector y = 3.0 * x.col(0) + 1.0 * x.col(1);
  const auto s =
      sobol_indices(GaussianProcess::fit(x, y, opt::unit_cube(2), {.basis = Basis::linear}),
                    {.points = 2048, .draws = 20});
  for (const auto& index : {s[0].first, s[0].total}) EXPECT_NEAR(index.value, 0.9, 0.01);
  for (const auto& index : {s[1].first, s[1].total}) EXPECT_NEAR(index.value, 0.1, 0.01);
}

TEST(SobolIndices, OfAConstantAreNotANumber) {
  const Matrix x = uniform_points(20, 2, 3);
  const auto gp = GaussianProcess::fit(x, Vector::Constant(20, 4.0), opt::unit_cube(2));
  EXPECT_TRUE(std::isnan(sobol_indices(gp)[0].first.value));
  EXPECT_THROW(sobol_indices(gp, {.points = 1}), InputError);
}

// sample moments of 4000 draws: within five standard errors
TEST(JointSample, HasTheMeanAndCovarianceOfThePosterior) {
  const Sample s;
  const auto gp =
      GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.basis = Basis::linear});
  const Matrix x = uniform_points(6, 3, 4);
  constexpr Eigen::Index kDraws = 4000;
  const Matrix f = joint_sample(gp, x, kDraws, 9);
  const Vector mean = f.rowwise().mean();
  const Matrix centred = f.colwise() - mean;
  const Matrix covariance = centred * centred.transpose() / double(kDraws - 1);
  const std::vector<Gaussian> p = gp.predict_rows(x);
  for (Eigen::Index i = 0; i < 6; ++i) {
    const Gaussian& g = p[std::size_t(i)];
    EXPECT_NEAR(mean[i], g.mean, 5.0 * g.standard_deviation() / std::sqrt(double(kDraws)));
    EXPECT_NEAR(covariance(i, i), g.variance, 5.0 * g.variance * std::sqrt(2.0 / kDraws));
    // given the first point's value, the variance elsewhere falls by covariance^2/variance
    const double told = gp.condition_on(x.row(0), p[0].mean).predict(x.row(i)).variance;
    const double noise = s.given.noise_variance;
    const double squared = (g.variance - told) * (p[0].variance + noise);
    const double error = 5.0 * std::sqrt(2.0 * g.variance * p[0].variance / kDraws);
    EXPECT_NEAR(std::abs(covariance(0, i)), std::sqrt(std::max(0.0, squared)), error);
  }
  EXPECT_EQ(f, joint_sample(gp, x, kDraws, 9));
}

TEST(JointSample, OfARoughFunctionKeepsItsVarianceBeyondTheColumnsKept) {
  const Sample s;
  const auto gp =
      GaussianProcess::with_parameters(s.x, s.y, s.cube, {Vector::Constant(3, 0.01), 1.0, 0.01},
                                       {.kernel = {Correlation::exponential}});
  const Matrix x = uniform_points(1200, 3, 4);
  const Matrix f = joint_sample(gp, x, 50, 9);
  const Vector mean = f.rowwise().mean();
  const double variance = (f.colwise() - mean).squaredNorm() / (49.0 * 1200.0);
  double expected = 0.0;
  for (const Gaussian& g : gp.predict_rows(x)) expected += g.variance / 1200.0;
  EXPECT_NEAR(variance, expected, 5.0 * expected * std::sqrt(2.0 / (49.0 * 1200.0)) + 0.02);
}

TEST(PartialDependence, IsTheAverageOfPredictions) {
  const Sample s;
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  const auto p = partial_dependence(gp, 1, {.points = 64, .grid = 5, .seed = 3});
  ASSERT_EQ(p.x, (std::vector<double>{0.0, 0.25, 0.5, 0.75, 1.0}));
  Matrix x = opt::scrambled_uniforms(64, 3, 3);
  x.col(1).setConstant(0.25);
  double mean = 0.0;
  for (const Gaussian& g : gp.predict_rows(x)) mean += g.mean / 64.0;
  EXPECT_NEAR(p.mean[1], mean, 1e-12);
  // an average of 64 draws at once has the variance that the interval tells
  const Vector averages = joint_sample(gp, x, 4000, 8).colwise().mean();
  const double sd =
      std::sqrt((averages.array() - averages.mean()).square().sum() / (averages.size() - 1.0));
  EXPECT_NEAR(p.upper[1] - p.mean[1], 1.959964 * sd, 5.0 * 1.96 * sd / std::sqrt(8000.0));
  EXPECT_NEAR(p.mean[1] - p.lower[1], p.upper[1] - p.mean[1], 1e-12);
  EXPECT_THROW(partial_dependence(gp, 3), InputError);
}

TEST(PartialDependence, OnACategoryHasAValueForEachLevel) {
  Matrix x = uniform_points(30, 2, 6);
  for (double& level : x.col(1)) level = std::floor(3.0 * level);
  const Vector y = (2.0 * x.col(1).array() + x.col(0).array()).exp();
  const auto gp = GaussianProcess::fit(x, y, {{}, {.levels = {"a", "b", "c"}}},
                                       {.response_scale = ResponseScale::log});
  const auto p = partial_dependence(gp, 1);
  ASSERT_EQ(p.x, (std::vector<double>{0.0, 1.0, 2.0}));
  for (std::size_t l = 0; l < 3; ++l)  // geometric mean over x in [0, 1]
    EXPECT_NEAR(p.mean[l], std::exp(2.0 * double(l) + 0.5), 0.05 * p.mean[l]);
}

}  // namespace
}  // namespace repose::surrogate

// The objective of a fit: its gradient, and the identity for repeats, against slow twins.
#include "likelihood.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <tuple>

#include "correlation.hpp"
#include "gp_data.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::smooth_function;
using test::uniform_points;

/// n different points, some of them repeated with noise.
std::pair<Matrix, Vector> noisy_repeats(Eigen::Index n, Eigen::Index repeats, Eigen::Index d) {
  Matrix x(n + repeats, d);
  x.topRows(n) = uniform_points(n, d, 11);
  for (Eigen::Index i = 0; i < repeats; ++i) x.row(n + i) = x.row(i % 5);
  Vector y = at_rows(x, smooth_function);
  RandomStream random(12);
  for (double& value : y) value += 0.1 * random.normal();
  return {x, y};
}

using GradientCase = std::tuple<Kernel, Noise, Basis, Estimator, Prior>;
class GradientOfEveryObjective : public testing::TestWithParam<GradientCase> {};

TEST_P(GradientOfEveryObjective, EqualsCentralDifferencesInOneToSixInputs) {
  GaussianProcessOptions options;
  std::tie(options.kernel, options.noise, options.basis, options.estimator, options.prior) =
      GetParam();
  for (Eigen::Index d = 1; d <= 6; ++d) {
    const auto [x, y] = noisy_repeats(14, options.noise == Noise::estimated ? 7 : 0, d);
    const Dataset data = make_dataset(x, y, opt::unit_cube(d), options.basis, options.noise);
    const NegativeLogPosterior objective(data, options);
    Vector p(objective.size());
    for (Eigen::Index k = 0; k < p.size(); ++k)
      p[k] = -3.0 + 0.4 * static_cast<double>(d) + 0.3 * static_cast<double>(k % 3);
    if (options.noise == Noise::estimated) p[d] = -3.0;
    Vector gradient(p.size());
    objective(p, &gradient);
    for (Eigen::Index k = 0; k < p.size(); ++k) {
      const double h = 1e-4;  // truncation h^4/30, rounding 1e-15 cond |f|/h: both below 1e-8
      const auto shifted = [&](double step) {
        Vector q = p;
        q[k] += step;
        return objective(q, nullptr);
      };
      const double difference =
          (8.0 * (shifted(h) - shifted(-h)) - (shifted(2 * h) - shifted(-2 * h))) / (12.0 * h);
      EXPECT_NEAR(gradient[k], difference, 1e-6 * std::max(1.0, std::abs(difference)))
          << "d = " << d << ", parameter " << k;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, GradientOfEveryObjective,
                         testing::Combine(testing::Values(Kernel::squared_exponential,
                                                          Kernel::matern52),
                                          testing::Values(Noise::none, Noise::estimated),
                                          testing::Values(Basis::none, Basis::constant),
                                          testing::Values(Estimator::ml, Estimator::reml),
                                          testing::Values(Prior::none, Prior::jointly_robust)));

/// -log likelihood of all observations one by one, [Rasmussen2006, Eqs. 2.30 and 2.45], dense
/// inverse.
double dense_negative_log_likelihood(const Matrix& x, const Vector& y, const Covariance& c,
                                     double amplitude, Estimator estimator) {
  const Eigen::Index n = x.rows();
  Matrix k = amplitude * cross_correlation(c.kernel, x, x, c.length_scales);
  k.diagonal().array() += amplitude * c.noise_ratio;
  const Matrix inverse = k.inverse();
  const Vector one = Vector::Ones(n);
  const double beta = one.dot(inverse * y) / one.dot(inverse * one);
  const Vector e = y - beta * one;
  double twice =
      e.dot(inverse * e) + std::log(k.determinant()) + double(n) * std::log(2 * std::numbers::pi);
  if (estimator == Estimator::reml)
    twice += std::log(one.dot(inverse * one)) - std::log(2 * std::numbers::pi);
  return 0.5 * twice;
}

TEST(Likelihood, OfAggregatedRepeatsEqualsThatOfAllObservations) {
  const auto [x, y] = noisy_repeats(12, 8, 2);
  const opt::Bounds cube = opt::unit_cube(2);
  const Hyperparameters given{Vector{{0.3, 0.7}}, 1.3, 0.05};
  for (const Estimator estimator : {Estimator::ml, Estimator::reml}) {
    const GaussianProcess gp =
        GaussianProcess::with_parameters(x, y, cube, given, {.estimator = estimator});
    const Covariance c{Kernel::matern52, given.length_scales,
                       given.noise_variance / given.process_variance};
    const double dense = dense_negative_log_likelihood(x, y, c, given.process_variance, estimator);
    // REML of one and the same trend column: sum of counts replaces a sum of ones, no constant
    // differs
    EXPECT_NEAR(gp.negative_log_likelihood(), dense, 1e-10 * std::abs(dense));
  }
}

TEST(Likelihood, ProfiledAmplitudeIsItsMinimum) {
  const auto [x, y] = noisy_repeats(15, 5, 3);
  for (const Estimator estimator : {Estimator::ml, Estimator::reml}) {
    const Dataset data = make_dataset(x, y, opt::unit_cube(3), Basis::constant, Noise::estimated);
    const Covariance c{Kernel::matern52, Vector{{0.5, 0.5, 1.0}}, 0.02};
    const Factor f = make_factor(data, c, Basis::constant);
    const double best = best_amplitude(data, f, c.noise_ratio, estimator);
    const auto value = [&](double amplitude) {
      return negative_log_likelihood(data, f, c.noise_ratio, amplitude, estimator);
    };
    EXPECT_LT(value(best), value(best * 1.001));
    EXPECT_LT(value(best), value(best * 0.999));
  }
}

TEST(Factorise, AddsTheLeastJitterThatHelpsAndSaysSo) {
  EXPECT_EQ(factorise(Matrix::Identity(3, 3))->jitter, 0.0);
  const std::optional<Cholesky> singular = factorise(Matrix::Ones(3, 3));
  ASSERT_TRUE(singular);
  EXPECT_EQ(singular->jitter, 1e-14);
  EXPECT_FALSE(factorise(Vector{{1.0, -1.0}}.asDiagonal().toDenseMatrix()));
}

TEST(LowerInverse, TimesItsMatrixIsTheIdentityAcrossBlocks) {
  for (const Eigen::Index n : {1, 5, 64, 65, 150}) {
    Matrix l = uniform_points(n, n, 3).triangularView<Eigen::Lower>();
    l.diagonal().array() += 5.0;
    const Matrix inverse = lower_inverse(l);
    EXPECT_LT((inverse * l - Matrix::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-13 * double(n));
    const Matrix product = inverse_from(inverse).triangularView<Eigen::Lower>();
    const Matrix expected = (inverse.transpose() * inverse).triangularView<Eigen::Lower>();
    EXPECT_LT((product - expected).cwiseAbs().maxCoeff(), 1e-14 * double(n));
  }
}

}  // namespace
}  // namespace repose::surrogate

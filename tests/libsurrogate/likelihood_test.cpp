// The objective of a fit: its gradient, and the identity for repeats, against slow twins.
#include "likelihood.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>
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

/// Inputs in the unit cube, the third of them (if any) a category of three exchangeable levels.
std::vector<Input> mixed_inputs(Eigen::Index d) {
  std::vector<Input> inputs(static_cast<std::size_t>(d));
  if (d >= 3) inputs[2].levels = {"sphere", "clump", "cube"};
  return inputs;
}

Matrix with_levels(Matrix x) {
  if (x.cols() >= 3) x.col(2) = (3.0 * x.col(2).array()).floor();
  return x;
}

/// Fourth-order central difference of the objective in one parameter: truncation h^4/30, rounding
/// 1e-15 cond |f|/h, both below 1e-8 here.
double difference(const NegativeLogPosterior& objective, const Vector& p, Eigen::Index k) {
  constexpr double kStep = 1e-4;
  const auto shifted = [&](double step) {
    Vector q = p;
    q[k] += step;
    return objective(q, nullptr);
  };
  return (8.0 * (shifted(kStep) - shifted(-kStep)) - (shifted(2 * kStep) - shifted(-2 * kStep))) /
         (12.0 * kStep);
}

void expect_gradient_of_differences(const GaussianProcessOptions& options, Amplitude amplitude,
                                    Eigen::Index d) {
  const bool noisy = options.noise != Noise::none;
  auto [x, y] = noisy_repeats(14, noisy ? 7 : 0, d);
  x = with_levels(x);
  GaussianProcessOptions o = options;
  if (o.noise == Noise::known)
    o.noise_variances = 0.01 * (1.0 + uniform_points(y.size(), 1, 3).col(0).array());
  const Dataset data = make_dataset(x, y, mixed_inputs(d), o);
  const NegativeLogPosterior objective(data, o, amplitude);
  Vector p(objective.size());
  for (Eigen::Index k = 0; k < p.size(); ++k)
    p[k] = -3.0 + 0.3 * static_cast<double>(d) + 0.3 * static_cast<double>(k % 3);
  if (objective.has_alpha()) p[objective.amplitude_parameter() - 1] = 0.3;
  if (objective.searches_amplitude()) p[objective.amplitude_parameter()] = 0.4;
  if (objective.estimates_noise()) p[objective.noise_parameter()] = -3.0;
  Vector gradient(p.size());
  const double value = objective(p, &gradient);
  EXPECT_EQ(value, objective(p, nullptr));
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    const double expected = difference(objective, p, k);
    EXPECT_NEAR(gradient[k], expected, 1e-6 * std::max(1.0, std::abs(expected)))
        << to_string(o.kernel) << ", " << to_string(o.estimator) << ", noise " << to_string(o.noise)
        << ", d = " << d << ", parameter " << k;
  }
}

class GradientOfTheObjective
    : public testing::TestWithParam<std::tuple<Estimator, Noise, Amplitude>> {};

TEST_P(GradientOfTheObjective, EqualsCentralDifferencesForTenKernelsInOneToTenInputs) {
  const auto [estimator, noise, amplitude] = GetParam();
  for (const Kernel kernel : all_kernels())
    for (Eigen::Index d = 1; d <= 10; ++d)
      expect_gradient_of_differences(
          {.kernel = kernel,
           .noise = noise,
           .basis = static_cast<Basis>(d % (noise == Noise::none ? 2 : 3)),
           .estimator = estimator,
           .prior = d % 2 == 0 ? Prior::jointly_robust : Prior::none},
          amplitude, d);
}

using Case = std::tuple<Estimator, Noise, Amplitude>;
INSTANTIATE_TEST_SUITE_P(
    All, GradientOfTheObjective,
    testing::Values(Case{Estimator::ml, Noise::estimated, Amplitude::profiled},
                    Case{Estimator::ml, Noise::none, Amplitude::searched},
                    Case{Estimator::reml, Noise::estimated, Amplitude::profiled},
                    Case{Estimator::reml, Noise::none, Amplitude::profiled},
                    Case{Estimator::reml, Noise::estimated, Amplitude::searched},
                    Case{Estimator::reml, Noise::known, Amplitude::searched},
                    Case{Estimator::loo, Noise::estimated, Amplitude::profiled},
                    Case{Estimator::loo, Noise::none, Amplitude::profiled},
                    Case{Estimator::loo, Noise::estimated, Amplitude::searched},
                    Case{Estimator::loo, Noise::by_point, Amplitude::searched}));

/// -log likelihood of all observations one by one, [Rasmussen2006, Eqs. 2.30 and 2.45], dense
/// inverse; covariance k and regression functions h of the rows.
double dense_negative_log_likelihood(const Matrix& k, const Matrix& h, const Vector& y,
                                     Estimator estimator) {
  const Matrix inverse = k.inverse();
  const Matrix normal = h.transpose() * inverse * h;
  const Vector e = y - h * normal.inverse() * (h.transpose() * (inverse * y));
  double twice = e.dot(inverse * e) + std::log(k.determinant()) +
                 double(y.size()) * std::log(2 * std::numbers::pi);
  if (estimator == Estimator::reml)
    twice += std::log(normal.determinant()) - double(h.cols()) * std::log(2 * std::numbers::pi);
  return 0.5 * twice;
}

TEST(Likelihood, OfAggregatedRepeatsEqualsThatOfAllObservations) {
  const auto [x, y] = noisy_repeats(12, 8, 2);
  const opt::Bounds cube = opt::unit_cube(2);
  const Hyperparameters given{Vector{{0.3, 0.7}}, 1.3, 0.05};
  const Vector known = 0.02 * (1.0 + 4.0 * uniform_points(20, 1, 3).col(0).array());
  Matrix k =
      1.3 * cross_correlation(
                {Correlation::matern52, 1.0, given.length_scales.array().square().inverse()}, x, x);
  Matrix h(20, 3);
  h << Vector::Ones(20), x;
  for (const Estimator estimator : {Estimator::ml, Estimator::reml})
    for (const bool is_known : {false, true}) {
      GaussianProcessOptions options{.basis = Basis::linear, .estimator = estimator};
      if (is_known) {
        options.noise = Noise::known;
        options.noise_variances = known;
      }
      const GaussianProcess gp = GaussianProcess::with_parameters(x, y, cube, given, options);
      Matrix all = k;
      all.diagonal() += is_known ? known : Vector::Constant(20, 0.05);
      const double dense = dense_negative_log_likelihood(all, h, y, estimator);
      EXPECT_NEAR(gp.negative_log_likelihood(), dense, 1e-10 * std::abs(dense));
    }
}

// what distinguishes the estimator: it is the sum of the log densities that brute force finds
TEST(Likelihood, TheLeaveOneOutObjectiveIsMinusTheLogDensityOfPointsLeftOut) {
  const auto [x, y] = noisy_repeats(12, 8, 2);
  GaussianProcessOptions options{
      .basis = Basis::linear, .estimator = Estimator::loo, .prior = Prior::none};
  const GaussianProcess gp = GaussianProcess::with_parameters(
      x, y, opt::unit_cube(2), {Vector{{0.3, 0.7}}, 1.3, 0.05}, options);
  const Dataset data = make_dataset(x, y, linear_inputs(opt::unit_cube(2)), options);
  const NegativeLogPosterior objective(data, options, Amplitude::searched);
  const double scale2 = data.scale * data.scale;
  const Vector p{{std::log(0.3), std::log(0.7), std::log(1.3 / scale2), std::log(0.05 / scale2)}};
  const double expected = -gp.leave_one_out().log_density - 20.0 * std::log(data.scale);
  EXPECT_NEAR(objective(p, nullptr), expected, 1e-10 * std::abs(expected));
}

TEST(Likelihood, ProfiledAmplitudeIsItsMinimum) {
  const auto [x, y] = noisy_repeats(15, 5, 3);
  for (const Estimator estimator : {Estimator::ml, Estimator::reml}) {
    const Dataset data = make_dataset(x, y, linear_inputs(opt::unit_cube(3)), {});
    const Covariance c{Correlation::matern52, Vector{{0.5, 0.5, 1.0}}, 0.02};
    const Factor f = make_factor(data, c);
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

// That hyper-parameters are estimates: its effect on predictions, against differences and closed
// forms, and the coverage of intervals that it is there for.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "gp_data.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using test::Sample;
using test::uniform_points;

using Options = GaussianProcessOptions;

/// What E should be with root = I: derivatives of the standardised mean at q in the log parameters
/// of the shape, by differences of second order, h^2 ~ 1e-8.
Vector differences_of_the_mean(const Sample& s, const Hyperparameters& given,
                               const Options& options, const Vector& q, double scale) {
  constexpr double kH = 1e-4;
  const bool has_alpha = options.kernel.correlation == Correlation::rational_quadratic;
  const Eigen::Index scales = given.length_scales.size();
  Vector d(scales + (has_alpha ? 2 : 1));
  for (Eigen::Index k = 0; k < d.size(); ++k) {
    const auto mean = [&](double step) {
      Hyperparameters moved = given;
      if (k < scales)
        moved.length_scales[k] *= std::exp(step);
      else if (k == scales && has_alpha)
        moved.alpha *= std::exp(step);
      else
        moved.noise_variance *= std::exp(step);
      return GaussianProcess::with_parameters(s.x, s.y, s.cube, moved, options).predict(q).mean;
    };
    d[k] = (mean(kH) - mean(-kH)) / (2.0 * kH * scale);
  }
  return d;
}

TEST(MeanSensitivity, EqualsDifferencesForEveryKernelAndBasisWithRepeats) {
  const Sample s;
  const Matrix q = uniform_points(3, 3, 44);
  for (const Kernel kernel : all_kernels())
    for (const Basis basis : {Basis::none, Basis::constant, Basis::quadratic}) {
      Hyperparameters given = s.given;
      if (kernel.length_scales == LengthScales::shared) given.length_scales = Vector{{0.7}};
      const Options options{.kernel = kernel, .basis = basis};
      const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, given, options);
      const ModelAccess::State& state = ModelAccess::state(gp);
      const Eigen::Index shape = shape_parameters(state.data, state.covariance);
      const MeanSensitivity sensitivity(state.data, state.covariance, state.factor,
                                        Matrix::Identity(shape, shape), 1.0);
      const Correlator correlator = state.covariance.correlator(state.data.encoding);
      const Matrix h = trend_matrix(state.data.trend, state.data.encoding, q, q);
      const Matrix e = sensitivity.at(state.data, correlator, state.factor.alpha, q, h,
                                      CrossCorrelation(correlator, state.data.x, q));
      for (Eigen::Index j = 0; j < q.rows(); ++j) {
        const Vector expected =
            differences_of_the_mean(s, given, options, q.row(j), state.data.scale);
        EXPECT_LT((e.col(j) - expected).cwiseAbs().maxCoeff(), 1e-6)
            << to_string(kernel) << ", " << to_string(basis);
      }
    }
}

/// One length scale, no noise: everything about the approximation is a number.
TEST(ParameterUncertainty, OfOneParameterIsTheCurvatureOfTheLogPosterior) {
  const Sample s(0);
  const Options options{.kernel = {Correlation::matern52, LengthScales::shared},
                        .noise = Noise::none};
  const auto gp = GaussianProcess::fit(s.x, s.y, s.cube, options);
  const ModelAccess::State& state = ModelAccess::state(gp);
  const NegativeLogPosterior objective(state.data, options);
  const Vector p = state.covariance.length_scales.array().log();
  constexpr double kH = 1e-3;
  const auto value = [&](double step) { return objective(Vector{{p[0] + step}}, nullptr); };
  const double curvature = (value(kH) - 2.0 * value(0.0) + value(-kH)) / (kH * kH);
  ASSERT_EQ(state.parameters.root.cols(), 1);
  ASSERT_EQ(state.parameters.root.rows(), 2);  // and the noise ratio, which is known to be 0
  EXPECT_EQ(state.parameters.root(1, 0), 0.0);
  // a forward difference over 1e-3 in a log parameter
  EXPECT_NEAR(std::pow(state.parameters.root(0, 0), -2), curvature + 0.25, 5e-3 * curvature);
  const double spent = curvature / (curvature + 0.25);
  EXPECT_NEAR(state.parameters.variance_factor, 29.0 / (29.0 - spent - 2.0), 1e-5);
}

TEST(ParameterUncertainty, AddsNothingWhereParametersAreGiven) {
  const Sample s;
  const Matrix q = uniform_points(4, 3, 45);
  Options options;
  const auto fitted = GaussianProcess::fit(s.x, s.y, s.cube, options);
  for (const FittedParameter& f : fitted.report().parameters)
    options.bounds.push_back({f.name, f.value, f.value});
  const auto held = GaussianProcess::fit(s.x, s.y, s.cube, options);
  options.parameter_uncertainty = ParameterUncertainty::ignored;
  const auto ignored = GaussianProcess::fit(s.x, s.y, s.cube, options);
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Gaussian with = held.predict(q.row(i));
    const Gaussian without = ignored.predict(q.row(i));
    EXPECT_EQ(with.mean, without.mean);
    EXPECT_EQ(with.variance, without.variance);
    const Gaussian uncertain = fitted.predict(q.row(i));
    EXPECT_NEAR(uncertain.mean, without.mean, 1e-9);
    EXPECT_GT(uncertain.variance, without.variance);
  }
}

TEST(ParameterUncertainty, IsPartOfCovariances) {
  const Sample s;
  const auto gp = GaussianProcess::fit(s.x, s.y, s.cube, {.basis = Basis::linear});
  const Matrix q = uniform_points(6, 3, 46);
  const Matrix c = gp.covariance(q, q);
  const std::vector<Gaussian> at = gp.predict_rows(q);
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    EXPECT_NEAR(c(i, i), at[std::size_t(i)].variance, 1e-12);
  EXPECT_EQ(Eigen::LLT<Matrix>(c).info(), Eigen::Success);
}

/// The parameters' posterior stays, the mean's dependence on them is that of all the data.
TEST(ParameterUncertainty, OfAConditionedModelFollowsTheNewPoint) {
  const Sample s;
  const Matrix q = uniform_points(3, 3, 47);
  const auto gp = GaussianProcess::fit(s.x, s.y, s.cube, {.basis = Basis::linear});
  for (const bool is_repeat : {false, true}) {
    const Vector added = is_repeat ? Vector(s.x.row(2)) : Vector{{0.31, 0.62, 0.13}};
    const auto told = gp.condition_on(added, 0.7);
    Sample longer = s;
    longer.x.conservativeResize(31, 3);
    longer.x.row(30) = added.transpose();
    longer.y.conservativeResize(31);
    longer.y[30] = 0.7;
    const ModelAccess::State& state = ModelAccess::state(told);
    const Hyperparameters given = gp.hyperparameters();
    for (Eigen::Index j = 0; j < q.rows(); ++j) {
      const Gaussian known = GaussianProcess::with_parameters(longer.x, longer.y, s.cube, given,
                                                              {.basis = Basis::linear})
                                 .predict(q.row(j));
      const Vector d =
          differences_of_the_mean(longer, given, {.basis = Basis::linear}, q.row(j), 1.0);
      const double factor = state.parameters.variance_factor;
      const double expected =
          factor * (known.variance + (state.parameters.root.transpose() * d).squaredNorm());
      EXPECT_NEAR(told.predict(q.row(j)).variance, expected, 1e-5 * expected);
    }
  }
}

/// Draws from a process whose parameters are then estimated: without this, intervals of 95 % are
/// too narrow.
TEST(ParameterUncertainty, BringsCoverageNearerToItsLevel) {
  constexpr Eigen::Index kPoints = 16;
  constexpr Eigen::Index kTests = 20;
  constexpr int kDraws = 150;
  const opt::Bounds cube = opt::unit_cube(2);
  double covered[2] = {0.0, 0.0};
  for (int draw = 0; draw < kDraws; ++draw) {
    const Matrix x = uniform_points(kPoints + kTests, 2, 100 + static_cast<std::uint64_t>(draw));
    Matrix r = Matrix::Identity(x.rows(), x.rows());
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      for (Eigen::Index j = 0; j < x.rows(); ++j) {
        const double t = std::sqrt(5.0) * (x.row(i) - x.row(j)).norm() / 0.5;
        r(i, j) = (1.0 + t + t * t / 3.0) * std::exp(-t) + (i == j ? 0.01 : 0.0);
      }
    RandomStream random(7, static_cast<std::uint64_t>(draw));
    Vector z(x.rows());
    for (double& value : z) value = random.normal();
    const Vector y = Eigen::LLT<Matrix>(r).matrixL() * z;
    for (const ParameterUncertainty how :
         {ParameterUncertainty::ignored, ParameterUncertainty::first_order}) {
      const auto gp = GaussianProcess::fit(x.topRows(kPoints), y.head(kPoints), cube,
                                           {.parameter_uncertainty = how, .starts = 3});
      const std::vector<Prediction> p = gp.predictions(x.bottomRows(kTests));
      for (Eigen::Index i = 0; i < kTests; ++i) {
        const Prediction& at = p[static_cast<std::size_t>(i)];
        const double error = y[kPoints + i] - at.function.mean;
        covered[static_cast<int>(how)] +=
            std::abs(error) <= 1.959964 * std::sqrt(at.observation_variance) ? 1.0 : 0.0;
      }
    }
  }
  const double plain = covered[0] / (kDraws * kTests);
  const double with = covered[1] / (kDraws * kTests);
  EXPECT_LT(with, 0.96);
  EXPECT_LT(0.95 - with, 0.55 * (0.95 - plain)) << plain << " without, " << with << " with it";
}

}  // namespace
}  // namespace repose::surrogate

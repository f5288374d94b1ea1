// Predictions: their derivatives, categories, transformed responses, user's regression functions
// and warnings.
#include <gtest/gtest.h>

#include "gp_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::Sample;
using test::smooth_function;
using test::uniform_points;

/// Derivatives of mean and standard deviation against differences of fourth order; h^4 ~ 1e-12 of
/// truncation, 1e-16/h of rounding, both magnified by conditions below 1e3.
void expect_gradients_of_differences(const GaussianProcess& gp, const Vector& x) {
  const opt::PredictionGradient g = gp.predict_gradient(x);
  const Gaussian there = gp.predict(x);
  EXPECT_NEAR(g.function.mean, there.mean, 1e-10 * (1.0 + std::abs(there.mean)));
  EXPECT_NEAR(g.function.variance, there.variance, 1e-9 * (1.0 + there.variance));
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    if (gp.inputs()[std::size_t(k)].is_categorical()) {
      EXPECT_EQ(g.mean[k], 0.0);
      continue;
    }
    const double range = gp.declared_bounds().upper[k] - gp.declared_bounds().lower[k];
    const double h = 1e-3 * range;
    const auto at = [&](double step) {
      Vector q = x;
      q[k] += step;
      return gp.predict(q);
    };
    const auto slope = [&](auto of) {
      return (8.0 * (of(at(h)) - of(at(-h))) - (of(at(2 * h)) - of(at(-2 * h)))) / (12.0 * h);
    };
    const double mean = slope([](const Gaussian& p) { return p.mean; });
    const double sd = slope([](const Gaussian& p) { return p.standard_deviation(); });
    const double unit = 1.0 / range;
    EXPECT_NEAR(g.mean[k], mean, 2e-6 * std::max(unit, std::abs(mean))) << to_string(gp.kernel());
    EXPECT_NEAR(g.standard_deviation[k], sd, 2e-6 * std::max(unit, std::abs(sd)))
        << to_string(gp.kernel());
  }
}

TEST(PredictGradient, EqualsDifferencesForEveryKernelAndBasis) {
  const Sample s;
  for (const Kernel kernel : all_kernels())
    for (const Basis basis : {Basis::none, Basis::constant, Basis::linear, Basis::quadratic}) {
      Hyperparameters given = s.given;
      if (kernel.length_scales == LengthScales::shared) given.length_scales = Vector{{0.7}};
      const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, given,
                                                       {.kernel = kernel, .basis = basis});
      for (Eigen::Index i = 0; i < 3; ++i)
        expect_gradients_of_differences(gp, uniform_points(3, 3, 31).row(i));
    }
}

TEST(PredictGradient, EqualsDifferencesWhereParametersAreUncertain) {
  const Sample s;
  for (const Kernel kernel : all_kernels())
    for (const Basis basis : {Basis::constant, Basis::quadratic}) {
      const auto gp =
          GaussianProcess::fit(s.x, s.y, s.cube, {.kernel = kernel, .basis = basis, .starts = 1});
      for (Eigen::Index i = 0; i < 3; ++i)
        expect_gradients_of_differences(gp, uniform_points(3, 3, 31).row(i));
    }
}

// many rows go by L^-1, whose products differ from solutions by the condition of L, below 1e4 here
TEST(PredictRows, OfManyAgreesWithOneByOne) {
  const Sample s;
  const auto gp = GaussianProcess::fit(s.x, s.y, s.cube);
  const Matrix q = uniform_points(1000, 3, 9);
  const std::vector<Gaussian> many = gp.predict_rows(q);
  for (Eigen::Index i = 0; i < q.rows(); ++i) {
    const Gaussian one = gp.predict(q.row(i));
    EXPECT_NEAR(many[static_cast<std::size_t>(i)].mean, one.mean, 1e-12);
    EXPECT_NEAR(many[static_cast<std::size_t>(i)].variance, one.variance, 1e-11);
  }
}

/// Two numbers, one of them over three decades, and a category.
struct Mixed {
  Matrix x = uniform_points(40, 3, 15);
  Vector y = Vector(40);
  std::vector<Input> inputs{{.lower = 1e5, .upper = 1e8, .scale = Scale::log},
                            {.lower = 0.0, .upper = 2.0},
                            {.levels = {"sphere", "clump", "cube"}}};
  explicit Mixed(Coding coding = Coding::exchangeable) {
    inputs[2].coding = coding;
    for (Eigen::Index i = 0; i < 40; ++i) {
      const double u = x(i, 0);
      const double v = x(i, 1);
      const double level = std::floor(3.0 * x(i, 2));
      x.row(i) << 1e5 * std::pow(1e3, u), 2.0 * v, level;
      y[i] = 3.0 + std::sin(4.0 * u) + v * v + (level == 1.0 ? 1.0 : 0.0) * (0.5 + u);
    }
  }
};

TEST(PredictGradient, EqualsDifferencesOnLogScalesBesideCategoriesAndForTransformedResponses) {
  const Mixed s;
  const Vector at{{3e6, 0.7, 1.0}};
  for (const ResponseScale scale :
       {ResponseScale::linear, ResponseScale::log, ResponseScale::logit}) {
    const Vector y = scale == ResponseScale::logit ? Vector(s.y / 10.0) : s.y;
    const auto gp = GaussianProcess::with_parameters(
        s.x, y, s.inputs, {Vector{{3.0, 1.5, 1.2}}, 0.5, 0.01}, {.response_scale = scale});
    const opt::PredictionGradient g = gp.predict_gradient(at);
    for (Eigen::Index k = 0; k < 2; ++k) {
      const double h = 1e-4 * at[k];
      Vector above = at;
      Vector below = at;
      above[k] += h;
      below[k] -= h;
      const Gaussian a = gp.predict(above);
      const Gaussian b = gp.predict(below);
      EXPECT_NEAR(g.mean[k] * at[k], at[k] * (a.mean - b.mean) / (2.0 * h), 1e-6);
      EXPECT_NEAR(g.standard_deviation[k] * at[k],
                  at[k] * (a.standard_deviation() - b.standard_deviation()) / (2.0 * h), 1e-6);
    }
    EXPECT_EQ(g.mean[2], 0.0);
  }
}

TEST(PredictGradient, DifferentiatesTheUsersFunctions) {
  const Sample s;
  const BasisFunctions wave{{"wave", "product"}, [](const Vector& x) {
                              return Vector{{std::sin(3.0 * x[0]), x[1] * x[2]}};
                            }};
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.functions = wave});
  EXPECT_EQ(gp.coefficients().size(), 3);
  expect_gradients_of_differences(gp, Vector{{0.3, 0.6, 0.45}});
}

TEST(BasisFunctions, OfTheLinearBasisGiveTheModelWithALinearBasis) {
  const Sample s;
  const BasisFunctions linear{{"a", "b", "c"}, [](const Vector& x) { return x; }};
  const auto mine =
      GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.functions = linear});
  const auto theirs =
      GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.basis = Basis::linear});
  const Vector at{{0.3, 1.6, 0.45}};
  EXPECT_NEAR(mine.predict(at).mean, theirs.predict(at).mean, 1e-11);
  EXPECT_NEAR(mine.predict(at).variance, theirs.predict(at).variance, 1e-11);
  EXPECT_NEAR((mine.coefficients() - theirs.coefficients()).norm(), 0.0, 1e-11);
  const BasisFunctions broken{{"a"}, [](const Vector&) { return Vector::Constant(1, NAN); }};
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.cube, {.functions = broken}), InputError);
}

TEST(LogScale, OfAnInputIsALinearScaleOfItsLogarithm) {
  const Mixed s;
  const Matrix two = s.x.leftCols(2);
  Matrix logs = two;
  logs.col(0) = logs.col(0).array().log();
  const std::vector<Input> inputs(s.inputs.begin(), s.inputs.begin() + 2);
  const auto scaled = GaussianProcess::fit(two, s.y, inputs);
  const auto linear = GaussianProcess::fit(
      logs, s.y, opt::Bounds{Vector{{std::log(1e5), 0.0}}, Vector{{std::log(1e8), 2.0}}});
  const Gaussian a = scaled.predict(Vector{{2e6, 1.1}});
  const Gaussian b = linear.predict(Vector{{std::log(2e6), 1.1}});
  EXPECT_NEAR(a.mean, b.mean, 1e-6);
  EXPECT_NEAR(a.standard_deviation(), b.standard_deviation(), 1e-5);
  EXPECT_THROW(scaled.predict(Vector{{0.0, 1.0}}), InputError);
  EXPECT_THROW(GaussianProcess::fit(two, s.y, std::vector<Input>{{.scale = Scale::log}, {}}),
               InputError);
}

TEST(Categories, ExchangeableLevelsMayBeRenumbered) {
  const Mixed s;
  Matrix renumbered = s.x;
  for (double& level : renumbered.col(2)) level = level == 0.0 ? 2.0 : level - 1.0;
  const auto a = GaussianProcess::fit(s.x, s.y, s.inputs);
  const auto b = GaussianProcess::fit(renumbered, s.y, s.inputs);
  // the order of rows, of sums, of steps of the search differs, and without noise the condition of
  // the covariance, 1e13, leaves some hundredths of a nat to rounding
  EXPECT_NEAR(a.negative_log_likelihood(), b.negative_log_likelihood(), 0.1);
  EXPECT_NEAR(a.predict(Vector{{1e6, 1.0, 1.0}}).mean, b.predict(Vector{{1e6, 1.0, 0.0}}).mean,
              1e-3);
}

TEST(Categories, OneHotWithEqualScalesIsExchangeable) {
  const Mixed one_hot(Coding::one_hot);
  const Mixed exchangeable;
  const double root = std::sqrt(2.0);  // indicators of 1 are sqrt2 apart
  const auto a = GaussianProcess::with_parameters(
      one_hot.x, one_hot.y, one_hot.inputs,
      {Vector{{3.0, 1.5, 0.9 * root, 0.9 * root, 0.9 * root}}, 0.5, 0.01});
  const auto b = GaussianProcess::with_parameters(
      exchangeable.x, exchangeable.y, exchangeable.inputs, {Vector{{3.0, 1.5, 0.9}}, 0.5, 0.01});
  const Vector at{{4e5, 0.3, 2.0}};
  EXPECT_NEAR(a.predict(at).mean, b.predict(at).mean, 1e-10);
  EXPECT_NEAR(a.negative_log_likelihood(), b.negative_log_likelihood(), 1e-9);
}

TEST(Categories, AreLearntByEveryCodingAndTrend) {
  for (const Coding coding : {Coding::label, Coding::one_hot, Coding::exchangeable})
    for (const Basis basis : {Basis::constant, Basis::linear, Basis::quadratic}) {
      const Mixed s(coding);
      const auto gp =
          GaussianProcess::fit(s.x, s.y, s.inputs, {.noise = Noise::none, .basis = basis});
      EXPECT_GT(gp.leave_one_out().q2, 0.9) << to_string(coding) << " " << to_string(basis);
    }
}

TEST(Categories, RefuseWhatIsNoLevel) {
  Mixed s;
  s.x(4, 2) = 3.0;
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.inputs), InputError);
  s.x(4, 2) = 0.5;
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.inputs), InputError);
  s.inputs[2].levels = {"sphere"};
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.inputs), InputError);
}

// mean and variance of the log-normal; likelihood of y = likelihood of log y / y
TEST(ResponseScale, LogIsTheModelOfTheLogarithm) {
  const Mixed s;
  const Vector logarithm = s.y.unaryExpr([](double y) { return std::log(y); });
  const auto plain = GaussianProcess::fit(s.x, logarithm, s.inputs);
  const auto log = GaussianProcess::fit(s.x, s.y, s.inputs, {.response_scale = ResponseScale::log});
  const Vector at{{4e5, 0.3, 2.0}};
  const Gaussian g = plain.predict(at);
  const Gaussian y = log.predict(at);
  const double mean = std::exp(g.mean + 0.5 * g.variance);
  EXPECT_NEAR(y.mean, mean, 1e-12 * mean);
  EXPECT_NEAR(y.variance, mean * mean * std::expm1(g.variance), 1e-12 * y.variance + 1e-15);
  EXPECT_NEAR(log.negative_log_likelihood(), plain.negative_log_likelihood() + logarithm.sum(),
              1e-9);
  EXPECT_NEAR(log.leave_one_out().log_density, plain.leave_one_out().log_density - logarithm.sum(),
              1e-9);
  Vector bad = s.y;
  bad[3] = 0.0;
  EXPECT_THROW(GaussianProcess::fit(s.x, bad, s.inputs, {.response_scale = ResponseScale::log}),
               InputError);
}

// against Simpson's rule over ten standard deviations, 4000 intervals
TEST(ResponseScale, LogitGivesTheMomentsOfAFraction) {
  const Mixed s;
  const Vector fraction = s.y.array() / 8.0;
  const auto plain =
      GaussianProcess::with_parameters(s.x, (fraction.array() / (1.0 - fraction.array())).log(),
                                       s.inputs, {Vector{{0.1, 0.2, 0.9}}, 4.0, 0.01});
  const auto logit = GaussianProcess::with_parameters(s.x, fraction, s.inputs,
                                                      {Vector{{0.1, 0.2, 0.9}}, 4.0, 0.01},
                                                      {.response_scale = ResponseScale::logit});
  const Vector at{{4e5, 0.3, 2.0}};
  const Gaussian g = plain.predict(at);
  ASSERT_GT(g.variance, 1.0);
  double weight = 0.0;
  double first = 0.0;
  double second = 0.0;
  for (int i = 0; i <= 4000; ++i) {
    const double t = -10.0 + 20.0 * i / 4000.0;
    const double w = std::exp(-0.5 * t * t) * (i == 0 || i == 4000 ? 1.0 : i % 2 == 1 ? 4.0 : 2.0);
    const double y = 1.0 / (1.0 + std::exp(-(g.mean + g.standard_deviation() * t)));
    weight += w;
    first += w * y;
    second += w * y * y;
  }
  EXPECT_NEAR(logit.predict(at).mean, first / weight, 1e-12);
  EXPECT_NEAR(logit.predict(at).variance, second / weight - std::pow(first / weight, 2), 1e-12);
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.inputs, {.response_scale = ResponseScale::logit}),
               InputError);
}

TEST(Predictions, SayWhereTheyShouldNotBeBelieved) {
  const Sample s;
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  Matrix at(3, 3);
  at << s.x.row(5), 1.01, 0.5, 0.5, 9.0, 9.0, 9.0;
  const std::vector<Prediction> p = gp.predictions(at);
  EXPECT_FALSE(p[0].outside_range || p[0].far_from_data);
  EXPECT_TRUE(p[1].outside_range && !p[1].far_from_data);
  EXPECT_TRUE(p[2].outside_range && p[2].far_from_data);
  for (std::size_t i = 0; i < 3; ++i) {
    const Gaussian g = gp.predict(at.row(Eigen::Index(i)));
    EXPECT_NEAR(p[i].function.mean, g.mean, 1e-13);
    EXPECT_NEAR(p[i].observation_variance, g.variance + s.given.noise_variance, 1e-12);
  }
}

// An observation at b with noise t lowers the variance at a by c(a, b)^2/(c(b, b) + t).
TEST(Covariance, IsThatOfConditioningOnAnotherPoint) {
  const Sample s;
  for (const Basis basis : {Basis::none, Basis::quadratic}) {
    const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.basis = basis});
    const Matrix q = uniform_points(4, 3, 77);
    const Matrix c = gp.covariance(q, q);
    EXPECT_LT((c - c.transpose()).cwiseAbs().maxCoeff(), 1e-13);
    for (Eigen::Index i = 0; i < 4; ++i) {
      EXPECT_NEAR(c(i, i), gp.predict(q.row(i)).variance, 1e-12);
      const double noise = gp.noise_variance();
      const auto told = gp.condition_on(q.row(0), 1.0);
      const double expected = c(i, i) - c(i, 0) * c(i, 0) / (c(0, 0) + noise);
      EXPECT_NEAR(told.predict(q.row(i)).variance, expected, 1e-10);
    }
  }
}

TEST(Covariance, OfALogResponseHasTheVariancesOfTheResponse) {
  const Sample s;
  const Vector y = s.y.array().exp();
  const auto gp = GaussianProcess::with_parameters(s.x, y, s.cube, s.given,
                                                   {.response_scale = ResponseScale::log});
  const Matrix q = uniform_points(3, 3, 78);
  const Matrix c = gp.covariance(q, q);
  for (Eigen::Index i = 0; i < 3; ++i) {
    EXPECT_NEAR(c(i, i), gp.predict(q.row(i)).variance, 1e-10 * c(i, i));
    EXPECT_LE(std::abs(c(i, 0)), std::sqrt(c(i, i) * c(0, 0)) * (1.0 + 1e-9));
  }
}

}  // namespace
}  // namespace repose::surrogate

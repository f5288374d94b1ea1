// Noise that is known, or that differs from point to point.
#include <gtest/gtest.h>

#include "gp_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::Sample;
using test::smooth_function;
using test::uniform_points;

TEST(KnownNoise, OfOneVarianceIsThatVarianceGiven) {
  const Sample s;
  const auto known = GaussianProcess::with_parameters(
      s.x, s.y, s.cube, s.given,
      {.noise = Noise::known, .noise_variances = Vector::Constant(30, s.given.noise_variance)});
  const auto given = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  const Vector at{{0.3, 0.6, 0.45}};
  EXPECT_NEAR(known.predict(at).mean, given.predict(at).mean, 1e-11);
  EXPECT_NEAR(known.predict(at).variance, given.predict(at).variance, 1e-11);
  EXPECT_NEAR(known.negative_log_likelihood(), given.negative_log_likelihood(), 1e-9);
  EXPECT_NEAR(known.noise_variance(), s.given.noise_variance, 1e-12);
}

TEST(KnownNoise, OfAHundredfoldVarianceTakesARowOutOfTheModel) {
  const Sample s(0);
  Vector noise = Vector::Constant(30, 0.01);
  noise[4] = 1e8;
  Vector y = s.y;
  y[4] += 100.0;
  const auto all = GaussianProcess::with_parameters(
      s.x, y, s.cube, s.given, {.noise = Noise::known, .noise_variances = noise});
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < 30; ++i)
    if (i != 4) kept.push_back(i);
  const auto without =
      GaussianProcess::with_parameters(s.x(kept, Eigen::all), y(kept), s.cube, s.given,
                                       {.noise = Noise::known, .noise_variances = noise(kept)});
  const Vector at = s.x.row(4);
  EXPECT_NEAR(all.predict(at).mean, without.predict(at).mean, 1e-5);
}

TEST(KnownNoise, FitsTheProcessVarianceThatItCannotProfile) {
  const Matrix x = uniform_points(60, 2, 41);
  const Vector noise = 0.01 + 0.09 * x.col(0).array();
  Vector y = at_rows(x, smooth_function);
  RandomStream random(42);
  for (Eigen::Index i = 0; i < 60; ++i) y[i] += std::sqrt(noise[i]) * random.normal();
  const auto gp = GaussianProcess::fit(x, y, opt::unit_cube(2),
                                       {.noise = Noise::known, .noise_variances = noise});
  EXPECT_EQ(gp.report().parameters.back().name, "process_variance");
  EXPECT_NE(gp.report().termination, opt::Termination::failed);
  const Matrix probe = uniform_points(200, 2, 43);
  const auto predicted = gp.predict_rows(probe);
  double squares = 0.0;
  for (Eigen::Index i = 0; i < 200; ++i)
    squares += std::pow(predicted[std::size_t(i)].mean - smooth_function(probe.row(i)), 2);
  EXPECT_LT(std::sqrt(squares / 200.0), 0.12);  // half of one observation's mean error
}

TEST(KnownNoise, RefusesVariancesThatAreMissingOrNotPositive) {
  const Sample s;
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.cube, {.noise = Noise::known}), InputError);
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.cube,
                                    {.noise = Noise::known, .noise_variances = Vector::Zero(30)}),
               InputError);
  EXPECT_THROW(
      GaussianProcess::fit(s.x, s.y, s.cube, {.noise_variances = Vector::Constant(30, 0.1)}),
      InputError);
}

/// Twelve points, five repeats each; noise ten times larger in the second half.
struct Heteroscedastic {
  Matrix x = uniform_points(12, 1, 51).replicate(5, 1);
  Vector y = at_rows(x, smooth_function);
  Heteroscedastic() {
    RandomStream random(52);
    for (Eigen::Index i = 0; i < 60; ++i) y[i] += (x(i, 0) < 0.5 ? 0.05 : 0.5) * random.normal();
  }
};

TEST(NoiseByPoint, IsTheShrunkenVarianceOfItsRepeats) {
  const Heteroscedastic s;
  Vector variance(60);
  double pooled = 0.0;
  Vector squares = Vector::Zero(12);
  for (Eigen::Index i = 0; i < 12; ++i) {
    double mean = 0.0;
    for (int r = 0; r < 5; ++r) mean += s.y[i + 12 * r] / 5.0;
    for (int r = 0; r < 5; ++r) squares[i] += std::pow(s.y[i + 12 * r] - mean, 2);
    pooled += squares[i] / 48.0;
  }
  for (Eigen::Index j = 0; j < 60; ++j)
    variance[j] = (6.0 * pooled + squares[j % 12]) / (6.0 + 4.0);
  const Hyperparameters given{Vector{{0.3}}, 1.0, 0.0};
  const opt::Bounds unit = opt::unit_cube(1);
  const auto by_point =
      GaussianProcess::with_parameters(s.x, s.y, unit, given, {.noise = Noise::by_point});
  const auto known = GaussianProcess::with_parameters(
      s.x, s.y, unit, given, {.noise = Noise::known, .noise_variances = variance});
  const Vector at{{0.37}};
  EXPECT_NEAR(by_point.predict(at).mean, known.predict(at).mean, 1e-10);
  EXPECT_NEAR(by_point.predict(at).variance, known.predict(at).variance, 1e-10);
  EXPECT_NEAR(by_point.negative_log_likelihood(), known.negative_log_likelihood(), 1e-8);
}

TEST(NoiseByPoint, TrustsQuietPointsMoreThanOneVarianceDoes) {
  const Heteroscedastic s;
  const opt::Bounds unit = opt::unit_cube(1);
  const auto by_point = GaussianProcess::fit(s.x, s.y, unit, {.noise = Noise::by_point});
  const auto one = GaussianProcess::fit(s.x, s.y, unit);
  Eigen::Index quiet = 0;
  while (s.x(quiet, 0) > 0.4) ++quiet;
  const Vector at = s.x.row(quiet);
  EXPECT_LT(by_point.predict(at).variance, one.predict(at).variance);
  const Matrix without = s.x.topRows(12);
  EXPECT_THROW(GaussianProcess::fit(without, s.y.head(12), unit, {.noise = Noise::by_point}),
               InputError);
}

}  // namespace
}  // namespace repose::surrogate

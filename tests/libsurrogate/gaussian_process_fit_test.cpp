// Fits: best known likelihoods, accuracy, invariances, degenerate data.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>

#include "gp_data.hpp"
#include "repose/base/error.hpp"
#include "repose/opt/composite.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::range_of;
using test::read_indexed_csv;
using test::smooth_function;
using test::uniform_points;

GaussianProcessOptions deterministic_ml() {
  GaussianProcessOptions options;
  options.noise = Noise::none;
  options.estimator = Estimator::ml;
  options.prior = Prior::none;
  return options;
}

struct BestKnown {
  const char* file;
  Eigen::Index inputs;
  double value;
};

/// Smallest negative log likelihoods of about 950 restarts of four schemes in the saferGPMLE study.
class BestKnownLikelihood : public testing::TestWithParam<BestKnown> {};

TEST_P(BestKnownLikelihood, IsReachedWithinHalfANat) {
  const auto [file, inputs, value] = GetParam();
  const Matrix data = read_indexed_csv(file);
  const Matrix x = data.leftCols(inputs);
  const GaussianProcess gp =
      GaussianProcess::fit(x, data.col(inputs), range_of(x), deterministic_ml());
  EXPECT_LE(gp.negative_log_likelihood(), value + 0.5);
  EXPECT_NE(gp.report().termination, opt::Termination::failed);
  // in other units the same model: shifted by n log c under c y, unchanged under c x
  const double rows = static_cast<double>(x.rows());
  constexpr double kC = 1e3;
  const GaussianProcess scaled =
      GaussianProcess::fit(kC * x, kC * data.col(inputs), range_of(kC * x), deterministic_ml());
  EXPECT_NEAR(scaled.negative_log_likelihood() - gp.negative_log_likelihood(), rows * std::log(kC),
              1e-4);
  RecordProperty("gap", std::to_string(gp.negative_log_likelihood() - value));
  RecordProperty("evaluations", gp.report().evaluations);
}

INSTANTIATE_TEST_SUITE_P(SaferGpmle, BestKnownLikelihood,
                         testing::Values(BestKnown{"ds_branin_10d.csv", 2, 87.2227},
                                         BestKnown{"ds_borehole_10d.csv", 8, 136.4567},
                                         BestKnown{"ds_weldedbeamdesign_10d.csv", 4, 122.7286},
                                         BestKnown{"ds_g10mod_5d.csv", 8, 133.825}));

double branin_rmse(const GaussianProcessOptions& options) {
  const Matrix data = read_indexed_csv("branin_uniform.csv");
  const opt::Bounds box{Vector{{-5.0, 0.0}}, Vector{{10.0, 15.0}}};
  const GaussianProcess gp =
      GaussianProcess::fit(data.topLeftCorner(50, 2), data.col(2).head(50), box, options);
  const std::vector<Gaussian> predicted = gp.predict_rows(data.block(50, 0, 500, 2));
  double squares = 0.0;
  for (Eigen::Index i = 0; i < 500; ++i)
    squares += std::pow(predicted[static_cast<std::size_t>(i)].mean - data(50 + i, 2), 2);
  return std::sqrt(squares / 500.0);
}

// 0.176 is the study's figure of a well conducted likelihood fit
TEST(GaussianProcessFit, PredictsBraninFromFiftyPointsWithin018) {
  EXPECT_LE(branin_rmse(deterministic_ml()), 0.18);
  EXPECT_LE(branin_rmse({.noise = Noise::none}), 0.18);
}

TEST(GaussianProcessFit, LosesLittleByLookingForNoiseThatIsNotThere) {
  EXPECT_LE(branin_rmse({}), 1.25 * branin_rmse({.noise = Noise::none}));
}

// A hundredth of the range, symmetric, and two inputs without effect: half of these designs used to
// end 45 nats short, at the optimum that calls it noise.
TEST(GaussianProcessFit, DoesNotTakeASmallSymmetricEffectForNoise) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const Matrix x = opt::scrambled_uniforms(50, 6, seed);
    const Vector y = at_rows(x, [](const Vector& u) {
      return 10.0 * u[0] * u[1] + u[2] * u[2] + 0.1 * std::pow(2.0 * u[3] - 1.0, 2);
    });
    const auto gp = GaussianProcess::fit(x, y, opt::unit_cube(6));
    // its own variance is 0.03^2
    EXPECT_LT(gp.noise_variance(), 0.01 * 0.03 * 0.03) << "design " << seed;
  }
}

/// Friedman 1991; inputs beyond the fifth have no effect.
double friedman(const Vector& x) {
  return 10.0 * std::sin(std::numbers::pi * x[0] * x[1]) + 20.0 * std::pow(x[2] - 0.5, 2) +
         10.0 * x[3] + 5.0 * x[4];
}

// 150 points of a polynomial but for one term: the process variance becomes 10^5 of the response's,
// and the least noise ratio must be that much smaller. It costs 6 nats; at 1e-14 it cost 15.
TEST(GaussianProcessFit, PaysFewNatsForLookingForNoiseThatIsNotThere) {
  const Matrix x = opt::scrambled_uniforms(150, 5, 1);
  const Vector y = at_rows(x, friedman);
  const auto likelihood = [&](Noise noise) {
    return GaussianProcess::fit(
               x, y, opt::unit_cube(5),
               {.noise = noise, .estimator = Estimator::ml, .prior = Prior::none, .starts = 3})
        .negative_log_likelihood();
  };
  EXPECT_LE(likelihood(Noise::estimated), likelihood(Noise::none) + 8.0);
}

struct Accuracy {
  double median_rmse;
  double median_coverage95;  ///< of the function
};

/// Over twelve quasi-random designs.
Accuracy friedman_accuracy(Eigen::Index n, Eigen::Index d, double noise,
                           const GaussianProcessOptions& options) {
  const Matrix probe = uniform_points(800, d, 99);
  std::vector<double> rmse;
  std::vector<double> coverage;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const Matrix x = opt::scrambled_uniforms(n, d, seed);
    Vector y = at_rows(x, friedman);
    RandomStream random(seed);
    for (double& value : y) value += noise * random.normal();
    const auto predicted =
        GaussianProcess::fit(x, y, opt::unit_cube(d), options).predict_rows(probe);
    double squares = 0.0;
    double covered = 0.0;
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      const double error = predicted[i].mean - friedman(probe.row(static_cast<Eigen::Index>(i)));
      squares += error * error;
      if (std::abs(error) <= 1.96 * predicted[i].standard_deviation()) covered += 1.0;
    }
    rmse.push_back(std::sqrt(squares / 800.0));
    coverage.push_back(covered / 800.0);
  }
  std::sort(rmse.begin(), rmse.end());
  std::sort(coverage.begin(), coverage.end());
  return {0.5 * (rmse[5] + rmse[6]), 0.5 * (coverage[5] + coverage[6])};
}

// scikit-learn 1.2.1 reaches 0.263 on such designs, RobustGaSP 0.28 on its own [Gu2019]
TEST(GaussianProcessFit, PredictsFriedmansFunctionFromFortyPoints) {
  EXPECT_LE(friedman_accuracy(40, 5, 0.0, {.noise = Noise::none}).median_rmse, 0.24);
}

// better than one observation (sigma = 1) with five active and ten inert inputs, and knows how good
TEST(GaussianProcessFit, FindsFiveActiveInputsAmongFifteenInNoise) {
  const Accuracy accuracy = friedman_accuracy(60, 15, 1.0, {});
  EXPECT_LE(accuracy.median_rmse, 1.0);
  EXPECT_GE(accuracy.median_coverage95, 0.90);
  EXPECT_LE(accuracy.median_coverage95, 0.98);
}

struct Noisy {
  Matrix x = uniform_points(60, 4, 21);
  Vector y = at_rows(x, smooth_function);
  opt::Bounds cube = opt::unit_cube(4);
  Matrix probe = uniform_points(50, 4, 22);
  Noisy() {
    RandomStream random(23);
    for (double& value : y) value += 0.2 * random.normal();
  }
};

bool same_bits(const std::vector<Gaussian>& a, const std::vector<Gaussian>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Gaussian)) == 0;
}

TEST(GaussianProcessFit, GivesTheSameBitsForAnyNumberOfThreads) {
  const Noisy s;
  const auto one = GaussianProcess::fit(s.x, s.y, s.cube, {.threads = 1}).predict_rows(s.probe);
  for (const unsigned threads : {2u, 4u})
    EXPECT_TRUE(same_bits(
        one, GaussianProcess::fit(s.x, s.y, s.cube, {.threads = threads}).predict_rows(s.probe)));
}

TEST(GaussianProcessFit, DoesNotDependOnTheOrderOfRows) {
  const Noisy s;
  std::vector<Eigen::Index> order(60);
  for (std::size_t i = 0; i < 60; ++i) order[i] = static_cast<Eigen::Index>((i * 37 + 5) % 60);
  const auto straight = GaussianProcess::fit(s.x, s.y, s.cube);
  const auto shuffled = GaussianProcess::fit(s.x(order, Eigen::all), s.y(order), s.cube);
  EXPECT_TRUE(same_bits(straight.predict_rows(s.probe), shuffled.predict_rows(s.probe)));
  EXPECT_EQ(straight.leave_one_out().residual(order), shuffled.leave_one_out().residual);
}

/// Largest differences of predictions, and of variances, by a fit in units kx and ky.
void expect_same_in_units(double kx, double ky, double tolerance,
                          const GaussianProcessOptions& options = {}) {
  const Noisy s;
  const auto plain = GaussianProcess::fit(s.x, s.y, s.cube, options);
  const auto scaled =
      GaussianProcess::fit(kx * s.x, ky * s.y, {kx * s.cube.lower, kx * s.cube.upper}, options);
  const std::vector<Gaussian> a = plain.predict_rows(s.probe);
  const std::vector<Gaussian> b = scaled.predict_rows(kx * s.probe);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(b[i].mean / ky, a[i].mean, tolerance);
    EXPECT_NEAR(b[i].variance / (ky * ky), a[i].variance, tolerance);
  }
}

// powers of two round nothing; others to what rounding of the likelihood lets a search resolve that
// goes as far as it can, 1e-7 of a log parameter
TEST(GaussianProcessFit, DoesNotDependOnUnits) {
  expect_same_in_units(0x1p20, 0x1p-30, 0.0);
  GaussianProcessOptions to_the_end;
  to_the_end.minimizer = opt::BuiltinMinimizer{{.relative_x_tolerance = 1e-12,
                                                .absolute_x_tolerance = 1e-12,
                                                .relative_f_tolerance = 0.0,
                                                .max_evaluations = 1000,
                                                .initial_curvature = 1.0}};
  expect_same_in_units(1e6, 1e-9, 1e-7, to_the_end);
}

TEST(GaussianProcessFit, FindsTheNoiseAndTheFunction) {
  const Noisy s;
  const auto gp = GaussianProcess::fit(s.x, s.y, s.cube);
  // 55 degrees of freedom or so: the estimate of a variance scatters by 19 %; three of that
  EXPECT_NEAR(gp.noise_variance(), 0.04, 3 * 0.19 * 0.04);
  double squares = 0.0;
  for (Eigen::Index i = 0; i < s.probe.rows(); ++i)
    squares += std::pow(gp.predict(s.probe.row(i)).mean - smooth_function(s.probe.row(i)), 2);
  EXPECT_LT(std::sqrt(squares / 50.0), 0.2);  // better than a single observation
  EXPECT_GT(gp.leave_one_out().q2, 0.6);
}

TEST(GaussianProcessFit, FixesAndBoundsEveryParameterItIsTold) {
  const Noisy s;
  GaussianProcessOptions options{.kernel = kernel_named("ard-rational-quadratic")};
  options.bounds = {{"length_scale_2", 0.7, 0.7},
                    {"length_scale_1", 0.05, 0.06},
                    {"alpha", 2.0, 2.0},
                    {"noise_variance", 0.03, 0.03}};
  const auto gp = GaussianProcess::fit(s.x, s.y, s.cube, options);
  const Hyperparameters found = gp.hyperparameters();
  EXPECT_NEAR(found.length_scales[1], 0.7, 1e-14);
  EXPECT_NEAR(found.length_scales[0], 0.06, 1e-12);  // it wants a longer one
  EXPECT_NEAR(found.alpha, 2.0, 1e-14);
  EXPECT_NEAR(found.noise_variance, 0.03, 1e-14);
  EXPECT_NEAR(gp.noise_variance(), 0.03, 1e-14);
  std::map<std::string, ParameterState> state;
  for (const FittedParameter& p : gp.report().parameters) state[p.name] = p.state;
  EXPECT_EQ(state.size(), 7u);
  EXPECT_EQ(state["length_scale_1"], ParameterState::at_upper_bound);
  EXPECT_EQ(state["length_scale_2"], ParameterState::fixed);
  EXPECT_EQ(state["alpha"], ParameterState::fixed);
  EXPECT_EQ(state["noise_variance"], ParameterState::fixed);
  EXPECT_EQ(state["process_variance"], ParameterState::converged);

  options.bounds = {{"length_scale_9", 0.1, 1.0}};
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.cube, options), InputError);
  options.bounds = {{"noise_ratio", 1.0, 0.1}};
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.cube, options), InputError);
}

TEST(GaussianProcessFit, WithEverythingGivenIsTheModelWithThoseParameters) {
  const Noisy s;
  GaussianProcessOptions options{.kernel = kernel_named("matern32")};
  options.bounds = {
      {"length_scale", 0.8, 0.8}, {"process_variance", 1.5, 1.5}, {"noise_variance", 0.04, 0.04}};
  const auto fitted = GaussianProcess::fit(s.x, s.y, s.cube, options);
  const auto given = GaussianProcess::with_parameters(s.x, s.y, s.cube, {Vector{{0.8}}, 1.5, 0.04},
                                                      {.kernel = options.kernel});
  EXPECT_NEAR(fitted.negative_log_likelihood(), given.negative_log_likelihood(), 1e-9);
  EXPECT_EQ(fitted.report().message, "every parameter was given");
}

/// Two ways to the same optimum, within what the search resolves.
TEST(GaussianProcessFit, FindsTheSameWithTheAmplitudeProfiledOrSearched) {
  const Noisy s;
  for (const Estimator estimator : {Estimator::reml, Estimator::ml}) {
    GaussianProcessOptions options{.estimator = estimator, .prior = Prior::none};
    const auto profiled = GaussianProcess::fit(s.x, s.y, s.cube, options);
    options.bounds = {{"process_variance", 1e-9, 1e9}};
    const auto searched = GaussianProcess::fit(s.x, s.y, s.cube, options);
    EXPECT_NEAR(searched.negative_log_likelihood(), profiled.negative_log_likelihood(), 1e-2);
  }
}

TEST(GaussianProcessFit, ByLeaveOneOutDensityLeavesOutBetterThanByLikelihood) {
  const Noisy s;
  const auto loo =
      GaussianProcess::fit(s.x, s.y, s.cube, {.estimator = Estimator::loo, .prior = Prior::none});
  const auto ml =
      GaussianProcess::fit(s.x, s.y, s.cube, {.estimator = Estimator::ml, .prior = Prior::none});
  EXPECT_GT(loo.leave_one_out().log_density, ml.leave_one_out().log_density);
  EXPECT_LT(ml.negative_log_likelihood(), loo.negative_log_likelihood());
}

TEST(GaussianProcessFit, MoreStartsAreNeverWorse) {
  const Noisy s;
  double before = std::numeric_limits<double>::infinity();
  for (const int starts : {1, 2, 4, 8}) {
    const auto gp = GaussianProcess::fit(
        s.x, s.y, s.cube, {.estimator = Estimator::ml, .prior = Prior::none, .starts = starts});
    EXPECT_LE(gp.negative_log_likelihood(), before + 1e-9);
    before = gp.negative_log_likelihood();
  }
}

TEST(GaussianProcessFit, IsTheTrendWhereTheTrendExplainsTheResponse) {
  const Noisy s;
  const Vector y = 3.0 * s.x.col(0) - 2.0 * s.x.col(3) + Vector::Constant(60, 5.0);
  const auto gp = GaussianProcess::fit(s.x, y, s.cube, {.basis = Basis::linear});
  const Vector at = s.probe.row(0);
  EXPECT_NEAR(gp.predict(at).mean, 5.0 + 3.0 * at[0] - 2.0 * at[3], 1e-10);
  EXPECT_EQ(gp.predict(at).variance, 0.0);
  EXPECT_NEAR(gp.coefficients()[1], 3.0, 1e-10);
}

TEST(GaussianProcessFit, NamesARegressionFunctionThatDependsOnOthers) {
  const Noisy s;
  Matrix x = s.x;
  x.col(2).setConstant(0.5);
  try {
    GaussianProcess::fit(x, s.y, s.cube, {.basis = Basis::linear});
    FAIL() << "a constant input was accepted in a linear trend";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'input 3'"), std::string::npos) << error.what();
  }
}

TEST(GaussianProcessFit, DoesNotChangeWhenAllRowsAreGivenTwiceWithoutNoise) {
  const Noisy s;
  const Vector y = at_rows(s.x, smooth_function);
  const auto once = GaussianProcess::fit(s.x, y, s.cube, {.noise = Noise::none});
  const auto twice =
      GaussianProcess::fit(s.x.replicate(2, 1), y.replicate(2, 1), s.cube, {.noise = Noise::none});
  // the mean of twice as many numbers is rounded otherwise; the search magnifies that
  const std::vector<Gaussian> a = once.predict_rows(s.probe);
  const std::vector<Gaussian> b = twice.predict_rows(s.probe);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_NEAR(a[i].mean, b[i].mean, 1e-5);
    EXPECT_NEAR(a[i].standard_deviation(), b[i].standard_deviation(), 1e-5);
  }
}

TEST(GaussianProcessFit, CallsAnInputWithoutEffectInert) {
  const Noisy s;
  Vector y(60);
  for (Eigen::Index i = 0; i < 60; ++i)
    y[i] = std::sin(6.0 * s.x(i, 0)) + std::cos(5.0 * s.x(i, 1));
  const auto gp = GaussianProcess::fit(s.x, y, s.cube);
  const std::vector<FittedParameter>& p = gp.report().parameters;
  ASSERT_EQ(p.size(), 5u);
  EXPECT_EQ(p[0].state, ParameterState::converged);
  EXPECT_EQ(p[1].state, ParameterState::converged);
  EXPECT_EQ(p[2].state, ParameterState::inert);
  EXPECT_EQ(p[3].state, ParameterState::inert);
  EXPECT_EQ(p[4].name, "noise_ratio");
}

TEST(GaussianProcessFit, OfAConstantResponseIsThatConstantForCertain) {
  const Noisy s;
  for (const Noise noise : {Noise::none, Noise::estimated}) {
    const auto gp = GaussianProcess::fit(s.x, Vector::Constant(60, 41.7), s.cube, {.noise = noise});
    EXPECT_NEAR(gp.predict(s.probe.row(0)).mean, 41.7, 1e-12 * 41.7);
    EXPECT_EQ(gp.predict(s.probe.row(0)).variance, 0.0);
    EXPECT_NEAR(gp.leave_one_out().rmse, 0.0, 1e-12 * 41.7);
  }
}

TEST(GaussianProcessFit, SurvivesAlmostEqualPointsAndRecordsTheJitter) {
  const Noisy s;
  Matrix x(61, 4);
  x << s.x, s.x.topRows(1);
  x(60, 0) += 1e-13;
  const Vector y = at_rows(x, smooth_function);
  const auto gp = GaussianProcess::fit(x, y, s.cube, {.noise = Noise::none});
  EXPECT_GE(gp.report().jitter, 1e-14);
  EXPECT_TRUE(std::isfinite(gp.predict(s.probe.row(0)).mean));
}

TEST(GaussianProcessFit, OfTwoPointsAndOfAConstantInputIsDefined) {
  const Matrix two{{0.2, 0.5}, {0.9, 0.5}};
  const auto gp = GaussianProcess::fit(two, Vector{{1.0, 2.0}}, opt::unit_cube(2));
  const Gaussian middle = gp.predict(Vector{{0.5, 0.5}});
  EXPECT_TRUE(std::isfinite(middle.mean) && std::isfinite(middle.variance));
  EXPECT_EQ(gp.report().parameters[1].relevance, 0.0);
}

TEST(GaussianProcessFit, TakesAnyMinimizer) {
  struct Lazy {
    opt::Minimum minimize(const opt::Objective& f, const Vector& x, const opt::Bounds&) const {
      return {x, f(x, nullptr), opt::Termination::budget, "stayed", 1, 0.0};
    }
  };
  const Noisy s;
  const auto gp = GaussianProcess::fit(s.x, s.y, s.cube, {.starts = 1, .minimizer = Lazy{}});
  EXPECT_EQ(gp.report().message, "stayed");
}

}  // namespace
}  // namespace repose::surrogate

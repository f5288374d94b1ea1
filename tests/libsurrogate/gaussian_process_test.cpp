// The Gaussian process at given hyper-parameters: reference values, twins and properties.
#include "repose/surrogate/gaussian_process.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gp_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::smooth_function;
using test::uniform_points;

constexpr double kTight = 1e-9;

Vector vector_of(const nlohmann::json& values) {
  const auto v = values.get<std::vector<double>>();
  return Eigen::Map<const Vector>(v.data(), static_cast<Eigen::Index>(v.size()));
}

Matrix matrix_of(const nlohmann::json& rows) {
  Matrix m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows[0].size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    m.row(static_cast<Eigen::Index>(i)) = vector_of(rows[i]);
  return m;
}

TEST(GaussianProcess, AgreesWithReferenceCases) {
  std::ifstream file(std::string(REPOSE_TEST_DATA) + "/gp/gp_reference.json");
  const nlohmann::json reference = nlohmann::json::parse(file);
  const Matrix x = matrix_of(reference["U"]);
  const Vector y = vector_of(reference["y"]);
  const Matrix test_points = matrix_of(reference["U_test"]);
  int cases = 0;
  for (const auto& c : reference["cases"]) {
    const bool matern = c["kernel"] == "matern52";
    const bool constant = c["basis"] == "constant";
    if (!matern && c["kernel"] != "squaredexponential") continue;
    if (!constant && c["basis"] != "none") continue;
    ++cases;
    const double sf = c["sigma_f"];
    const double sn = c["sigma_n"];
    const GaussianProcess gp = GaussianProcess::with_parameters(
        x, y, opt::unit_cube(2), {vector_of(c["length_scales"]), sf * sf, sn * sn},
        {.kernel = matern ? Kernel::matern52 : Kernel::squared_exponential,
         .basis = constant ? Basis::constant : Basis::none,
         .estimator = Estimator::ml});
    const double expected = c["log_likelihood_profile_beta"];
    EXPECT_NEAR(-gp.negative_log_likelihood(), expected, kTight * std::abs(expected));
    const Vector beta = vector_of(c["beta"]);
    ASSERT_EQ(gp.coefficients().size(), beta.size());
    if (beta.size() > 0) {
      EXPECT_NEAR(gp.coefficients()[0], beta[0], kTight * std::abs(beta[0]));
    }
    const std::vector<Gaussian> predicted = gp.predict_rows(test_points);
    const Vector mean = vector_of(c["mean"]);
    const Vector sd = vector_of(c["sd_latent_with_beta_uncertainty"]);
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      const Gaussian& p = predicted[static_cast<std::size_t>(i)];
      EXPECT_NEAR(p.mean, mean[i], kTight * std::abs(mean[i]));
      EXPECT_NEAR(p.standard_deviation(), sd[i], kTight * sd[i]);
    }
  }
  EXPECT_EQ(cases, 8);
}

/// 30 rows of which the last 8 repeat earlier points, with noise.
struct Sample {
  Matrix x = uniform_points(30, 3, 5);
  Vector y;
  opt::Bounds cube = opt::unit_cube(3);
  Hyperparameters given{Vector{{0.4, 0.8, 1.1}}, 0.9, 0.02};
  explicit Sample(Eigen::Index repeats = 8) {
    for (Eigen::Index i = 0; i < repeats; ++i) x.row(29 - i) = x.row(i % 4);
    y = at_rows(x, smooth_function);
    RandomStream random(6);
    for (double& value : y) value += 0.1 * random.normal();
  }
};

std::vector<Eigen::Index> other_points(const Matrix& x, Eigen::Index row) {
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (x.row(i) != x.row(row)) kept.push_back(i);
  return kept;
}

TEST(LeaveOneOut, ClosedFormEqualsLeavingEachPointOut) {
  for (const Basis basis : {Basis::none, Basis::constant}) {
    const Sample s;
    const GaussianProcess gp =
        GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.basis = basis});
    const LeaveOneOut loo = gp.leave_one_out();
    double squares = 0.0;
    for (Eigen::Index i = 0; i < s.x.rows(); ++i) {
      const std::vector<Eigen::Index> kept = other_points(s.x, i);
      const GaussianProcess without = GaussianProcess::with_parameters(
          s.x(kept, Eigen::all), s.y(kept), s.cube, s.given, {.basis = basis});
      const Gaussian expected = without.predict(s.x.row(i));
      EXPECT_NEAR(loo.predicted[i], expected.mean, 1e-10);
      EXPECT_NEAR(loo.variance[i], expected.variance + s.given.noise_variance, 1e-10);
      EXPECT_NEAR(loo.residual[i], s.y[i] - expected.mean, 1e-10);
      squares += std::pow(s.y[i] - expected.mean, 2);
    }
    const double total = (s.y.array() - s.y.mean()).square().sum();
    EXPECT_NEAR(loo.q2, 1.0 - squares / total, 1e-10);
    EXPECT_NEAR(loo.rmse, std::sqrt(squares / 30.0), 1e-10);
    EXPECT_GT(loo.coverage95, 0.8);
  }
}

TEST(LeaveOneOut, OfADeterministicFunctionHoldsToo) {
  Sample s(0);
  s.given.noise_variance = 0.0;
  s.y = at_rows(s.x, smooth_function);
  const LeaveOneOut loo =
      GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given).leave_one_out();
  const std::vector<Eigen::Index> kept = other_points(s.x, 7);
  const Gaussian expected =
      GaussianProcess::with_parameters(s.x(kept, Eigen::all), s.y(kept), s.cube, s.given)
          .predict(s.x.row(7));
  EXPECT_NEAR(loo.predicted[7], expected.mean, 1e-10);
  EXPECT_NEAR(loo.variance[7], expected.variance, 1e-10);
}

TEST(ConditionOn, EqualsTheModelOfAllDataAtTheSameHyperparameters) {
  const Sample s;
  const auto first =
      GaussianProcess::with_parameters(s.x.topRows(20), s.y.head(20), s.cube, s.given);
  GaussianProcess grown = first;
  for (Eigen::Index i = 20; i < 30; ++i) grown = grown.condition_on(s.x.row(i), s.y[i]);
  const auto all = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  EXPECT_EQ(grown.rows(), 30);
  for (Eigen::Index i = 0; i < 10; ++i) {
    const Vector at = uniform_points(10, 3, 77).row(i);
    EXPECT_NEAR(grown.predict(at).mean, all.predict(at).mean, 1e-11);
    EXPECT_NEAR(grown.predict(at).variance, all.predict(at).variance, 1e-11);
  }
  EXPECT_NEAR(grown.negative_log_likelihood(), all.negative_log_likelihood(), 1e-9);
}

TEST(ConditionOn, ThePredictedMeanLeavesMeansAndLowersVariances) {
  const Sample s;
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  const Vector at{{0.5, 0.5, 0.5}};
  const GaussianProcess believing = gp.condition_on(at, gp.predict(at).mean);
  for (Eigen::Index i = 0; i < 10; ++i) {
    const Vector there = uniform_points(10, 3, 78).row(i);
    EXPECT_NEAR(believing.predict(there).mean, gp.predict(there).mean, 1e-12);
    EXPECT_LE(believing.predict(there).variance, gp.predict(there).variance);
  }
}

TEST(GaussianProcess, InterpolatesADeterministicFunction) {
  Sample s(0);
  s.y = at_rows(s.x, smooth_function);
  s.given.noise_variance = 0.0;
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  for (Eigen::Index i = 0; i < s.x.rows(); ++i) {
    EXPECT_NEAR(gp.predict(s.x.row(i)).mean, s.y[i], 1e-9);
    EXPECT_NEAR(gp.predict(s.x.row(i)).variance, 0.0, 1e-9);
  }
}

TEST(GaussianProcess, RevertsToItsMeanFarAway) {
  const Sample s;
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  const Gaussian far = gp.predict(Vector::Constant(3, 1e3));
  EXPECT_NEAR(far.mean, gp.coefficients()[0], 1e-12);
  EXPECT_GT(far.variance, s.given.process_variance);  // the mean is not known for certain
}

TEST(GaussianProcess, PredictsManyRowsAsOneByOne) {
  const Sample s;
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  const Matrix points = uniform_points(300, 3, 79);
  const std::vector<Gaussian> rows = gp.predict_rows(points);
  ASSERT_EQ(rows.size(), 300u);
  for (Eigen::Index i = 0; i < 300; ++i) {
    EXPECT_NEAR(rows[static_cast<std::size_t>(i)].mean, gp.predict(points.row(i)).mean, 1e-13);
    EXPECT_NEAR(rows[static_cast<std::size_t>(i)].variance, gp.predict(points.row(i)).variance,
                1e-13);
  }
}

template <class Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(GaussianProcess, NamesRowAndColumnOfBadData) {
  Sample s;
  s.x(4, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(
      message_of([&] { GaussianProcess::fit(s.x, s.y, s.cube); }).find("row 5, input 2 is nan"),
      std::string::npos);
  s = Sample();
  s.y[9] = std::numeric_limits<double>::infinity();
  EXPECT_NE(
      message_of([&] { GaussianProcess::fit(s.x, s.y, s.cube); }).find("row 10, response is inf"),
      std::string::npos);
}

TEST(GaussianProcess, RefusesTooFewPointsAndDifferingRepeatsWithoutNoise) {
  const Sample s;
  const Matrix one = s.x.topRows(1);
  EXPECT_NE(message_of([&] { GaussianProcess::fit(one, s.y.head(1), s.cube); }).find("at least 2"),
            std::string::npos);
  const Matrix same = one.replicate(3, 1);
  EXPECT_NE(message_of([&] { GaussianProcess::fit(same, s.y.head(3), s.cube); }).find("at least 2"),
            std::string::npos);
  EXPECT_NE(message_of([&] {
              GaussianProcess::fit(s.x, s.y, s.cube, {.noise = Noise::none});
            }).find("rows 1 and"),
            std::string::npos);
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y.head(3), s.cube), InputError);
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, opt::unit_cube(2)), InputError);
  EXPECT_THROW(GaussianProcess::fit(s.x, s.y, s.cube).predict(Vector::Zero(2)), InputError);
}

}  // namespace
}  // namespace repose::surrogate

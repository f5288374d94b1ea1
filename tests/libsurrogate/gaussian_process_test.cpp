// The Gaussian process at given hyper-parameters: reference values, twins and properties.
#include "repose/surrogate/gaussian_process.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gp_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::Sample;
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

Kernel kernel_of(const nlohmann::json& c) {
  const std::string name = c["kernel"];
  for (const Kernel kernel : all_kernels()) {
    std::string plain = to_string(kernel);
    std::erase(plain, '-');
    if (plain == "ard" + name) return kernel;
  }
  throw std::runtime_error("no kernel " + name);
}

Basis basis_of(const nlohmann::json& c) {
  return c["basis"] == "pureQuadratic" ? Basis::quadratic : basis_named(std::string(c["basis"]));
}

TEST(GaussianProcess, AgreesWithFortyReferenceCases) {
  std::ifstream file(std::string(REPOSE_TEST_DATA) + "/gp/gp_reference.json");
  const nlohmann::json reference = nlohmann::json::parse(file);
  const Matrix x = matrix_of(reference["U"]);
  const Vector y = vector_of(reference["y"]);
  const Matrix test_points = matrix_of(reference["U_test"]);
  int cases = 0;
  for (const auto& c : reference["cases"]) {
    ++cases;
    SCOPED_TRACE(c["kernel"].get<std::string>() + " " + c["basis"].get<std::string>());
    const double sf = c["sigma_f"];
    const double sn = c["sigma_n"];
    Kernel kernel = kernel_of(c);
    Hyperparameters given{vector_of(c["length_scales"]), sf * sf, sn * sn};
    if (!c["rq_alpha"].is_null()) given.alpha = c["rq_alpha"];
    if (given.length_scales[0] == given.length_scales[1]) {  // the isotropic kernel says the same
      kernel.length_scales = LengthScales::shared;
      given.length_scales.conservativeResize(1);
    }
    const GaussianProcess gp = GaussianProcess::with_parameters(
        x, y, opt::unit_cube(2), given,
        {.kernel = kernel, .basis = basis_of(c), .estimator = Estimator::ml});
    const double expected = c["log_likelihood_profile_beta"];
    EXPECT_NEAR(-gp.negative_log_likelihood(), expected, kTight * std::abs(expected));
    const Vector beta = vector_of(c["beta"]);
    ASSERT_EQ(gp.coefficients().size(), beta.size());
    for (Eigen::Index i = 0; i < beta.size(); ++i)
      EXPECT_NEAR(gp.coefficients()[i], beta[i], kTight * beta.cwiseAbs().maxCoeff());
    const std::vector<Gaussian> predicted = gp.predict_rows(test_points);
    const Vector mean = vector_of(c["mean"]);
    const Vector sd = vector_of(c["sd_latent_with_beta_uncertainty"]);
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      const Gaussian& p = predicted[static_cast<std::size_t>(i)];
      EXPECT_NEAR(p.mean, mean[i], kTight * std::abs(mean[i]));
      EXPECT_NEAR(p.standard_deviation(), sd[i], kTight * sd[i]);
    }
  }
  EXPECT_EQ(cases, 40);
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

// The Gaussian process tuned as a black box.
#include "repose/surrogate/tuning.hpp"

#include <gtest/gtest.h>

#include "gp_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::smooth_function;
using test::uniform_points;

const TuningOptions kQuick{.evaluations = 14};

TEST(TunedModel, PredictsWhatTheBestOfItsTrialsDidInCrossValidation) {
  const Matrix x = uniform_points(60, 3, 5);
  const Vector y = at_rows(x, smooth_function);
  const auto inputs = linear_inputs(opt::unit_cube(3));
  const Tuning tuning = tune_model(x, y, inputs, {}, kQuick);
  ASSERT_EQ(tuning.trials.size(), 14U);
  const TuningTrial& best = tuning.trials[tuning.best];
  EXPECT_TRUE(best.failure.empty());
  EXPECT_NEAR(std::sqrt(tuning.model.noise_variance()), best.noise_standard_deviation,
              1e-9 * best.noise_standard_deviation);
  const Matrix q = uniform_points(400, 3, 6);
  const Vector truth = at_rows(q, smooth_function);
  double square = 0.0;
  const auto predicted = tuning.model.predict_rows(q);
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    square += std::pow(predicted[static_cast<std::size_t>(i)].mean - truth[i], 2);
  // more rows than a fold's fit had, and other ones: the same order of magnitude
  EXPECT_LT(std::sqrt(square / 400.0), 3.0 * best.rmse + 1e-3);
  EXPECT_LT(best.rmse, 0.2);  // the function's own deviation is 0.8
}

// A shared length scale in standardised inputs is one for each input in natural units.
TEST(TunedModel, OfASharedScaleIsTheSameModelOverTheDeclaredInputs) {
  Matrix x = uniform_points(30, 2, 8);
  x.col(1) *= 40.0;
  const Vector y = (5.0 * x.col(0).array()).sin() + 0.01 * x.col(1).array().square();
  const std::vector<Input> inputs{{.lower = 0.0, .upper = 1.0}, {.lower = 0.0, .upper = 40.0}};
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Tuning tuning =
        tune_model(x, y, inputs, {}, {.evaluations = 6, .initial_points = 6, .seed = seed});
    const TuningTrial& best = tuning.trials[tuning.best];
    if (best.kernel.length_scales != LengthScales::shared) continue;
    const Vector scales = tuning.model.hyperparameters().length_scales;
    ASSERT_EQ(scales.size(), 2);
    const auto sd = [&](Eigen::Index k) {
      const double mean = x.col(k).mean();
      return std::sqrt((x.col(k).array() - mean).square().sum() / 29.0);
    };
    for (Eigen::Index k = 0; k < 2; ++k)
      EXPECT_NEAR(scales[k], best.kernel_scale * (best.standardised ? sd(k) : 1.0),
                  1e-9 * scales[k]);
    return;
  }
  FAIL() << "no seed chose a kernel with a shared length scale";
}

TEST(TunedModel, IsTheSameForAnyNumberOfThreads) {
  const Matrix x = uniform_points(25, 2, 3);
  const Vector y = at_rows(x, smooth_function);
  const auto inputs = linear_inputs(opt::unit_cube(2));
  TuningOptions options{.evaluations = 7};
  const Tuning one = tune_model(x, y, inputs, {}, options);
  options.threads = 4;
  const Tuning four = tune_model(x, y, inputs, {}, options);
  for (std::size_t i = 0; i < one.trials.size(); ++i)
    EXPECT_EQ(one.trials[i].rmse, four.trials[i].rmse);
  EXPECT_EQ(one.model.predict(Vector{{0.3, 0.4}}).mean,
            four.model.predict(Vector{{0.3, 0.4}}).mean);
}

TEST(TunedModel, LeavesGroupsOutWholeAndRefusesFewerGroupsThanFolds) {
  const Matrix x = uniform_points(20, 2, 3);
  const Vector y = at_rows(x, smooth_function);
  const auto inputs = linear_inputs(opt::unit_cube(2));
  std::vector<Eigen::Index> groups;
  for (Eigen::Index i = 0; i < 20; ++i) groups.push_back(i % 4);
  EXPECT_THROW(tune_model(x, y, inputs, {}, {.evaluations = 4, .groups = groups}), InputError);
  const Tuning tuning =
      tune_model(x, y, inputs, {}, {.evaluations = 4, .folds = 4, .groups = groups});
  EXPECT_EQ(tuning.trials.size(), 4U);
  EXPECT_THROW(tune_model(x, y, inputs, {}, {.evaluations = 1}), InputError);
  EXPECT_THROW(tune_model(x, Vector::Zero(3), inputs), InputError);
}

}  // namespace
}  // namespace repose::surrogate

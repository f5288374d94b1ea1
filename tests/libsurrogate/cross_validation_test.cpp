// Cross-validation: folds, figures, and that nothing of what is predicted reaches the fit.
#include "repose/surrogate/cross_validation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "regression_data.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/regression_diagnostics.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/linear_model.hpp"
#include "repose/surrogate/perceptron.hpp"

namespace repose::surrogate {
namespace {

using test::smooth_data;

/// Predicts the mean of its training rows, with their variance.
struct MeanModel {
  double mean = 0.0;
  double variance = 0.0;
  std::vector<Input> input_list = {};
  Vector predict(const Matrix& x) const { return Vector::Constant(x.rows(), mean); }
  Predictions predict_with_variances(const Matrix& x) const {
    return {predict(x), Vector::Zero(x.rows()), Vector::Constant(x.rows(), variance)};
  }
  const std::vector<Input>& inputs() const { return input_list; }
  std::string describe() const { return "mean"; }
};

Trainer mean_trainer() {
  return {"mean", [](const TrainingSet& data, std::uint64_t) {
            const double mean = data.y.mean();
            return Regressor(MeanModel{mean, (data.y.array() - mean).square().mean(), data.inputs});
          }};
}

TEST(KFolds, PredictEveryRowOnceInEachRepetition) {
  const TrainingSet data = smooth_data(23, 2);
  const auto folds = k_folds(data, {.folds = 5, .repetitions = 3});
  ASSERT_EQ(folds.size(), 15u);
  for (int r = 0; r < 3; ++r) {
    std::vector<int> tested(23, 0);
    for (const Fold& fold : folds) {
      if (fold.repetition != r) continue;
      EXPECT_TRUE(fold.test.size() == 4 || fold.test.size() == 5);
      std::set<Eigen::Index> all(fold.train.begin(), fold.train.end());
      all.insert(fold.test.begin(), fold.test.end());
      EXPECT_EQ(all.size(), 23u);
      EXPECT_EQ(fold.train.size() + fold.test.size(), 23u);
      for (const auto i : fold.test) ++tested[static_cast<std::size_t>(i)];
    }
    EXPECT_EQ(tested, std::vector<int>(23, 1));
  }
  EXPECT_NE(folds[0].test, folds[5].test);
  EXPECT_EQ(folds[0].test, k_folds(data, {.folds = 5}).front().test);
  EXPECT_NE(folds[0].test, k_folds(data, {.folds = 5, .seed = 2}).front().test);
}

TEST(KFolds, NeverDivideTheRepeatsOfAPoint) {
  TrainingSet by_number = smooth_data(40, 2);
  for (Eigen::Index i = 0; i < 40; ++i) by_number.replicates.push_back(i / (i < 12 ? 3 : 2));
  TrainingSet by_values = smooth_data(40, 2);
  for (Eigen::Index i = 20; i < 40; ++i) by_values.x.row(i) = by_values.x.row(i - 20);
  for (const TrainingSet& data : {by_number, by_values})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const auto points = points_of(data);
      std::vector<Eigen::Index> fold_of_point(points.size(), -1);
      const auto folds = k_folds(data, {.folds = 4, .seed = seed});
      for (std::size_t f = 0; f < folds.size(); ++f)
        for (const auto i : folds[f].test) {
          auto& fold = fold_of_point[static_cast<std::size_t>(points[static_cast<std::size_t>(i)])];
          EXPECT_TRUE(fold == -1 || fold == static_cast<Eigen::Index>(f));
          fold = static_cast<Eigen::Index>(f);
        }
    }
}

TEST(KFolds, RefuseMoreFoldsThanPoints) {
  TrainingSet data = smooth_data(6, 2);
  EXPECT_THROW(k_folds(data, {.folds = 7}), InputError);
  EXPECT_THROW(k_folds(data, {.folds = 1}), InputError);
  EXPECT_THROW(k_folds(data, {.folds = 2, .repetitions = 0}), InputError);
  data.replicates = {0, 0, 0, 1, 1, 1};
  EXPECT_THROW(k_folds(data, {.folds = 3}), InputError);
  EXPECT_EQ(k_folds(data, {.folds = 2}).size(), 2u);
}

TEST(LeaveGroupOut, LeavesEachGroupOutWholeUnderItsName) {
  TrainingSet data = smooth_data(7, 2);
  data.groups = {2, 0, 2, 0, 1, 2, 0};
  const auto folds = leave_group_out(data, {"a", "b", "c"});
  ASSERT_EQ(folds.size(), 3u);
  EXPECT_EQ(folds[0].name, "a");
  EXPECT_EQ(folds[0].test, (std::vector<Eigen::Index>{1, 3, 6}));
  EXPECT_EQ(folds[1].test, (std::vector<Eigen::Index>{4}));
  EXPECT_EQ(folds[1].train, (std::vector<Eigen::Index>{0, 1, 2, 3, 5, 6}));
  data.groups.assign(7, 3);
  EXPECT_THROW(leave_group_out(data), InputError);
  data.groups = {};
  EXPECT_THROW(leave_group_out(data), InputError);
}

TEST(Metrics, AreWhatTheirEquationsSay) {
  const Vector y{{1.0, 2.0, 4.0}}, p{{2.0, 2.0, 2.0}}, q{{-1.0, -2.0, -4.0}};
  const Metrics m = metrics_of(y, p, Vector{{1.0, 1.0, 4.0}});
  EXPECT_DOUBLE_EQ(m.rmse, std::sqrt(5.0 / 3.0));
  EXPECT_DOUBLE_EQ(m.mae, 1.0);
  EXPECT_NEAR(m.r2, 1.0 - 5.0 / (14.0 / 3.0), 1e-15);
  EXPECT_TRUE(std::isnan(m.squared_correlation));  // a constant prediction
  EXPECT_DOUBLE_EQ(m.negative_log_density,
                   (1.5 * std::log(2.0 * std::numbers::pi) + 0.5 + 0.5 + std::log(2.0)) / 3.0);
  const Metrics wrong_sign = metrics_of(y, q);
  EXPECT_DOUBLE_EQ(wrong_sign.squared_correlation, 1.0);
  EXPECT_LT(wrong_sign.r2, -10.0);
  EXPECT_TRUE(std::isnan(wrong_sign.negative_log_density));
  EXPECT_TRUE(std::isnan(metrics_of(Vector{{1.0}}, Vector{{1.5}}).r2));
  EXPECT_THROW(metrics_of(y, Vector{{1.0}}), InputError);
}

TEST(Metrics, CountAWeightAsRepeats) {
  const Vector y{{1.0, 2.0, 4.0}}, p{{1.5, 2.5, 3.0}}, v{{1.0, 2.0, 4.0}};
  const std::vector<Eigen::Index> rows{0, 0, 0, 1, 2, 2};
  const Metrics a = metrics_of(y, p, v, Vector{{3.0, 1.0, 2.0}});
  const Metrics b = metrics_of(y(rows), p(rows), v(rows));
  EXPECT_NEAR(a.rmse, b.rmse, 1e-14);
  EXPECT_NEAR(a.mae, b.mae, 1e-14);
  EXPECT_NEAR(a.r2, b.r2, 1e-14);
  EXPECT_NEAR(a.squared_correlation, b.squared_correlation, 1e-14);
  EXPECT_NEAR(a.negative_log_density, b.negative_log_density, 1e-14);
  EXPECT_THROW(metrics_of(y, p, v, Vector{{1.0, 2.0}}), InputError);
}

TEST(CrossValidate, WeighsTheErrorsOfWeightedRows) {
  TrainingSet data = smooth_data(8, 1);
  data.weights = Vector::LinSpaced(8, 1.0, 8.0);
  const auto result = cross_validate(data, mean_trainer(), k_folds(data, {.folds = 4}));
  const Vector error = data.y - result.predicted.col(0);
  EXPECT_NEAR(result.metrics.rmse, std::sqrt(error.cwiseAbs2().dot(data.weights) / 36.0), 1e-14);
}

TEST(CrossValidate, OfTheMeanOneByOneHasAClosedForm) {
  const TrainingSet data = smooth_data(12, 1);
  const auto result = cross_validate(data, mean_trainer(), k_folds(data, {.folds = 12}));
  const double mean = data.y.mean();
  for (Eigen::Index i = 0; i < 12; ++i)  // mean of the others = (n mean - y)/(n - 1)
    EXPECT_NEAR(result.predicted(i, 0), (12.0 * mean - data.y[i]) / 11.0, 1e-14);
  const double press = std::pow(12.0 / 11.0, 2) * (data.y.array() - mean).square().sum();
  EXPECT_NEAR(result.metrics.rmse, std::sqrt(press / 12.0), 1e-14);
  EXPECT_NEAR(result.metrics.r2, 1.0 - 144.0 / 121.0, 1e-13);
  EXPECT_EQ(result.metrics.rows, 12);
}

TEST(CrossValidate, OfALinearModelOneByOneIsPress) {
  const TrainingSet data = smooth_data(20, 3);
  const auto result =
      cross_validate(data, linear_model_trainer("linear"), k_folds(data, {.folds = 20}));
  Matrix design(20, 4);
  design << Vector::Ones(20), data.x;
  const auto twin = doe::diagnose_regression(design, data.y);
  EXPECT_LT((result.predicted.col(0) - twin.left_out).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_NEAR(result.metrics.r2, twin.predicted_r_squared, 1e-12);
}

TEST(CrossValidate, LetsNothingOfTheLeftOutRowsReachTheFit) {
  TrainingSet data = smooth_data(30, 2);
  for (Eigen::Index i = 0; i < 30; ++i) data.groups.push_back(i % 3);
  const auto folds = leave_group_out(data);
  for (const Trainer& trainer :
       {mean_trainer(), linear_model_trainer("linear"), perceptron_trainer("network")}) {
    const auto before = cross_validate(data, trainer, folds);
    TrainingSet changed = data;
    for (const auto i : folds[1].test) changed.y[i] = 1e3 * changed.y[i] - 7.0;
    const auto after = cross_validate(changed, trainer, folds);
    EXPECT_EQ(Vector(before.predicted(folds[1].test, 0)),
              Vector(after.predicted(folds[1].test, 0)));
    EXPECT_NE(Vector(before.predicted(folds[0].test, 0)),
              Vector(after.predicted(folds[0].test, 0)));
  }
}

TEST(CrossValidate, TakesUndeclaredRangesFromTheTrainingRows) {
  TrainingSet data = smooth_data(20, 2);
  data.inputs[0].upper = 50.0;
  std::vector<std::vector<Input>> seen;
  const Trainer spy{"spy", [&seen](const TrainingSet& train, std::uint64_t) {
                      seen.push_back(train.inputs);
                      return Regressor(MeanModel{0.0, 1.0, train.inputs});
                    }};
  const auto folds = k_folds(data, {.folds = 4});
  cross_validate(data, with_ranges_of_training_rows(spy, {false, true}), folds);
  for (std::size_t f = 0; f < 4; ++f) {
    const Vector column = data.x(folds[f].train, 1);
    EXPECT_EQ(seen[f][0].upper, 50.0);
    EXPECT_EQ(seen[f][1].lower, column.minCoeff());
    EXPECT_EQ(seen[f][1].upper, column.maxCoeff());
  }
}

TEST(CrossValidate, GivesTheSameBitsForAnyNumberOfThreads) {
  const TrainingSet data = smooth_data(30, 2);
  const auto folds = k_folds(data, {.folds = 5, .repetitions = 2});
  const std::vector<Trainer> trainers{linear_model_trainer("linear"),
                                      perceptron_trainer("network", {.networks = 1})};
  const auto one = cross_validate(data, trainers, folds, {.threads = 1});
  for (const unsigned threads : {2u, 8u}) {
    const auto many = cross_validate(data, trainers, folds, {.threads = threads});
    for (std::size_t t = 0; t < 2; ++t) {
      EXPECT_EQ(one[t].predicted, many[t].predicted);
      EXPECT_EQ(one[t].metrics.rmse, many[t].metrics.rmse);
    }
  }
  EXPECT_EQ(cross_validate(data, trainers[1], folds).predicted, one[1].predicted);
}

TEST(CrossValidate, MakesAFailedFoldARowThatSaysWhy) {
  const TrainingSet data = smooth_data(12, 1);
  const auto folds = k_folds(data, {.folds = 3});
  const double poison = data.x(folds[1].test[0], 0);  // in the training rows of the other two
  const double large = data.x(folds[2].test[0], 0);
  const Trainer picky{"picky", [=](const TrainingSet& train, std::uint64_t) {
                        if ((train.x.array() == poison).any() && (train.x.array() == large).any())
                          throw InputError("never both");
                        const bool bad = (train.x.array() == large).any();
                        return Regressor(MeanModel{bad ? std::nan("") : 1.0, 1.0, train.inputs});
                      }};
  const auto result = cross_validate(data, picky, folds);
  EXPECT_EQ(result.failed_folds, 2);
  EXPECT_EQ(result.folds[0].failure, "never both");
  EXPECT_EQ(result.folds[1].failure, "a prediction is not finite");
  EXPECT_EQ(result.folds[2].failure, "");
  for (std::size_t f = 0; f < 3; ++f)
    for (const auto i : folds[f].test) EXPECT_EQ(std::isnan(result.predicted(i, 0)), f != 2);
  EXPECT_EQ(result.metrics.rows, static_cast<Eigen::Index>(folds[2].test.size()));
}

TEST(CrossValidate, NotesConstantResponsesAndUnseenLevels) {
  TrainingSet data = smooth_data(6, 2);
  data.inputs[1] = {.levels = {"a", "b"}};
  data.x.col(1) = Vector{{0, 0, 0, 0, 0, 1}};
  data.y = Vector{{2, 2, 2, 2, 2, 9}};
  data.groups = {0, 0, 1, 1, 1, 2};
  const auto result = cross_validate(data, linear_model_trainer("linear"), leave_group_out(data));
  EXPECT_EQ(result.folds[0].note, "");
  EXPECT_EQ(result.folds[2].note,
            "the response is 2 in all training rows; no training row has level 'b' of input 2");
  EXPECT_EQ(result.failed_folds, 0);
  EXPECT_NEAR(result.predicted(5, 0), 2.0, 1e-12);
  EXPECT_TRUE(std::isnan(result.folds[2].metrics.r2));  // a group with one row
}

TEST(CrossValidate, OfAFixedGaussianProcessEqualsItsClosedForm) {
  TrainingSet data = smooth_data(30, 3, 0.1);
  const Hyperparameters given{Vector{{0.4, 0.8, 1.1}}, 0.9, 0.02};
  const Trainer fixed{"fixed", [&given](const TrainingSet& train, std::uint64_t) {
                        return Regressor(GaussianProcessRegressor(GaussianProcess::with_parameters(
                            train.x, train.y, train.inputs, given)));
                      }};
  const auto folds = k_folds(data, {.folds = 6, .repetitions = 2});
  const auto slow = cross_validate(data, fixed, folds);
  const auto fast = cross_validate_fixed(data, fixed.fit(data, 1), folds);
  EXPECT_LT((slow.predicted - fast.predicted).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT((slow.variance - fast.variance).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_NEAR(slow.metrics.negative_log_density, fast.metrics.negative_log_density, 1e-9);
  EXPECT_NEAR(slow.folds[3].metrics.rmse, fast.folds[3].metrics.rmse, 1e-10);
  auto incomplete = folds;
  incomplete.pop_back();
  EXPECT_THROW(cross_validate_fixed(data, fixed.fit(data, 1), incomplete), InputError);
  EXPECT_THROW(cross_validate_fixed(data, mean_trainer().fit(data, 1), folds), InputError);
}

TEST(CrossValidate, RefusesFoldsThatDoNotFitTheRows) {
  const TrainingSet data = smooth_data(5, 1);
  EXPECT_THROW(cross_validate(data, mean_trainer(), {}), InputError);
  EXPECT_THROW(cross_validate(data, mean_trainer(), {{.name = "a", .train = {0}, .test = {7}}}),
               InputError);
  EXPECT_THROW(cross_validate(data, mean_trainer(), {{.name = "a", .train = {0}, .test = {}}}),
               InputError);
}

}  // namespace
}  // namespace repose::surrogate

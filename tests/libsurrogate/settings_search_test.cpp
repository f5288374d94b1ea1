// The search of settings finds them, and sees nothing of what is left out around it.
#include "repose/surrogate/settings_search.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "regression_data.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace repose::surrogate {
namespace {

using test::smooth_data;

/// y = slope x, whatever the data are; slopes above 4 cannot be fitted.
struct Line {
  double slope = 0.0;
  std::vector<Input> input_list = {};
  Vector predict(const Matrix& x) const { return slope * x.col(0); }
  const std::vector<Input>& inputs() const { return input_list; }
  std::string describe() const { return "line"; }
};

ModelFamily lines() {
  return {.name = "lines",
          .space =
              [](const TrainingSet&) {
                return ParameterSpace({{.name = "slope", .lower = 0.0, .upper = 5.0}});
              },
          .trainer =
              [](const Vector& s) {
                return Trainer{"line", [slope = s[0]](const TrainingSet& data, std::uint64_t) {
                                 if (slope > 4.0) throw InputError("too steep");
                                 return Regressor(Line{slope, data.inputs});
                               }};
              }};
}

TrainingSet line_data() {
  TrainingSet data = smooth_data(30, 1);
  RandomStream random(4);
  for (Eigen::Index i = 0; i < 30; ++i) data.y[i] = 2.0 * data.x(i, 0) + 0.01 * random.normal();
  return data;
}

TEST(SettingsSearch, FindsTheSlopeThatMadeTheData) {
  const SettingsSearch search = search_settings(line_data(), lines(), {.evaluations = 20});
  ASSERT_EQ(search.trials.size(), 20u);
  const SettingsTrial& best = search.trials[search.best];
  // noise of 0.01 over 30 rows with x up to 1 knows the slope to 0.004; the model of log MSE is
  // flat where the noise takes over, |slope - 2| rms(x) < 0.01
  EXPECT_NEAR(best.settings[0], 2.0, 0.04);
  EXPECT_LT(best.rmse, 0.03);
  for (const SettingsTrial& trial : search.trials)
    EXPECT_EQ(trial.failure, trial.settings[0] > 4.0 ? "too steep" : "");
}

TEST(SettingsSearch, SaysWhyNoSettingCouldBeFitted) {
  ModelFamily steep = lines();
  steep.space = [](const TrainingSet&) {
    return ParameterSpace({{.name = "slope", .lower = 4.5, .upper = 5.0}});
  };
  try {
    search_settings(line_data(), steep, {.evaluations = 4});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("too steep"), std::string::npos);
  }
  EXPECT_THROW(search_settings(line_data(), lines(), {.evaluations = 3}), InputError);
  EXPECT_THROW(search_settings(line_data(), lines(), {.folds = 31}), InputError);
}

TEST(SettingsSearch, OfAGaussianProcessRefusesWeights) {
  TrainingSet data = line_data();
  data.weights = Vector::Ones(30);
  try {
    search_settings(data, gaussian_process_family(), {.evaluations = 2, .initial_points = 2});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("takes no weights"), std::string::npos);
  }
}

TEST(SettingsSearch, IsTheSameForAnyNumberOfThreads) {
  const TrainingSet data = smooth_data(30, 2);
  const auto one = search_settings(data, svr_family(), {.evaluations = 8});
  const auto four = search_settings(data, svr_family(), {.evaluations = 8, .threads = 4});
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(one.trials[i].settings, four.trials[i].settings);
    EXPECT_EQ(one.trials[i].rmse, four.trials[i].rmse);
  }
  EXPECT_EQ(one.best, four.best);
}

TEST(SettingsSearch, NamesItsSettings) {
  const ParameterSpace space = svr_family().space({});
  EXPECT_EQ(settings_text(space, Vector{{3.0, 0.5, 0.125, 2.0, 1.0}}),
            "kernel gaussian, box_constraint 0.5, epsilon 0.125, kernel_scale 2, standardise true");
}

class NestedCrossValidation : public ::testing::TestWithParam<const char*> {
 protected:
  static ModelFamily family() {
    const std::string name = GetParam();
    if (name == "svr") return svr_family();
    if (name == "network") return perceptron_family();
    if (name == "tree") return tree_family();
    if (name == "ensemble") return ensemble_family();
    return gaussian_process_family();
  }
};

// Responses of the outer test rows are changed beyond recognition: the settings chosen without
// them, and the predictions at them, stay the same to the bit.
TEST_P(NestedCrossValidation, LetsNothingOfAnOuterGroupReachItsInnerChoice) {
  TrainingSet data = smooth_data(24, 2);
  for (Eigen::Index i = 0; i < 24; ++i) data.groups.push_back(i % 3);
  const auto folds = leave_group_out(data);
  const Trainer nested = searching_trainer("nested", family(), {.evaluations = 6, .folds = 4});
  const CrossValidation before = cross_validate(data, nested, folds);
  TrainingSet changed = data;
  for (const auto i : folds[1].test) changed.y[i] = 1e3 * std::sin(changed.y[i]) - 7.0;
  const CrossValidation after = cross_validate(changed, nested, folds);
  EXPECT_EQ(before.failed_folds, 0);
  EXPECT_EQ(before.folds[1].description, after.folds[1].description);
  EXPECT_EQ(Vector(before.predicted(folds[1].test, 0)), Vector(after.predicted(folds[1].test, 0)));
  // the other outer folds do train on these rows: the test would see a leak
  EXPECT_NE(Vector(before.predicted(folds[0].test, 0)), Vector(after.predicted(folds[0].test, 0)));
}

INSTANTIATE_TEST_SUITE_P(Families, NestedCrossValidation,
                         ::testing::Values("svr", "network", "tree", "ensemble",
                                           "gaussian_process"));

TEST(NestedCrossValidation, IsTheSameForAnyNumberOfThreads) {
  TrainingSet data = smooth_data(24, 2);
  for (Eigen::Index i = 0; i < 24; ++i) data.groups.push_back(i % 3);
  const Trainer nested = searching_trainer("nested", svr_family(), {.evaluations = 6, .folds = 4});
  const auto folds = leave_group_out(data);
  EXPECT_EQ(cross_validate(data, nested, folds, {.threads = 1}).predicted,
            cross_validate(data, nested, folds, {.threads = 3}).predicted);
}

}  // namespace
}  // namespace repose::surrogate

// Models of any kind as values: wrapped, trained, saved.
#include "repose/surrogate/regressor.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

#include "gp_data.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/surrogate/sensitivity.hpp"
#include "repose/table/io.hpp"

namespace repose::surrogate {
namespace {

/// A model of a user, without variances.
struct FirstInput {
  std::vector<Input> names = std::vector<Input>(2);
  Vector predict(const Matrix& x) const { return x.col(0); }
  const std::vector<Input>& inputs() const { return names; }
  std::string describe() const { return "the first input"; }
};

TrainingSet sample() {
  const Matrix x = test::uniform_points(30, 3, 5);
  return {.x = x, .y = test::at_rows(x, test::smooth_function), .inputs = std::vector<Input>(3)};
}

class RegressorFile : public testing::Test {
 protected:
  ~RegressorFile() override { std::filesystem::remove(path_); }
  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                ("repose_regressor_" + std::to_string(::getpid()) + ".h5");
};

TEST(Regressor, HoldsAnyModelThatPredicts) {
  const Regressor model = FirstInput();
  EXPECT_EQ(model.predict(Matrix{{3.0, 1.0}, {4.0, 1.0}}), (Vector{{3.0, 4.0}}));
  EXPECT_EQ(model.dimension(), 2);
  EXPECT_EQ(model.describe(), "the first input");
  EXPECT_NE(model.target<FirstInput>(), nullptr);
  EXPECT_EQ(gaussian_process(model), nullptr);
}

TEST(Regressor, WithoutVariancesGivesMeansAlone) {
  const Regressor model = FirstInput();
  EXPECT_FALSE(model.has_variances());
  const Predictions p = model.predict_with_variances(Matrix{{3.0, 1.0}});
  EXPECT_EQ(p.mean, Vector{{3.0}});
  EXPECT_EQ(p.function_variance.size(), 0);
  EXPECT_EQ(p.observation_variance.size(), 0);
}

TEST(GaussianProcessTrainer, FitsTheModelOfItsOptionsAndSeed) {
  const TrainingSet data = sample();
  const Trainer trainer = gaussian_process_trainer("gpr", {.basis = Basis::linear});
  EXPECT_EQ(trainer.name, "gpr");
  const Regressor model = trainer.fit(data, 3);
  const auto direct =
      GaussianProcess::fit(data.x, data.y, data.inputs, {.basis = Basis::linear, .seed = 3});
  const Matrix probe = test::uniform_points(20, 3, 8);
  const Predictions p = model.predict_with_variances(probe);
  const auto expected = direct.predictions(probe);
  EXPECT_EQ(p.mean, model.predict(probe));
  for (Eigen::Index i = 0; i < probe.rows(); ++i) {
    const Prediction& e = expected[static_cast<std::size_t>(i)];
    EXPECT_EQ(p.mean[i], e.function.mean);
    EXPECT_EQ(p.function_variance[i], e.function.variance);
    EXPECT_EQ(p.observation_variance[i], e.observation_variance);
  }
  ASSERT_NE(gaussian_process(model), nullptr);
  EXPECT_EQ(gaussian_process(model)->basis(), Basis::linear);
}

TEST(GaussianProcessTrainer, RefusesWhatItCannotWeigh) {
  EXPECT_THROW(gaussian_process_trainer("gpr", {.noise = Noise::known}), InputError);
  TrainingSet data = sample();
  data.weights = Vector::Ones(30);
  EXPECT_THROW(gaussian_process_trainer("gpr").fit(data, 1), InputError);
}

TEST(TrainingSet, SelectsRowsWithAllThatBelongsToThem) {
  TrainingSet data = sample();
  data.weights = Vector::LinSpaced(30, 1.0, 30.0);
  for (Eigen::Index i = 0; i < 30; ++i) {
    data.groups.push_back(i / 10);
    data.replicates.push_back(i / 2);
  }
  const std::vector<Eigen::Index> rows{29, 0, 29};
  const TrainingSet some = selected_rows(data, rows);
  EXPECT_EQ(some.x.row(0), data.x.row(29));
  EXPECT_EQ(some.y[1], data.y[0]);
  EXPECT_EQ(some.weights, (Vector{{30.0, 1.0, 30.0}}));
  EXPECT_EQ(some.groups, (std::vector<Eigen::Index>{2, 0, 2}));
  EXPECT_EQ(some.replicates, (std::vector<Eigen::Index>{14, 0, 14}));
  EXPECT_NO_THROW(check(some));
}

TEST(TrainingSet, NamesTheRowThatIsWrong) {
  const auto message = [](auto change) -> std::string {
    TrainingSet data = sample();
    change(data);
    try {
      check(data);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message([](TrainingSet&) {}), "no error");
  EXPECT_NE(message([](TrainingSet& d) { d.x(4, 1) = NAN; }).find("row 5, input 2"),
            std::string::npos);
  EXPECT_NE(message([](TrainingSet& d) { d.y[6] = INFINITY; }).find("row 7"), std::string::npos);
  EXPECT_NE(message([](TrainingSet& d) { d.y.resize(3); }).find("3 responses"), std::string::npos);
  EXPECT_NE(message([](TrainingSet& d) { d.groups = {1}; }).find("1 groups"), std::string::npos);
  EXPECT_NE(message([](TrainingSet& d) {
              d.weights = Vector::Ones(30);
              d.weights[2] = 0.0;
            }).find("row 3, weight is 0"),
            std::string::npos);
  EXPECT_NE(message([](TrainingSet& d) { d.inputs.pop_back(); }).find("3 columns for 2 inputs"),
            std::string::npos);
  EXPECT_NE(message([](TrainingSet& d) { d.x.resize(0, 3), d.y.resize(0); }).find("no rows"),
            std::string::npos);
}

/// 3 a + 4 b^2 on the unit cube, c without effect.
struct Additive {
  std::vector<Input> all = std::vector<Input>(3);
  Vector predict(const Matrix& x) const {
    return 3.0 * x.col(0).array() + 4.0 * x.col(1).array().square();
  }
  const std::vector<Input>& inputs() const { return all; }
  std::string describe() const { return "additive"; }
};

// variances 9/12 and 16 (1/5 - 1/9); the tolerance is the error of 1024 quasi-random points
TEST(Regressor, HasTheSobolIndicesOfItsFunction) {
  const auto indices = sobol_indices(Regressor(Additive()));
  const double a = 9.0 / 12.0;
  const double b = 16.0 * (1.0 / 5.0 - 1.0 / 9.0);
  EXPECT_NEAR(indices[0].first.value, a / (a + b), 0.01);
  EXPECT_NEAR(indices[1].total.value, b / (a + b), 0.01);
  EXPECT_LT(indices[1].first.lower, indices[1].first.upper);
  EXPECT_NEAR(indices[2].total.value, 0.0, 1e-12);
}

TEST(Regressor, HasPartialDependenceWithoutIntervals) {
  const auto dependence = partial_dependence(Regressor(Additive()), 1, {.points = 1024, .grid = 3});
  EXPECT_EQ(dependence.x, (std::vector<double>{0.0, 0.5, 1.0}));
  EXPECT_NEAR(dependence.mean[1] - dependence.mean[0], 1.0, 1e-12);
  EXPECT_NEAR(dependence.mean[2] - dependence.mean[0], 4.0, 1e-12);
  EXPECT_NEAR(dependence.mean[0], 1.5, 0.01);
  EXPECT_TRUE(dependence.lower.empty());
}

TEST(Regressor, ThatIsAGaussianProcessKeepsItsIntervals) {
  const Regressor model = gaussian_process_trainer("gpr").fit(sample(), 1);
  const auto direct = sobol_indices(*gaussian_process(model), {.points = 64, .draws = 20});
  const auto indices = sobol_indices(model, {.points = 64, .draws = 20});
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(indices[k].total.upper, direct[k].total.upper);
  EXPECT_EQ(partial_dependence(model, 0).lower,
            partial_dependence(*gaussian_process(model), 0).lower);
}

TEST_F(RegressorFile, HoldsAGaussianProcessLikeAnyOtherModel) {
  const TrainingSet data = sample();
  const Regressor model = gaussian_process_trainer("gpr").fit(data, 1);
  save_regressor(path_, {model, {"a", "b", "c"}, "y"});
  const NamedRegressor loaded = load_regressor(path_);
  EXPECT_EQ(loaded.inputs, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(loaded.response, "y");
  EXPECT_EQ(loaded.model.predict(data.x), model.predict(data.x));
  EXPECT_EQ(load_model(path_).model.predict_rows(data.x)[0].mean, model.predict(data.x)[0]);
}

TEST_F(RegressorFile, IsNotWrittenForAModelWithoutFormat) {
  EXPECT_THROW(save_regressor(path_, {FirstInput(), {"a", "b"}, "y"}), InputError);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(RegressorFile, NamesAKindThatIsNotKnown) {
  table::Table t;
  t.add({.name = "a", .values = std::vector<double>{1.0}});
  table::write_tables(
      path_, {{"/inputs", t}},
      {{"repose_model", std::string("oracle")}, {"model_version", std::int64_t{1}}});
  try {
    load_regressor(path_);
    FAIL() << "no error";
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("'oracle'"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("gaussian-process"), std::string::npos);
  }
}

}  // namespace
}  // namespace repose::surrogate

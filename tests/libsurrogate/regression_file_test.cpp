// Linear models, support vector regressions and perceptrons come back from files to the bit.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "regression_data.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/linear_model.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/surrogate/perceptron.hpp"
#include "repose/surrogate/support_vector_regression.hpp"
#include "repose/table/io.hpp"

namespace repose::surrogate {
namespace {

using test::smooth_data;

/// Three inputs, one of them a category, one on a log scale.
TrainingSet mixed_data() {
  TrainingSet data = smooth_data(40, 3);
  data.inputs[1] = {.levels = {"layered", "mixed", "segregated"}};
  for (Eigen::Index i = 0; i < 40; ++i) data.x(i, 1) = static_cast<double>(i % 3);
  data.inputs[2] = {.lower = 0.001, .upper = 2.0, .scale = Scale::log};
  data.x.col(2) = data.x.col(2).array() + 0.01;
  return data;
}

std::filesystem::path file_of_this_test() {
  return std::filesystem::temp_directory_path() /
         (std::string("repose_regression_") +
          ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
          std::to_string(::getpid()) + ".h5");
}

std::vector<Trainer> all_trainers() {
  return {linear_model_trainer("linear"),
          linear_model_trainer("robust", {.method = LinearMethod::robust}),
          linear_model_trainer("interactions", {.terms = LinearTerms::interactions}),
          linear_model_trainer(
              "stepwise", {.terms = LinearTerms::interactions, .method = LinearMethod::stepwise}),
          svr_trainer("linear", {.kernel = SvrKernel::linear}),
          svr_trainer("cubic", {.kernel = SvrKernel::cubic}),
          svr_trainer("gaussian", {.standardisation = Standardisation::none}),
          perceptron_trainer("network", {.layers = {6, 4}, .networks = 2})};
}

void expect_same_after_loading(const TrainingSet& data) {
  const auto path = file_of_this_test();
  const Matrix& x = data.x;
  for (const Trainer& trainer : all_trainers()) {
    const Regressor model = trainer.fit(data, 3);
    save_regressor(path, {model, {"a", "b", "c"}, "y"});
    const NamedRegressor loaded = load_regressor(path);
    EXPECT_EQ(loaded.inputs, (std::vector<std::string>{"a", "b", "c"}));
    EXPECT_EQ(loaded.model.describe(), model.describe());
    EXPECT_EQ(loaded.model.predict(x), model.predict(x)) << trainer.name;
    const Predictions before = model.predict_with_variances(x);
    const Predictions after = loaded.model.predict_with_variances(x);
    ASSERT_EQ(after.observation_variance.size(), before.observation_variance.size());
    for (Eigen::Index i = 0; i < before.observation_variance.size(); ++i)
      EXPECT_TRUE(
          after.observation_variance[i] == before.observation_variance[i] ||
          (std::isnan(after.observation_variance[i]) && std::isnan(before.observation_variance[i])))
          << trainer.name;
  }
  std::filesystem::remove(path);
}

TEST(RegressionFile, GivesBackEveryKindToTheBit) {
  expect_same_after_loading(mixed_data());
}

TEST(RegressionFile, GivesBackModelsOfAConstant) {
  TrainingSet data = mixed_data();
  data.y.setConstant(0.3);
  expect_same_after_loading(data);
}

TEST(RegressionFile, GivesBackModelsWithoutADegreeOfFreedom) {
  const TrainingSet data = mixed_data();
  const std::vector<Eigen::Index> rows{0, 1, 2, 3};
  expect_same_after_loading(selected_rows(data, rows));
}

TEST(RegressionFile, DoesNotTakeAModelThatLostATableForAConstant) {
  const auto path = file_of_this_test();
  const std::vector<std::pair<std::size_t, const char*>> cases{{5, "/support_vectors"},
                                                               {7, "/parameters"}};
  for (const auto& [trainer, lost] : cases) {
    save_regressor(path, {all_trainers()[trainer].fit(mixed_data(), 1), {"a", "b", "c"}, "y"});
    const auto attributes = table::read_attributes({path, "/"});
    std::vector<std::pair<std::string, table::Table>> tables;
    for (const auto& name : table::list_tables(path))
      if (name != lost) tables.emplace_back(name, table::read_table({path, name}));
    table::write_tables(path, tables, attributes);
    EXPECT_THROW(load_regressor(path), StorageError) << lost;
  }
  std::filesystem::remove(path);
}

TEST(RegressionFile, RefusesADamagedModelByTheNameOfItsFile) {
  const auto path = file_of_this_test();
  const auto damage_of = [&path](const char* group, const char* column) {
    const auto attributes = table::read_attributes({path, "/"});
    std::vector<std::pair<std::string, table::Table>> tables;
    for (const auto& name : table::list_tables(path)) {
      table::Table t = table::read_table({path, name});
      if (name == group) {
        table::Table changed;
        for (const auto& c : t.columns())
          if (c.name != column) changed.add(c);
        t = changed;
      }
      if (!t.columns().empty()) tables.emplace_back(name, t);
    }
    table::write_tables(path, tables, attributes);
    try {
      load_regressor(path);
    } catch (const StorageError& error) {
      return std::string(error.what());
    }
    return std::string("loaded");
  };
  const std::vector<std::pair<const char*, const char*>> places{
      {"/terms", "coefficient"}, {"/root", "values"},    {"/support_vectors", "u2"},
      {"/columns", "factor"},    {"/layers", "neurons"}, {"/parameters", "network1"}};
  const std::vector<std::size_t> trainer{0, 0, 5, 5, 7, 7};
  for (std::size_t i = 0; i < places.size(); ++i) {
    save_regressor(path, {all_trainers()[trainer[i]].fit(mixed_data(), 1), {"a", "b", "c"}, "y"});
    EXPECT_NE(damage_of(places[i].first, places[i].second).find(path.string()), std::string::npos)
        << places[i].first;
  }
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace repose::surrogate

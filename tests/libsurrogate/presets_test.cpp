// The models of the thesis' Table 4.2.
#include "repose/surrogate/presets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "regression_data.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/cross_validation.hpp"

namespace repose::surrogate {
namespace {

using test::smooth_data;

const SettingsSearchOptions kQuick{.evaluations = 5, .folds = 3};

TEST(ModelPresets, AreTheTwentyNineRowsOfTheThesisAndOurs) {
  std::map<std::string, int> rows;
  int searched = 0;
  for (const ModelPreset& preset : model_presets()) {
    ++rows[preset.group];
    searched += preset.searched ? 1 : 0;
    EXPECT_EQ(preset.searched, preset.name.starts_with("optimisable-")) << preset.name;
  }
  EXPECT_EQ(rows, (std::map<std::string, int>{{"Linear Regression", 4},
                                              {"Regression Tree", 4},
                                              {"SVM", 7},
                                              {"Ensemble of Trees", 3},
                                              {"GPR", 5},
                                              {"ANN", 6},
                                              {"repose", 1}}));
  EXPECT_EQ(searched, 5);
}

class EveryPreset : public ::testing::TestWithParam<ModelPreset> {};

TEST_P(EveryPreset, LearnsFromMixedInputsUnderItsName) {
  TrainingSet data = smooth_data(60, 3);
  data.inputs[2] = {.levels = {"layered", "mixed"}};
  for (Eigen::Index i = 0; i < 60; ++i) data.x(i, 2) = static_cast<double>(i % 2);
  data.y = 3.0 * data.x.col(0) + data.x.col(2) + 0.1 * data.y;
  const Trainer trainer = preset_trainer(GetParam().name, kQuick);
  EXPECT_EQ(trainer.name, GetParam().name);
  const CrossValidation result = cross_validate(data, trainer, k_folds(data, {.folds = 3}));
  for (const FoldResult& fold : result.folds) EXPECT_EQ(fold.failure, "");
  // leaves of 36 of 40 rows cannot be
  EXPECT_GT(result.metrics.r2, GetParam().name == "coarse-tree" ? -0.2 : 0.3);
}

INSTANTIATE_TEST_SUITE_P(Zoo, EveryPreset, ::testing::ValuesIn(model_presets()),
                         [](const auto& param) {
                           std::string name = param.param.name;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(ModelPresets, SuggestTheNameThatWasMeant) {
  const auto message_of = [](const std::string& name) {
    try {
      preset_trainer(name);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message_of("linaer"), "there is no model 'linaer'; did you mean linear?");
  EXPECT_NE(message_of("quantum").find("optimisable-ensemble"), std::string::npos);
}

}  // namespace
}  // namespace repose::surrogate

// Model files: the same bits after loading, and no file that is not one.
#include "repose/surrogate/model_file.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstring>
#include <fstream>

#include "gp_data.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/table/io.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::smooth_function;
using test::uniform_points;

class ModelFile : public testing::Test {
 protected:
  ModelFile() {
    std::filesystem::create_directories(directory_);
    x_.bottomRows(5) = x_.topRows(5);  // repeats
    y_ = at_rows(x_, smooth_function);
    RandomStream random(2);
    for (double& value : y_) value = 1e3 + 0.1 * value + 0.01 * random.normal();
    x_.col(1) *= 1e6;
  }
  ~ModelFile() override { std::filesystem::remove_all(directory_); }

  GaussianProcess fitted(const GaussianProcessOptions& options = {}) const {
    return GaussianProcess::fit(x_, y_, box_, options);
  }
  NamedModel saved_and_loaded(const GaussianProcess& model) const {
    save_model(path_, {model, {"mu_s", "young_modulus_pa", "c_r"}, "angle_of_repose_deg"});
    return load_model(path_);
  }
  void expect_same_bits(const GaussianProcess& a, const GaussianProcess& b) const {
    Matrix probe = uniform_points(200, 3, 9);
    probe.col(1) *= 1e6;
    const std::vector<Gaussian> pa = a.predict_rows(probe);
    const std::vector<Gaussian> pb = b.predict_rows(probe);
    EXPECT_EQ(0, std::memcmp(pa.data(), pb.data(), pa.size() * sizeof(Gaussian)));
    EXPECT_EQ(a.negative_log_likelihood(), b.negative_log_likelihood());
    EXPECT_EQ(a.leave_one_out().residual, b.leave_one_out().residual);
    const Vector at = probe.row(0);
    EXPECT_EQ(a.condition_on(at, 1e3).predict(probe.row(1)).mean,
              b.condition_on(at, 1e3).predict(probe.row(1)).mean);
  }
  NamedModel saved_and_loaded_as(const NamedModel& named) const {
    save_model(path_, named);
    return load_model(path_);
  }
  static void expect_same_bits_at(const GaussianProcess& a, const GaussianProcess& b,
                                  const Matrix& x) {
    const std::vector<Gaussian> pa = a.predict_rows(x);
    const std::vector<Gaussian> pb = b.predict_rows(x);
    EXPECT_EQ(0, std::memcmp(pa.data(), pb.data(), pa.size() * sizeof(Gaussian)));
  }
  std::string message_of_loading() const {
    try {
      load_model(path_);
    } catch (const StorageError& error) {
      return error.what();
    }
    return "no StorageError";
  }

  std::filesystem::path directory_ =
      std::filesystem::temp_directory_path() / ("repose_model_file_" + std::to_string(::getpid()));
  std::filesystem::path path_ = directory_ / "model.h5";
  Matrix x_ = uniform_points(40, 3, 1);
  Vector y_;
  opt::Bounds box_{Vector::Zero(3), Vector{{1.0, 1e6, 1.0}}};
};

TEST_F(ModelFile, ALoadedModelPredictsTheSameBits) {
  int i = 0;
  for (const Kernel kernel : all_kernels()) {
    const GaussianProcess gp = fitted({.kernel = kernel,
                                       .basis = static_cast<Basis>(i % 4),
                                       .estimator = static_cast<Estimator>(i % 3),
                                       .starts = 1});
    expect_same_bits(gp, saved_and_loaded(gp).model);
    ++i;
  }
}

TEST_F(ModelFile, KeepsLogScalesCategoriesNoiseAndTransformedResponses) {
  for (double& level : x_.col(2)) level = std::floor(3.0 * level);
  for (const Coding coding : {Coding::label, Coding::one_hot, Coding::exchangeable}) {
    const std::vector<Input> inputs{
        {},
        {.lower = 1.0, .upper = 1e6, .scale = Scale::log},
        {.levels = {"sphere", "clump", "tetrahedron"}, .coding = coding}};
    for (const Noise noise : {Noise::known, Noise::by_point}) {
      GaussianProcessOptions options{
          .noise = noise, .response_scale = ResponseScale::log, .starts = 1};
      if (noise == Noise::known) options.noise_variances = Vector::LinSpaced(40, 0.01, 0.1);
      const auto gp = GaussianProcess::fit(x_, y_, inputs, options);
      const NamedModel loaded = saved_and_loaded(gp);
      EXPECT_EQ(loaded.model.inputs()[2].levels, inputs[2].levels);
      EXPECT_EQ(loaded.model.inputs()[2].coding, coding);
      EXPECT_EQ(loaded.model.inputs()[1].scale, Scale::log);
      EXPECT_EQ(loaded.model.noise(), noise);
      const Vector at{{0.3, 2e5, 1.0}};
      EXPECT_EQ(gp.predict(at).mean, loaded.model.predict(at).mean);
      EXPECT_EQ(gp.predict(at).variance, loaded.model.predict(at).variance);
      EXPECT_EQ(gp.negative_log_likelihood(), loaded.model.negative_log_likelihood());
      EXPECT_EQ(gp.leave_one_out().log_density, loaded.model.leave_one_out().log_density);
    }
  }
}

TEST_F(ModelFile, AsksForTheRegressionFunctionsOfItsUser) {
  const BasisFunctions wave{{"wave"},
                            [](const Vector& x) { return Vector{{std::sin(7.0 * x[0])}}; }};
  const GaussianProcess gp = fitted({.functions = wave, .starts = 1});
  save_model(path_, {gp, {"a", "b", "c"}, "y"});
  EXPECT_THROW(load_model(path_), InputError);
  EXPECT_THROW(load_model(path_, {{"other"}, wave.evaluate}), InputError);
  expect_same_bits(gp, load_model(path_, wave).model);
}

// written by repose before version 2, with the predictions it gave for its own points
TEST_F(ModelFile, ReadsVersionOne) {
  const std::string directory = std::string(REPOSE_TEST_DATA) + "/gp/";
  const NamedModel old = load_model(directory + "model_version_1.h5");
  EXPECT_EQ(old.inputs, (std::vector<std::string>{"mu_s", "young_modulus_pa"}));
  const table::Table expected = table::read_csv(directory + "model_version_1_predictions.csv");
  const std::vector<Gaussian> predicted =
      old.model.predict_rows(expected.matrix({"mu_s", "young_modulus_pa"}));
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    // another processor may round otherwise; magnified by the condition, up to 15/1.6e-8
    EXPECT_NEAR(predicted[i].mean, expected.numbers("angle_deg_predicted")[i], 1e-8 * 40);
    EXPECT_NEAR(predicted[i].standard_deviation(), expected.numbers("angle_deg_function_sd")[i],
                1e-7);  // a root of a difference of numbers near the process variance
  }
  expect_same_bits_at(old.model, saved_and_loaded_as(old).model, expected.matrix(old.inputs));
}

TEST_F(ModelFile, KeepsAConditionedModelAndOneWithGivenParameters) {
  const GaussianProcess grown = fitted().condition_on(Vector{{0.5, 5e5, 0.5}}, 1000.0);
  expect_same_bits(grown, saved_and_loaded(grown).model);
  const auto given =
      GaussianProcess::with_parameters(x_, y_, box_, {Vector{{0.3, 1e5, 1.0 / 3.0}}, 0.7, 0.01});
  expect_same_bits(given, saved_and_loaded(given).model);
}

TEST_F(ModelFile, KeepsNamesOptionsAndReport) {
  const GaussianProcess gp =
      fitted({.kernel = {Correlation::squared_exponential}, .estimator = Estimator::ml});
  const NamedModel loaded = saved_and_loaded(gp);
  EXPECT_EQ(loaded.inputs, (std::vector<std::string>{"mu_s", "young_modulus_pa", "c_r"}));
  EXPECT_EQ(loaded.response, "angle_of_repose_deg");
  EXPECT_EQ(loaded.model.kernel(), Kernel{Correlation::squared_exponential});
  EXPECT_EQ(loaded.model.estimator(), Estimator::ml);
  EXPECT_EQ(loaded.model.noise(), Noise::estimated);
  EXPECT_EQ(loaded.model.declared_bounds().upper, box_.upper);
  EXPECT_EQ(loaded.model.hyperparameters().length_scales, gp.hyperparameters().length_scales);
  const FitReport& a = gp.report();
  const FitReport& b = loaded.model.report();
  EXPECT_EQ(a.message, b.message);
  EXPECT_EQ(a.instruction_set, b.instruction_set);
  EXPECT_FALSE(a.instruction_set.empty());
  EXPECT_EQ(a.termination, b.termination);
  EXPECT_EQ(a.evaluations, b.evaluations);
  ASSERT_EQ(a.parameters.size(), b.parameters.size());
  for (std::size_t i = 0; i < a.parameters.size(); ++i) {
    EXPECT_EQ(a.parameters[i].name, b.parameters[i].name);
    EXPECT_EQ(a.parameters[i].value, b.parameters[i].value);
    EXPECT_EQ(a.parameters[i].state, b.parameters[i].state);
    EXPECT_EQ(a.parameters[i].relevance, b.parameters[i].relevance);
  }
}

TEST_F(ModelFile, RefusesNamesThatDoNotFit) {
  EXPECT_THROW(save_model(path_, {fitted(), {"one"}, "y"}), InputError);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(ModelFile, NamesAFileThatIsMissingOrNoModel) {
  EXPECT_NE(message_of_loading().find("model.h5"), std::string::npos);
  write_file_atomically(path_, "not HDF5");
  EXPECT_NE(message_of_loading().find("model.h5"), std::string::npos);
  table::Table t;
  t.add({.name = "a", .values = std::vector<double>{1.0}});
  table::write_table({path_, "/points"}, t);
  EXPECT_NE(message_of_loading().find("no model"), std::string::npos);
}

TEST_F(ModelFile, RefusesANewerVersionAndEveryMissingPart) {
  saved_and_loaded(fitted());
  const table::Attributes attributes = table::read_attributes({path_, "/"});
  std::vector<std::pair<std::string, table::Table>> parts;
  for (const char* group :
       {"/inputs", "/points", "/rows", "/length_scales", "/factor", "/parameter_uncertainty"})
    parts.emplace_back(group, table::read_table({path_, group}));

  table::Attributes newer = attributes;
  newer["model_version"] = std::int64_t{4};
  table::write_tables(path_, parts, newer);
  EXPECT_NE(message_of_loading().find("version is 4"), std::string::npos);
  for (std::size_t missing = 0; missing < parts.size(); ++missing) {
    auto some = parts;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(missing));
    table::write_tables(path_, some, attributes);
    EXPECT_NE(message_of_loading(), "no StorageError") << parts[missing].first;
  }
  for (const char* name :
       {"kernel", "shift", "amplitude", "variance_factor", "uncertain_directions", "fit_message"}) {
    table::Attributes fewer = attributes;
    fewer.erase(name);
    table::write_tables(path_, parts, fewer);
    EXPECT_NE(message_of_loading().find(name), std::string::npos);
  }
  auto shorter = parts;
  shorter[4].second = shorter[4].second.selected_rows({0, 1, 2});
  table::write_tables(path_, shorter, attributes);
  EXPECT_NE(message_of_loading().find("wrong length"), std::string::npos);
  shorter = parts;
  shorter[5].second = shorter[5].second.selected_rows({0});
  table::write_tables(path_, shorter, attributes);
  EXPECT_NE(message_of_loading().find("a row for each parameter"), std::string::npos);
}

}  // namespace
}  // namespace repose::surrogate

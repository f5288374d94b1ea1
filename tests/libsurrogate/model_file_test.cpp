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
  for (const Kernel kernel : {Kernel::squared_exponential, Kernel::matern52})
    for (const Basis basis : {Basis::none, Basis::constant})
      for (const Estimator estimator : {Estimator::ml, Estimator::reml}) {
        const GaussianProcess gp =
            fitted({.kernel = kernel, .basis = basis, .estimator = estimator, .starts = 1});
        expect_same_bits(gp, saved_and_loaded(gp).model);
      }
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
      fitted({.kernel = Kernel::squared_exponential, .estimator = Estimator::ml});
  const NamedModel loaded = saved_and_loaded(gp);
  EXPECT_EQ(loaded.inputs, (std::vector<std::string>{"mu_s", "young_modulus_pa", "c_r"}));
  EXPECT_EQ(loaded.response, "angle_of_repose_deg");
  EXPECT_EQ(loaded.model.kernel(), Kernel::squared_exponential);
  EXPECT_EQ(loaded.model.estimator(), Estimator::ml);
  EXPECT_EQ(loaded.model.noise(), Noise::estimated);
  EXPECT_EQ(loaded.model.declared_bounds().upper, box_.upper);
  EXPECT_EQ(loaded.model.hyperparameters().length_scales, gp.hyperparameters().length_scales);
  const FitReport& a = gp.report();
  const FitReport& b = loaded.model.report();
  EXPECT_EQ(a.message, b.message);
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
  EXPECT_NE(message_of_loading().find("no Gaussian process"), std::string::npos);
}

TEST_F(ModelFile, RefusesANewerVersionAndEveryMissingPart) {
  saved_and_loaded(fitted());
  const table::Attributes attributes = table::read_attributes({path_, "/"});
  std::vector<std::pair<std::string, table::Table>> parts;
  for (const char* group : {"/inputs", "/points", "/rows", "/factor"})
    parts.emplace_back(group, table::read_table({path_, group}));

  table::Attributes newer = attributes;
  newer["model_version"] = std::int64_t{2};
  table::write_tables(path_, parts, newer);
  EXPECT_NE(message_of_loading().find("version is 2"), std::string::npos);
  for (std::size_t missing = 0; missing < parts.size(); ++missing) {
    auto some = parts;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(missing));
    table::write_tables(path_, some, attributes);
    EXPECT_NE(message_of_loading(), "no StorageError") << parts[missing].first;
  }
  for (const char* name : {"kernel", "shift", "amplitude", "fit_message"}) {
    table::Attributes fewer = attributes;
    fewer.erase(name);
    table::write_tables(path_, parts, fewer);
    EXPECT_NE(message_of_loading().find(name), std::string::npos);
  }
  auto shorter = parts;
  shorter[3].second = shorter[3].second.selected_rows({0, 1, 2});
  table::write_tables(path_, shorter, attributes);
  EXPECT_NE(message_of_loading().find("wrong length"), std::string::npos);
}

}  // namespace
}  // namespace repose::surrogate

// Model files of trees: the same bits after loading, and no walk out of a damaged one.
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>

#include "repose/base/error.hpp"
#include "repose/surrogate/bagged_trees.hpp"
#include "repose/surrogate/boosted_trees.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/io.hpp"
#include "tree_data.hpp"

namespace repose::surrogate {
namespace {

using test::mixed_sample;

class TreeFile : public testing::Test {
 protected:
  ~TreeFile() override { std::filesystem::remove(path_); }
  Regressor loaded(const Regressor& model) const {
    save_regressor(path_, {model, {"a", "b", "c", "d"}, "y"});
    return load_regressor(path_).model;
  }
  /// The file again with an attribute changed.
  void set(const std::string& name, std::int64_t value) const {
    auto attributes = table::read_attributes({path_, "/"});
    attributes[name] = value;
    std::vector<std::pair<std::string, table::Table>> tables;
    for (const auto& group : table::list_tables(path_))
      tables.emplace_back(group, table::read_table({path_, group}));
    table::write_tables(path_, tables, attributes);
  }
  /// The file again without a table.
  void remove(const std::string& group) const {
    const auto attributes = table::read_attributes({path_, "/"});
    std::vector<std::pair<std::string, table::Table>> tables;
    for (const auto& name : table::list_tables(path_))
      if (name != group) tables.emplace_back(name, table::read_table({path_, name}));
    table::write_tables(path_, tables, attributes);
  }
  /// The file again with a table changed.
  template <class Change>
  void damage(const std::string& group, Change change) const {
    const auto attributes = table::read_attributes({path_, "/"});
    std::vector<std::pair<std::string, table::Table>> tables;
    for (const auto& name : table::list_tables(path_)) {
      table::Table t = table::read_table({path_, name});
      if (name == group) {
        table::Table changed;
        for (table::Column c : t.columns()) {
          change(c);
          changed.add(c);
        }
        t = changed;
      }
      tables.emplace_back(name, t);
    }
    table::write_tables(path_, tables, attributes);
  }
  void expect_refused(const std::string& column, std::size_t row, std::int64_t value) const {
    save_regressor(path_, {bag_, {"a", "b", "c", "d"}, "y"});
    damage(column == "root" || column == "depth" ? "/trees" : "/nodes", [&](table::Column& c) {
      if (c.name == column) std::get<std::vector<std::int64_t>>(c.values).at(row) = value;
    });
    EXPECT_THROW(load_regressor(path_), StorageError) << column << " " << value;
  }

  std::filesystem::path path_ = std::filesystem::temp_directory_path() /
                                ("repose_tree_file_" + std::to_string(::getpid()) + ".h5");
  TrainingSet data_ = mixed_sample(80, 1);
  Matrix probe_ = mixed_sample(200, 2).x;
  BaggedTrees bag_ = BaggedTrees::fit(data_, {.trees = 5, .seed = 9});
};

TEST_F(TreeFile, HoldsATree) {
  const auto tree = RegressionTree::fit(data_, {.minimum_leaf = 2, .maximum_splits = 30});
  const Regressor again = loaded(tree);
  EXPECT_EQ(again.predict(probe_), tree.predict(probe_));
  EXPECT_EQ(again.describe(), tree.describe());
  EXPECT_EQ(again.inputs()[3].levels, data_.inputs[3].levels);
}

TEST_F(TreeFile, HoldsABagWithItsVariances) {
  const Regressor again = loaded(bag_);
  const Predictions a = bag_.predict_with_variances(probe_);
  const Predictions b = again.predict_with_variances(probe_);
  EXPECT_EQ(a.mean, b.mean);
  EXPECT_EQ(a.function_variance, b.function_variance);
  EXPECT_EQ(a.observation_variance, b.observation_variance);
  EXPECT_EQ(again.describe(), bag_.describe());
  const auto* bag = again.target<BaggedTrees>();
  ASSERT_NE(bag, nullptr);
  EXPECT_EQ(bag->out_of_bag().rmse, bag_.out_of_bag().rmse);
  EXPECT_EQ(bag->out_of_bag().predicted.array().isNaN().count(),
            bag_.out_of_bag().predicted.array().isNaN().count());
  EXPECT_EQ(bag->importance(data_)[0].increase, bag_.importance(data_)[0].increase);
}

TEST_F(TreeFile, HoldsBoostedTreesAndAConstant) {
  const auto boosted = BoostedTrees::fit(data_, {.trees = 40, .stopping = Stopping::k_fold});
  const Regressor again = loaded(boosted);
  EXPECT_EQ(again.predict(probe_), boosted.predict(probe_));
  EXPECT_EQ(again.target<BoostedTrees>()->held_out_rmse(), boosted.held_out_rmse());
  TrainingSet constant = data_;
  constant.y.setConstant(2.0);
  EXPECT_EQ(loaded(BoostedTrees::fit(constant)).predict(probe_), Vector::Constant(200, 2.0));
  EXPECT_EQ(loaded(BaggedTrees::fit(constant)).predict(probe_), Vector::Constant(200, 2.0));
}

TEST_F(TreeFile, RefusesNodesThatLeadAnywhere) {
  expect_refused("left", 0, 0);
  expect_refused("left", 0, -5);
  expect_refused("left", 0, 1LL << 40);
  expect_refused("left", 1, 0);
  expect_refused("input", 0, 4);
  expect_refused("root", 1, 100000);
  expect_refused("root", 0, 1);
  expect_refused("root", 1, 0);
  expect_refused("depth", 0, 1);
  expect_refused("depth", 0, -1);
  expect_refused("depth", 0, (1LL << 31) - 1);  // a walk takes as many steps
  const auto nodes = table::read_table({path_, "/nodes"});
  const auto input = nodes.integers("input");
  const auto category = std::find(input.begin(), input.end(), 3) - input.begin();
  ASSERT_LT(category, static_cast<std::ptrdiff_t>(input.size()));
  expect_refused("level_set", static_cast<std::size_t>(category), -1);
  expect_refused("level_set", static_cast<std::size_t>(category), 1LL << 40);
}

TEST_F(TreeFile, RefusesMorePointsThanRows) {
  save_regressor(path_, {bag_, {"a", "b", "c", "d"}, "y"});
  set("points", 80);
  EXPECT_EQ(load_regressor(path_).model.predict(probe_), bag_.predict(probe_));
  set("points", 81);
  EXPECT_THROW(load_regressor(path_), StorageError);
  set("points", 1LL << 40);
  EXPECT_THROW(load_regressor(path_), StorageError);
}

TEST_F(TreeFile, RefusesBoostedTreesWithoutTheirTrees) {
  save_regressor(path_, {BoostedTrees::fit(data_, {.trees = 10}), {"a", "b", "c", "d"}, "y"});
  ASSERT_NO_THROW(load_regressor(path_));
  remove("/trees");
  EXPECT_THROW(load_regressor(path_), StorageError);
}

TEST_F(TreeFile, IsNotTakenForAGaussianProcess) {
  save_regressor(path_, {bag_, {"a", "b", "c", "d"}, "y"});
  try {
    load_model(path_);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("5 bagged trees"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("Gaussian process"), std::string::npos);
  }
}

}  // namespace
}  // namespace repose::surrogate

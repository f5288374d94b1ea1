// repose fit, predict and sensitivity with trees, as a user runs them.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace repose::test {
namespace {

using nlohmann::json;

/// 60 rows of two numbers, a shape and a material; y = 4 a + 2 for clumps.
std::string runs() {
  std::string csv = "a,b,shape,material,y\n";
  const char* shapes[] = {"sphere", "clump", "cube"};
  for (int i = 0; i < 60; ++i) {
    const double a = std::fmod(0.5 + 0.7548776662 * i, 1.0);
    const double b = std::fmod(0.5 + 0.5698402910 * i, 1.0);
    char line[120];
    std::snprintf(line, sizeof line, "%.6f,%.6f,%s,m%d,%.6f\n", a, b, shapes[i % 3], i % 4,
                  4.0 * a + (i % 3 == 1 ? 2.0 : 0.0));
    csv += line;
  }
  return csv;
}

json fitted(const Workbench& bench, const std::string& options) {
  bench.write("runs.csv", runs());
  const auto said = bench.run(
      "repose", "fit runs.csv --response y --input a,b,shape -o m.h5 --json --model " + options);
  EXPECT_EQ(said.code, 0) << said.err;
  return said.code == 0 ? json::parse(said.out) : json();
}

TEST(FitCommand, FitsTreesAndJudgesThemByRowsLeftOut) {
  const Workbench bench;
  const json tree = fitted(bench, "tree --minimum-leaf 2");
  EXPECT_EQ(tree.at("left_out"), "rows (10 folds)");
  EXPECT_GT(tree.at("q2"), 0.9);
  const json bag = fitted(bench, "bagged-trees --trees 40");
  EXPECT_EQ(bag.at("left_out"), "rows out of bag");
  EXPECT_GT(bag.at("q2"), 0.9);
  EXPECT_EQ(bag.at("description"), "40 bagged trees, minimum leaf 1");
  const json boosted =
      fitted(bench, "boosted-trees --stop-early k-fold --learning-rate 0.2 --group material");
  EXPECT_EQ(boosted.at("left_out"), "groups");
  EXPECT_GT(boosted.at("q2"), 0.9);
  for (const json& fit : {tree, bag, boosted}) {
    ASSERT_EQ(fit.at("importance").size(), 3u);
    EXPECT_EQ(fit["importance"][0]["input"], "a");
    EXPECT_EQ(fit["importance"][1]["input"], "shape");
  }
}

TEST(FitCommand, JudgesABagOfOneTree) {
  const Workbench bench;
  const json bag = fitted(bench, "bagged-trees --trees 1");
  EXPECT_EQ(bag.at("left_out"), "rows out of bag");
  ASSERT_EQ(bag.at("importance").size(), 3u);
  EXPECT_EQ(bag["importance"][0]["input"], "a");
  EXPECT_GT(bag["importance"][0]["increase"], 1.0);
}

// as many folds inside as there are points: no refit without some of these can have them
TEST(FitCommand, SaysWhichFoldsFailed) {
  const Workbench bench;
  const std::string model = "boosted-trees --stop-early k-fold --folds 60 --trees 3";
  const json fit = fitted(bench, model);
  EXPECT_TRUE(fit.at("q2").is_null());
  EXPECT_EQ(fit.at("failed_folds"), 10);
  const std::string failure = fit.at("first_failure");
  EXPECT_EQ(failure.find("fold 1: "), 0u) << failure;
  EXPECT_NE(failure.find("60 folds"), std::string::npos) << failure;
  const auto said =
      bench.run("repose", "fit runs.csv --response y --input a,b,shape -o m.h5 --model " + model);
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("without 10 of 10 folds, which failed; fold 1: "), std::string::npos)
      << said.out;
  EXPECT_EQ(fitted(bench, "tree").at("failed_folds"), 0);
}

TEST(PredictCommand, DoesNotCareWhichModelItIs) {
  const Workbench bench;
  for (const char* model : {"tree", "bagged-trees", "boosted-trees", "gpr"}) {
    fitted(bench, model);
    const auto said = bench.run("repose", "predict m.h5 runs.csv -o p.csv --json");
    ASSERT_EQ(said.code, 0) << said.err;
    const json p = json::parse(said.out);
    ASSERT_EQ(p.at("predicted").size(), 60u);
    EXPECT_NEAR(p["predicted"][0].get<double>(), 2.0, 0.5) << model;  // 4 x 0.5, a sphere
    EXPECT_EQ(p["outside_range"][0], 0);
    const bool has_variance = std::string(model) == "bagged-trees" || std::string(model) == "gpr";
    EXPECT_EQ(p.contains("observation_sd"), has_variance) << model;
    EXPECT_EQ(p.contains("function_sd"), has_variance) << model;
  }
}

TEST(SensitivityCommand, TellsSharesOfATreeModel) {
  const Workbench bench;
  fitted(bench, "boosted-trees");
  const auto said = bench.run("repose", "sensitivity m.h5 -o s.h5 --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const json inputs = json::parse(said.out).at("inputs");
  // variances 16/12 and 4 (1/3)(2/3); steps of trees and 1024 points
  const double a = 16.0 / 12.0;
  const double shape = 8.0 / 9.0;
  EXPECT_NEAR(inputs[0]["first"]["value"].get<double>(), a / (a + shape), 0.05);
  EXPECT_NEAR(inputs[2]["first"]["value"].get<double>(), shape / (a + shape), 0.05);
  EXPECT_EQ(inputs[0]["partial_dependence"]["mean"].size(), 21u);
  EXPECT_TRUE(inputs[0]["partial_dependence"]["lower"].empty());
}

TEST(TreeModels, SayWhatTheyCannotDo) {
  const Workbench bench;
  fitted(bench, "bagged-trees");
  const auto fails = [&](const std::string& command, const std::string& word) {
    const auto said = bench.run("repose", command);
    EXPECT_EQ(said.code, 3) << command;
    EXPECT_NE(said.err.find(word), std::string::npos) << said.err;
  };
  fails("sample m.h5 -o n.h5", "needs a Gaussian process");
  fails("optimise m.h5 -o n.h5", "needs a Gaussian process");
  fails("predict m.h5 runs.csv -o p.csv --gradient", "--gradient needs a Gaussian process");
  const std::string fit = "fit runs.csv --response y --input a,b,shape -o n.h5 ";
  fails(fit + "--model tree --kernel matern52", "--kernel");
  fails(fit + "--model tree --trees 5", "--trees");
  fails(fit + "--model bagged-trees --learning-rate 0.5", "--learning-rate");
  fails(fit + "--trees 5", "--trees");
  fails(fit + "--model tree --predictors 4", "4 predictors");
  fails(fit + "--model boosted-trees --learning-rate 0", "learning rate is 0");
  fails(fit + "--model boosted-trees --stop-early k-fold --folds 61", "61 folds");
}

}  // namespace
}  // namespace repose::test

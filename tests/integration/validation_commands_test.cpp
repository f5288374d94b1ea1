// repose compare and cv, as a user runs them.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace repose::test {
namespace {

using nlohmann::json;

/// 40 rows of two numbers and a text in four materials, one of which has a single row.
std::string runs() {
  std::string csv = "mu_s,mu_r,shape,material,laboratory,angle_deg,flat\n";
  const char* shapes[] = {"sphere", "clump"};
  for (int i = 0; i < 40; ++i) {
    const double u = std::fmod(0.5 + 0.6180339887 * i, 1.0);
    const double v = std::fmod(0.25 + 0.7548776662 * i, 1.0);
    const double angle =
        25.0 + 8.0 * v + std::sin(4.0 * u) + 2.0 * (i % 2) * u + 0.02 * ((i * 7) % 5 - 2);
    char line[200];
    std::snprintf(line, sizeof line, "%.6f,%.6f,%s,%s,delft,%.6f,3\n", u, v, shapes[i % 2],
                  i == 0 ? "rare" : (i % 3 == 0 ? "a" : (i % 3 == 1 ? "b" : "c")), angle);
    csv += line;
  }
  return csv;
}

const char* const kTable = " runs.csv --response angle_deg --input mu_s,mu_r,shape --json ";

json said(const Workbench& bench, const std::string& arguments) {
  const auto result = bench.run("repose", arguments);
  EXPECT_EQ(result.code, 0) << result.err;
  return result.code == 0 ? json::parse(result.out) : json();
}

/// Without what depends on the clock.
json timeless(json value) {
  if (value.is_object())
    for (const char* key :
         {"training_seconds", "prediction_seconds", "fit_seconds", "predictions_per_second"})
      value.erase(key);
  for (auto& part : value)
    if (part.is_structured()) part = timeless(part);
  return value;
}

TEST(CompareCommand, PutsTheBestModelFirst) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const json result = said(bench, std::string("compare") + kTable +
                                      "--model linear,fine-gaussian-svm,gpr,narrow-network "
                                      "--figures figures");
  const json& models = result["models"];
  ASSERT_EQ(models.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(models[i]["rows"], 40);
    EXPECT_EQ(models[i]["failure"], "");
    EXPECT_EQ(models[i]["folds"].size(), 5u);
    EXPECT_GT(models[i]["predictions_per_second"], 0.0);
    if (i > 0) {
      EXPECT_GE(models[i]["rmse"], models[i - 1]["rmse"]);
    }
    const std::string name = models[i]["model"];
    EXPECT_TRUE(std::filesystem::exists(bench / ("figures/" + name + ".svg"))) << name;
    EXPECT_EQ(models[i]["negative_log_density"].is_null(), name != "linear" && name != "gpr");
  }
  EXPECT_EQ(models[0]["model"], "gpr");  // of a smooth function
}

TEST(CompareCommand, GivesTheSameNumbersForAnyNumberOfThreads) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const std::string command = std::string("compare") + kTable +
                              "--model narrow-network,optimisable-svm --optimise 5 --threads ";
  EXPECT_EQ(timeless(said(bench, command + "1")), timeless(said(bench, command + "3")));
}

TEST(CompareCommand, LeavesEachGroupOut) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const json result =
      said(bench, std::string("compare") + kTable + "--model stepwise-linear --group material");
  const json& folds = result["models"][0]["folds"];
  ASSERT_EQ(folds.size(), 4u);
  EXPECT_EQ(folds[0]["name"], "rare");
  EXPECT_EQ(folds[0]["rows"], 1);
  EXPECT_TRUE(folds[0]["r2"].is_null());  // of a single row
  EXPECT_EQ(folds[1]["name"], "b");
}

TEST(CvCommand, SearchesInsideEachOuterFold) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const json result =
      said(bench, std::string("cv") + kTable +
                      "--model gpr,linear --outer kfold:3x2 --inner kfold:4 --optimise 5");
  ASSERT_EQ(result["models"].size(), 2u);
  const json& searched = result["models"][0];
  EXPECT_EQ(searched["model"], "optimisable-gpr");
  EXPECT_EQ(result["models"][1]["model"], "linear");
  ASSERT_EQ(searched["folds"].size(), 6u);
  EXPECT_EQ(searched["rows"], 80);
  EXPECT_EQ(searched["folds"][3]["name"], "repetition 2, fold 1");
  EXPECT_NE(searched["folds"][0]["model"], "");
}

TEST(CvCommand, SaysInWordsWhatItDoesInJson) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const auto result =
      bench.run("repose",
                "cv runs.csv --response angle_deg --input mu_s,mu_r --model linear --outer "
                "leave-group-out:material");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("all rows together"), std::string::npos);
  EXPECT_NE(result.out.find("rare"), std::string::npos);
}

TEST(CvCommand, NotesAConstantResponse) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  const json result =
      said(bench,
           "cv runs.csv --response flat --input mu_s,mu_r --model linear,medium-gaussian-svm,"
           "narrow-network --json");
  for (const auto& model : result["models"]) {
    EXPECT_EQ(model["failed_folds"], 0);
    EXPECT_LT(model["rmse"], 1e-12);
    EXPECT_TRUE(model["r2"].is_null());
    EXPECT_EQ(model["folds"][0]["note"], "the response is 3 in all training rows");
  }
}

TEST(FitCommand, FitsAnyModelOfTheComparison) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  for (const std::string model : {"stepwise-linear", "cubic-svm", "narrow-network --seed 3",
                                  "optimisable-svm --optimise 5"}) {
    const json fit = said(bench, std::string("fit") + kTable + "-o m.h5 --model " + model);
    EXPECT_EQ(fit["rmse"].is_null(), model.starts_with("optimisable")) << model;
    const json predicted = said(bench, "predict m.h5 runs.csv -o p.csv --json");
    ASSERT_EQ(predicted["predicted"].size(), 40u) << model;
    EXPECT_NEAR(predicted["predicted"][0], 28.0, 6.0) << model;
  }
  const auto refused = bench.run(
      "repose", std::string("fit") + kTable + "-o m.h5 --model linear --kernel ard-matern52");
  EXPECT_NE(refused.code, 0);
  EXPECT_NE(refused.err.find("--kernel"), std::string::npos) << refused.err;
}

void expect_refusal(const Workbench& bench, const std::string& arguments,
                    const std::string& sentence) {
  const auto result = bench.run("repose", arguments);
  EXPECT_EQ(result.code, 3) << arguments;
  EXPECT_NE(result.err.find(sentence), std::string::npos) << result.err;
}

TEST(PredictCommand, LeavesADeviationThatTheDataDoNotDetermineEmpty) {
  const Workbench bench;
  bench.write("runs.csv", "a,b,y\n0,0,1\n1,1,2\n2,2,2.5\n3,3,4\n4,4,5\n");
  bench.write("points.csv", "a,b\n1,1\n1,3\n");
  const auto fit =
      bench.run("repose", "fit runs.csv --response y --input a,b --model linear -o m.h5");
  ASSERT_EQ(fit.code, 0) << fit.err;
  const json p = said(bench, "predict m.h5 points.csv -o p.csv --json");
  EXPECT_TRUE(p.at("function_sd").at(0).is_number());
  EXPECT_TRUE(p.at("function_sd").at(1).is_null());
  EXPECT_TRUE(p.at("observation_sd").at(1).is_null());
  EXPECT_TRUE(p.at("predicted").at(1).is_number());
}

TEST(CompareCommand, SaysItsResultsWhereAFigureCannotBeWritten) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  std::filesystem::create_directories(bench / "figures/linear.svg");
  const auto result =
      bench.run("repose", std::string("compare") + kTable + "--model linear --figures figures");
  EXPECT_NE(result.code, 0);
  EXPECT_EQ(json::parse(result.out).at("models").size(), 1u);
  EXPECT_NE(result.err.find("linear.svg"), std::string::npos) << result.err;
}

TEST(ValidationCommands, RefuseWithASentence) {
  const Workbench bench;
  bench.write("runs.csv", runs());
  bench.write("gaps.csv", "mu,lot,text,y\n0,1,a,1\n1,,a,2\n2,1,,3\n3,2,b,4\n4,2,b,6\n");
  for (const char* group : {"lot", "text"})
    expect_refusal(bench,
                   std::string("cv gaps.csv --response y --input mu --model linear --outer "
                               "leave-group-out:") +
                       group,
                   std::string("column ") + group + " has no value in 1 of 5 rows");
  expect_refusal(bench, "compare runs.csv --response angle_deg --input mu_s --model '?'",
                 "medium-gaussian-svm");
  const std::string table = " runs.csv --response angle_deg --input mu_s,mu_r --model linear ";
  expect_refusal(bench, "cv" + table + "--outer leave-group-out:laboratory", "one group");
  expect_refusal(bench, "cv" + table + "--outer kfold:41", "41 folds of 40");
  expect_refusal(bench, "cv" + table + "--outer kfold:many", "not a whole number");
  expect_refusal(bench, "cv" + table + "--outer bootstrap:5", "write kfold:10");
  expect_refusal(bench, "compare" + table + "--group nothing", "nothing");
  expect_refusal(bench, "compare runs.csv --response angle_deg --input mu_s --model linaer",
                 "did you mean linear?");
}

}  // namespace
}  // namespace repose::test

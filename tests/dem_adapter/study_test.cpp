// Study files: what they mean, and what is said about each mistake.
#include "repose/dem_adapter/study.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "repose/base/error.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

const std::string kStudy = R"(title = "quick"
seed = 7
[scenario]
scenario = "drawdown"
preset = "quick"
[parameters]
mu_s = { lower = 0.3, upper = 0.9 }
mu_r = { lower = 0.05, upper = 0.35 }
c_r_pp = { lower = 0.3, upper = 0.8 }
[ties]
mu_s_pp = ["mu_s"]
mu_s_ss = ["mu_s"]
mu_r_pp = ["mu_r"]
mu_r_ss = ["mu_r"]
c_r_ss = ["c_r_pp"]
[targets]
shear_angle_deg = { value = 42.5, ci95 = 1.6 }
discharged_fraction = { value = 0.808, weight = 3 }
)";

Study read(const std::string& text) {
  const test::TemporaryDirectory directory;
  std::ofstream(directory / "study.toml") << text;
  return read_study(directory / "study.toml");
}

std::string replaced(const std::string& from, const std::string& to) {
  auto text = kStudy;
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& error) {
    const std::string message = error.what();
    return message.substr(message.find("study.toml"));
  }
  return "accepted";
}

TEST(Study, ReadsSpaceTargetsAndDefaults) {
  const auto study = read(kStudy);
  EXPECT_EQ(study.seed, 7U);
  EXPECT_EQ(study.space.names(), (std::vector<std::string>{"mu_s", "mu_r", "c_r_pp"}));
  const auto values = study.space.complete(study.space.from_unit(Vector::Constant(3, 0.5)));
  EXPECT_DOUBLE_EQ(values.at("mu_s_ss"), 0.6);
  ASSERT_EQ(study.targets.size(), 2U);
  EXPECT_DOUBLE_EQ(study.targets[0].target.weight, 0.25);  // weights sum to 1
  EXPECT_DOUBLE_EQ(study.targets[1].target.weight, 0.75);
  EXPECT_DOUBLE_EQ(study.targets[0].target.scale, 42.5);
  EXPECT_DOUBLE_EQ(study.targets[0].ci95, 1.6);
  EXPECT_EQ(study.genetic.population, 1000);  // Table D.2
}

TEST(Study, CountsTheRunsOfItsPlan) {
  const auto counts = planned_runs(read(kStudy));
  EXPECT_EQ(counts.screening, 13 * 3);  // three factors use the conference matrix of order 6
  EXPECT_EQ(counts.sampling, 30 * 2);
  EXPECT_EQ(counts.adaptive, 16 * 2);
  EXPECT_EQ(counts.verification, 10);
}

TEST(Study, NamesFileLineKeyValueAndRemedyOfAMistake) {
  EXPECT_EQ(refusal(replaced("upper = 0.9", "uper = 0.9")),
            "study.toml:7: parameters.mu_s: the key upper is missing (there is uper); add it");
  EXPECT_EQ(refusal(replaced("seed = 7", "sede = 7")),
            "study.toml:2: sede: unknown key; did you mean seed?");
  EXPECT_EQ(
      refusal(replaced("lower = 0.3, upper = 0.9", "lower = 0.9, upper = 0.3")),
      "study.toml:7: parameters.mu_s.lower: 0.9 is not below upper = 0.3; swap or widen them");
  EXPECT_NE(refusal(replaced("shear_angle_deg", "shear_angle"))
                .find("no KPI of this name; it has shear_angle_deg"),
            std::string::npos);
  EXPECT_NE(refusal(replaced("c_r_pp = {", "c_r_px = {")).find("did you mean c_r_pp?"),
            std::string::npos);
  EXPECT_NE(refusal(replaced("value = 42.5", "value = nan")).find("not finite"), std::string::npos);
  EXPECT_NE(refusal(replaced("\"mu_s\"]\nmu_s_ss", "\"mu_q\"]\nmu_s_ss")).find("mu_q"),
            std::string::npos);
  EXPECT_NE(refusal(replaced("preset = \"quick\"", "preset = \"big\""))
                .find("choose one of quick and delft-like"),
            std::string::npos);
}

TEST(Study, RefusesASimulationThatCannotBeBeforeAnyRuns) {
  const auto message = refusal(
      replaced("preset = \"quick\"", "preset = \"quick\"\ntime_step_rayleigh_fraction = 0.7"));
  EXPECT_NE(message.find("0.7"), std::string::npos) << message;
  EXPECT_NE(message.find("0.5"), std::string::npos) << message;
}

TEST(Study, NamesTheParameterWhoseRangeCannotBeSimulated) {
  const auto message = refusal(replaced("c_r_pp = { lower = 0.3", "c_r_pp = { lower = 0.0"));
  EXPECT_NE(message.find("study.toml:9: parameters.c_r_pp: with c_r_pp = 0: "), std::string::npos)
      << message;
}

TEST(Study, RefusesNamesThatTablesCannotHold) {
  auto text = replaced("[\"mu_r\"]\nmu_r_ss", "[\"seed\"]\nmu_r_ss");
  text.replace(text.find("mu_r = {"), 4, "seed");
  EXPECT_NE(refusal(text).find("taken by a column"), std::string::npos) << refusal(text);
}

TEST(Study, OfAMissingFileOrScenarioIsNamed) {
  EXPECT_THROW(read_study("/nowhere/study.toml"), StorageError);
  EXPECT_THROW(read(replaced("[scenario]\nscenario = \"drawdown\"\npreset = \"quick\"\n",
                             "scenario = \"none.toml\"\n")),
               Error);
}

}  // namespace
}  // namespace repose::dem_adapter

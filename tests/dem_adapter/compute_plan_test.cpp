// How many runs fit, and what a study may say about machine and failures.
#include "repose/dem_adapter/compute_plan.hpp"

#include <gtest/gtest.h>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {
namespace {

TEST(ComputePlan, FitsRunsIntoCoresAndMemory) {
  EXPECT_EQ(runs_at_once({.cores = 8}), 8U);
  EXPECT_EQ(runs_at_once({.cores = 8, .ranks = 3}), 2U);
  EXPECT_EQ(runs_at_once({.cores = 8, .memory_gb = 3.0, .memory_per_run_gb = 0.6}), 5U);
  EXPECT_EQ(runs_at_once({.cores = 4, .memory_gb = 3.0, .memory_per_run_gb = 0.6}), 4U);
  EXPECT_EQ(runs_at_once({.workers = 3, .cores = 8}), 3U);
  EXPECT_EQ(runs_at_once({.workers = 9, .cores = 8}), 8U);
  EXPECT_EQ(runs_at_once({.workers = 999}), 999U);  // asked for, without a limit
  EXPECT_GE(runs_at_once({.ranks = 999}), 1U);
}

TEST(ComputePlan, RefusesWhatFitsNothing) {
  EXPECT_THROW(runs_at_once({.cores = 2, .ranks = 4}), InputError);
  EXPECT_THROW(runs_at_once({.memory_gb = 2.0, .memory_per_run_gb = 3.0}), InputError);
  EXPECT_THROW(runs_at_once({.memory_gb = 2.0}), InputError);
}

TEST(ComputePlan, IsReadFromAStudy) {
  const auto root = TomlTable::parse(R"([compute]
cores = 8
ranks = 2
memory_gb = 4
memory_per_run_gb = 1.5
time_limit_s = 60
store = "../runs"
[failures]
retries = 2
retry_on = ["crash", "time-limit"]
stop_above = 0.25
penalty = { angle_deg = 90 }
)",
                                     "study.toml");
  const auto plan = read_compute_plan(root, "/data/one");
  EXPECT_EQ(runs_at_once(plan), 2U);
  EXPECT_EQ(plan.time_limit_s, 60.0);
  EXPECT_EQ(plan.store, "/data/runs");
  const auto policy = read_failure_policy(root, {"angle_deg", "mass_kg"});
  EXPECT_EQ(policy.retries, 2);
  EXPECT_EQ(policy.retry_on, (std::vector<Outcome>{Outcome::crash, Outcome::time_limit}));
  EXPECT_EQ(policy.stop_above, 0.25);
  EXPECT_EQ(policy.penalty.at("angle_deg"), 90.0);
}

TEST(ComputePlan, NamesFileAndLineOfAMistake) {
  const auto refused = [](const std::string& text, const std::string& part) {
    const auto root = TomlTable::parse(text, "study.toml");
    try {
      read_compute_plan(root, ".");
      read_failure_policy(root, {"angle_deg"});
      FAIL() << text;
    } catch (const InputError& error) {
      const std::string what = error.what();
      EXPECT_TRUE(what.starts_with("study.toml:")) << what;
      EXPECT_NE(what.find(part), std::string::npos) << what;
    }
  };
  refused("[compute]\ncores = 2\nranks = 4\n", "ranks = 4 exceeds cores = 2");
  refused("[compute]\nstore = \"\"\n", "name a folder");
  refused("[failures]\nretry_on = [\"crsh\"]\n", "\"crsh\" is no outcome");
  refused("[failures]\nretry_on = [\"finished\"]\n", "is not repeated");
  refused("[failures]\npenalty = { mass_kg = 1 }\n", "no KPI of this name");
  refused("[failures]\nstop_above = 0\n", "stop_above");
}

TEST(Outcome, NamesReadBack) {
  for (const Outcome outcome : all_outcomes())
    EXPECT_EQ(outcome_named(to_string(outcome)), outcome);
}

}  // namespace
}  // namespace repose::dem_adapter

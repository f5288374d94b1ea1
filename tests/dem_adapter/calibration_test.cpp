// Calibration on a problem whose answer is known, with the real campaign around a synthetic engine.
#include "repose/dem_adapter/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/toml.hpp"
#include "repose/surrogate/model_file.hpp"
#include "repose/table/io.hpp"
#include "synthetic_scenario.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kHiddenA = 0.7, kHiddenB = 0.3;

Study study() {
  Study s{.title = "synthetic", .scenario = test::SyntheticScenario(), .seed = 3};
  s.space =
      ParameterSpace({{.name = "a"}, {.name = "b"}, {.name = "c"}, {.name = "d"}, {.name = "e"}});
  const auto kpis = test::SyntheticScenario::kpis(kHiddenA, kHiddenB);
  const std::vector<std::string> names{"first", "second", "third"};
  for (std::size_t i = 0; i < 3; ++i)
    s.targets.push_back(
        {.target = {.name = names[i], .value = kpis[i], .weight = 1.0 / 3, .scale = kpis[i]}});
  s.adaptive = {.batch = 3, .max_batches = 2, .r2 = 1.0};
  s.sampling.points_per_parameter = 6;
  s.genetic.population = 200;
  s.compute.workers = 2;
  return s;
}

Calibration run(const Study& s, const test::SyntheticEngine& engine,
                const std::filesystem::path& directory, const std::atomic<Stop>* stop = nullptr) {
  const Campaign campaign(directory, engine, test::SyntheticEngine::measure(),
                          {.compute = s.compute, .failures = s.failures, .stop = stop});
  return calibrate(s, campaign, {});
}

TEST(Calibration, FindsTheParametersThatMatterAndTheirHiddenValues) {
  const test::TemporaryDirectory directory;
  const auto result = run(study(), test::SyntheticEngine(0.1), directory.path());
  EXPECT_EQ(result.surrogates.parameters, (std::vector<std::string>{"a", "b"}));
  // Slopes near 12 (first in a) and 12 (second in b), noise 0.1 a run, 60 runs: the standard error
  // of a coordinate is below 0.005, and the model's error adds no more; 0.04 leaves room for
  // neither to be lucky.
  EXPECT_NEAR(result.values.at("a"), kHiddenA, 0.04);
  EXPECT_NEAR(result.values.at("b"), kHiddenB, 0.04);
  EXPECT_DOUBLE_EQ(result.values.at("c"), 0.5);
  EXPECT_LT(result.verified_error, 0.01);
  EXPECT_LT(result.verified_error, result.baseline_error);
  for (const auto& kpi : result.kpis) {
    EXPECT_TRUE(kpi.reached());
    EXPECT_EQ(kpi.verified.count, 5);
  }
  for (const auto& p : result.parameters)
    if (p.selected) {
      EXPECT_LE(p.lowest, p.value);
      EXPECT_GE(p.highest, p.value);
    }
}

TEST(Calibration, UsesFreshSeedsForItsProof) {
  const test::TemporaryDirectory directory;
  const auto result = run(study(), test::SyntheticEngine(0.1), directory.path());
  std::map<std::uint64_t, int> uses;
  for (const auto& o : result.data.observations) {
    const auto phase = result.data.points[o.point].phase;
    uses[o.seed] += phase == Phase::baseline ? 0 : 1;  // it shares the seeds of the verification
  }
  for (const auto& [seed, count] : uses) EXPECT_EQ(count, 1) << seed;
}

TEST(Calibration, GoesOnAfterBeingStoppedAndEndsWithTheSameBits) {
  const test::TemporaryDirectory straight, stopped;
  const auto reference = run(study(), test::SyntheticEngine(0.1), straight.path());
  std::atomic<Stop> stop{Stop::no};
  test::SyntheticEngine engine(0.1);
  engine.stopping_every(17, &stop);  // somewhere in each phase
  int stops = 0;
  for (bool finished = false; !finished;) {
    stop = Stop::no;
    try {
      const auto result = run(study(), engine, stopped.path(), &stop);
      EXPECT_EQ(result.values, reference.values);
      EXPECT_EQ(result.verified_error, reference.verified_error);
      finished = true;
    } catch (const Interrupted&) {
      ++stops;
    }
  }
  EXPECT_GE(stops, 3);
}

TEST(Calibration, DoesNotDependOnTheNumberOfWorkers) {
  const test::TemporaryDirectory one, four;
  auto s = study();
  s.compute.workers = 1;
  const auto a = run(s, test::SyntheticEngine(0.1), one.path());
  s.compute.workers = 4;
  const auto b = run(s, test::SyntheticEngine(0.1), four.path());
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.verified_error, b.verified_error);
}

TEST(Calibration, NamesATargetThatNoRunReached) {
  const test::TemporaryDirectory directory;
  auto s = study();
  s.targets[0].target.value = 60.0;  // the largest possible is 44
  s.targets[0].target.scale = 60.0;
  const auto result = run(s, test::SyntheticEngine(0.1), directory.path());
  EXPECT_FALSE(result.kpis[0].reached());
  ASSERT_FALSE(result.remarks.empty());
  EXPECT_NE(result.remarks[0].find("No run reached the target first = 60"), std::string::npos);
  EXPECT_GT(result.values.at("a"), 0.95);  // as near as it gets
}

TEST(Calibration, PassesOverFailedRuns) {
  const test::TemporaryDirectory directory;
  test::SyntheticEngine engine(0.1);
  engine.failing_above(0.95);  // a corner of the screening design, and more
  const auto result = run(study(), engine, directory.path());
  EXPECT_GT(result.data.failed(), 0U);
  EXPECT_NEAR(result.values.at("a"), kHiddenA, 0.06);
  EXPECT_NEAR(result.values.at("b"), kHiddenB, 0.06);
}

TEST(Calibration, LeavesARunOutOnlyForTheKpiThatIsUndefined) {
  const test::TemporaryDirectory directory;
  const auto s = study();
  auto measure = test::SyntheticEngine::measure();
  measure.of = [of = measure.of](const std::filesystem::path& output) {
    auto m = of(output);
    if (m.kpis.at("first") > 42.0) m.kpis["third"] = std::nan("");  // a > 0.85
    return m;
  };
  const Campaign campaign(directory.path(), test::SyntheticEngine(0.1), measure,
                          {.compute = s.compute});
  const auto result = calibrate(s, campaign, {});
  EXPECT_EQ(result.data.failed(), 0U);
  EXPECT_EQ(result.surrogates.y[0].size(), result.surrogates.y[1].size());
  EXPECT_LT(result.surrogates.y[2].size(), result.surrogates.y[0].size());
  EXPECT_NEAR(result.values.at("a"), kHiddenA, 0.04);
  EXPECT_NEAR(result.values.at("b"), kHiddenB, 0.04);
}

TEST(Calibration, LearnsFromThePenaltyOfFailedRuns) {
  const test::TemporaryDirectory directory;
  test::SyntheticEngine engine(0.1);
  engine.failing_above(0.9);
  auto s = study();
  s.failures.penalty = {{"first", 60.0}, {"second", 60.0}, {"third", 0.0}};
  const auto result = run(s, engine, directory.path());
  EXPECT_GT(result.data.failed(), 0U);
  EXPECT_EQ(result.surrogates.y[0].maxCoeff(), 60.0);
  for (const auto& kpi : result.kpis)
    if (kpi.target.target.name != "third") {
      EXPECT_LT(kpi.highest_seen, 60.0);
    }
  EXPECT_LT(result.values.at("a"), 0.9);
}

TEST(Calibration, SaysSoWhenEverythingFails) {
  const test::TemporaryDirectory directory;
  test::SyntheticEngine engine(0.1);
  engine.failing_above(-1.0);
  try {
    run(study(), engine, directory.path());
    FAIL();
  } catch (const SimulationError& error) {
    EXPECT_NE(std::string(error.what()).find("too many runs of the screening failed"),
              std::string::npos);
  }
}

TEST(Calibration, CallsAParameterThatDoesNotMatterARidgeOrLeavesItOut) {
  // With the KPIs that depend on a only, b cannot be found: it is either not chosen or reported as
  // a ridge.
  const test::TemporaryDirectory directory;
  auto s = study();
  s.targets.resize(1);
  s.targets[0].target.weight = 1.0;
  const auto result = run(s, test::SyntheticEngine(0.1), directory.path());
  for (const auto& p : result.parameters) {
    if (p.name != "a" && p.selected) {
      EXPECT_TRUE(p.is_ridge()) << p.name;
    }
  }
  EXPECT_NEAR(result.values.at("a"), kHiddenA, 0.04);
}

TEST(Calibration, WritesResultsThatReadBack) {
  const test::TemporaryDirectory directory;
  const auto s = study();
  const auto result = run(s, test::SyntheticEngine(0.1), directory.path());
  write_results(directory.path(), s, result, "repose calibrate study.toml");
  const auto root = TomlTable::read_file(directory / "result.toml");
  EXPECT_EQ(root.table("values").number("a"), result.values.at("a"));
  const auto kpis = root.tables("kpi");
  ASSERT_EQ(kpis.size(), 3U);
  EXPECT_EQ(kpis[1].number("verified"), result.kpis[1].verified.mean);
  EXPECT_EQ(kpis[1].number("verified_relative_error"), result.kpis[1].verified_relative_error());
  const auto runs = table::read_table({directory / "runs.h5", ""}, table::Missing::allow);
  EXPECT_EQ(runs.rows(), result.data.observations.size());
  EXPECT_EQ(runs.names_with_role(table::Role::response), s.scenario.kpi_names());
  // The saved model speaks natural units and predicts what the calibration did.
  const auto model = surrogate::load_model(directory.path() / "models" / "first.h5");
  EXPECT_EQ(model.inputs, result.surrogates.parameters);
  const Vector x = Eigen::Vector2d(result.values.at("a"), result.values.at("b"));
  EXPECT_NEAR(model.model.predict(x).mean, result.kpis[0].predicted.mean, 1e-9 * 50);
  const auto html = read_file(directory / "report.html");
  EXPECT_NE(html.find("</html>"), std::string::npos);
  for (const char* outside : {"src=", "href=", "<script", "@import", "url("})
    EXPECT_EQ(html.find(outside), std::string::npos) << "the page must be self-contained";
}

TEST(Calibration, LeavesOutARepetitionThatMostlyFailed) {
  auto s = study();
  s.screening.repetitions = 3;
  const test::TemporaryDirectory directory;
  const auto first = run(s, test::SyntheticEngine(0.1), directory.path());
  // The same outcomes, but for the third repetition, which lost nearly all of its runs.
  int broken = 0;
  for (const auto& o : first.data.observations)
    if (first.data.points[o.point].phase == Phase::screening && o.repetition == 2 &&
        ++broken < 16) {
      auto broken_run = o.outcome;
      broken_run.measurement.fail(Outcome::jammed_outlet, "it jammed");
      RunStore(directory.path(), StoreAccess::write).record(broken_run);
    }
  const auto result = run(s, test::SyntheticEngine(0.1), directory.path());
  EXPECT_EQ(result.screening.repetitions, 2);
  ASSERT_FALSE(result.remarks.empty());
  EXPECT_NE(result.remarks[0].find("1 of 3 repetitions of the screening were left out"),
            std::string::npos);
  EXPECT_NEAR(result.values.at("a"), kHiddenA, 0.06);
}

TEST(Calibration, KeepsAwayFromWhereEveryRunFails) {
  // The target lies beyond the edge of failure: the best point that can be simulated is just
  // inside.
  const test::TemporaryDirectory directory;
  test::SyntheticEngine engine(0.05);
  engine.failing_above(0.6);
  const auto result = run(study(), engine, directory.path());
  EXPECT_LT(result.values.at("a"), 0.65);
  EXPECT_GT(result.data.failed(), 0U);
  EXPECT_TRUE(std::filesystem::exists(directory / "runs.h5"));
}

TEST(PrintedTables, FitIntoAHundredColumns) {
  const test::TemporaryDirectory directory;
  const auto s = study();
  const auto result = run(s, test::SyntheticEngine(0.1), directory.path());
  auto many = result;  // as many KPIs as the draw-down has, with its longest names
  auto wide = s;
  for (auto* screening : {&many.screening})
    while (screening->responses.size() < 5)
      screening->responses.push_back(screening->responses.front());
  for (auto& r : many.screening.responses) r.response = "angle_of_repose_deg";
  while (wide.targets.size() < 5) {
    wide.targets.push_back(s.targets.front());
    many.kpis.push_back(result.kpis.front());
    for (auto& step : many.history) step.r2.push_back(step.r2.front());
  }
  for (auto& t : wide.targets) t.target.name = "angle_of_repose_deg";
  for (auto& k : many.kpis) k.target.target.name = "angle_of_repose_deg";
  for (const auto& text :
       {plan_text(wide, 2, 3.0), screening_text(many.screening), result_text(wide, many)}) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      const auto columns =
          std::count_if(line.begin(), line.end(), [](char c) { return (c & 0xC0) != 0x80; });
      EXPECT_LE(columns, 100) << line;
    }
  }
}

}  // namespace
}  // namespace repose::dem_adapter

// The commands around screening designs as a user meets them: design check, screen, variance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "repose/base/random.hpp"
#include "repose/table/io.hpp"

namespace repose {
namespace {

using nlohmann::json;
using test::Workbench;

std::string printed(const std::string& name) {
  return "'" REPOSE_TEST_DATA "/doe/" + name + "'";
}

void expect_readable(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
}

TEST(DesignCheckCommand, AcceptsThePrintedDesignOfFifteenFactors) {
  const Workbench bench;
  const auto said = bench.run("repose", "design check " + printed("dsd_15_factors.csv"));
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("definitive screening design   yes"), std::string::npos) << said.out;
  expect_readable(said.out);
  const auto result =
      json::parse(bench.run("repose", "design check --json " + printed("dsd_15_factors.csv")).out);
  EXPECT_TRUE(result["definitive_screening"]);
  EXPECT_EQ(result["pairs"].size(), 18u);
  EXPECT_EQ(result["pairs"][0], json({1, 13}));
  EXPECT_EQ(result["centre_runs"], json::array({26}));
  EXPECT_TRUE(result["runs_without_mirror_image"].empty());
  EXPECT_EQ(result["factors"].size(), 15u);
  EXPECT_EQ(result["alias_max"], 0.0);
  EXPECT_EQ(result["tests"]["errors"][0]["df"], 21);
  EXPECT_EQ(result["tests"]["errors"][1]["df"], 3);
}

TEST(DesignCheckCommand, RefusesThePrintedDesignOfTwelveFactorsAndNamesItsSevenRuns) {
  const Workbench bench;
  const auto said = bench.run("repose", "design check " + printed("dsd_12_factors.csv"));
  EXPECT_EQ(said.code, 3);
  EXPECT_NE(said.err.find("runs without a mirror image: 1, 8, 10, 15, 16, 19 and 21"),
            std::string::npos)
      << said.err;
  EXPECT_NE(said.err.find("there is no centre run"), std::string::npos);
  expect_readable(said.out);
  const auto as_json = bench.run("repose", "design check --json " + printed("dsd_12_factors.csv"));
  EXPECT_EQ(as_json.code, 3);
  const auto result = json::parse(as_json.out);
  EXPECT_FALSE(result["definitive_screening"]);
  EXPECT_EQ(result["runs_without_mirror_image"], json({1, 8, 10, 15, 16, 19, 21}));
  EXPECT_EQ(result["aliases"][0]["main_effect"], "mu_s_ss");
  EXPECT_EQ(result["aliases"][0]["second_order"], "mu_s_ss*C_r_pg");
}

TEST(DesignCheckCommand, RepairsThePrintedDesignToThirtySevenRuns) {
  const Workbench bench;
  for (const char* file : {"complete.h5", "complete.csv"}) {
    const auto said =
        bench.run("repose", "design check " + printed("dsd_12_factors.csv") + " --repair " + file);
    EXPECT_EQ(said.code, 0) << said.err;
    const auto table = table::read_table({bench / file, ""});
    EXPECT_EQ(table.rows(), 37u);
    EXPECT_EQ(table.numbers("C_r_ss").back(), 0.3505);  // the centre run, as the table prints it
    // Run 1, mirrored: 0.613 of [0.368, 0.613] and 0.06, the middle of [0.045, 0.075].
    EXPECT_EQ(table.numbers("mu_s_pp")[29], 0.368);
    EXPECT_EQ(table.numbers("mu_r_pp")[29], 0.06);
    EXPECT_EQ(table.integers("added")[28], 0);
    EXPECT_EQ(table.integers("added")[29], 1);
    EXPECT_EQ(bench.run("repose", "design check " + std::string(file)).code, 0);
  }
}

TEST(DesignCheckCommand, AcceptsWhatDesignDsdWritesOnAnyScale) {
  const Workbench bench;
  bench.write("factors.toml", R"([parameters]
mu_s = { lower = 0.3, upper = 0.9 }
mu_r = { lower = 0.05, upper = 0.35 }
stiffness = { lower = 1e6, upper = 3e8, scale = "log", unit = "Pa" }
)");
  for (const char* file : {"d.h5", "d.csv"}) {
    ASSERT_EQ(bench.run("repose", "design dsd --factors factors.toml -o " + std::string(file)).code,
              0);
    const auto said = bench.run("repose", "design check --json " + std::string(file));
    EXPECT_EQ(said.code, 0) << said.err;
    EXPECT_EQ(json::parse(said.out)["factors"][2]["scale"], "log");
  }
  EXPECT_EQ(bench.run("repose", "design check d.csv --factors factors.toml").code, 0);
}

TEST(DesignCheckCommand, SaysWhatIsWrongWithATable) {
  const Workbench bench;
  bench.write("constant.csv", "a,b\n1,2\n1,3\n");
  bench.write("gap.csv", "a,b\n1,2\n,3\n");
  bench.write("text.csv", "a,b\nx,y\n");
  bench.write("narrow.toml", "[parameters]\nb = { lower = 0, upper = 2.5 }\n");
  const auto expect_refused = [&](const std::string& arguments, const std::string& reason) {
    const auto said = bench.run("repose", "design check " + arguments);
    EXPECT_EQ(said.code, 3) << arguments;
    EXPECT_NE(said.err.find(reason), std::string::npos) << said.err;
  };
  expect_refused("constant.csv", "column a is 1 in every row");
  expect_refused("gap.csv", "column a has no value in row 2");
  expect_refused("text.csv", "no column that can be a factor");
  expect_refused("constant.csv --columns c", "c");
  expect_refused("constant.csv --factors narrow.toml", "row 2: b = 3 is outside its range");
  EXPECT_EQ(bench.run("repose", "design check missing.csv").code, 6);
}

/// Five repetitions of Table B.2's runs, in the coded units of the table: the angle depends on
/// mu_s_pp and mu_r_ss, the flow on nothing. Rows of the repetitions are mixed.
void write_screening_table(const Workbench& bench) {
  const auto design = table::read_table({REPOSE_TEST_DATA "/doe/dsd_15_factors_coded.csv", ""},
                                        table::Missing::allow);
  std::vector<std::size_t> rows;
  std::vector<std::int64_t> repetition;
  for (std::size_t run = 0; run < design.rows(); ++run)
    for (int r = 0; r < 5; ++r) {
      rows.push_back(run);
      repetition.push_back(10 - r);
    }
  auto source = design.selected_rows(rows);
  table::Table table;
  for (const auto& c : source.columns())
    if (c.name != "foldover_partner" && c.name != "role") table.add(c);
  RandomStream random(12);
  std::vector<double> angle, flow;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    angle.push_back(40.0 + 3.0 * source.numbers("mu_s_pp")[i] - 2.0 * source.numbers("mu_r_ss")[i] +
                    random.normal());
    flow.push_back(1.0 + 0.1 * random.normal());
  }
  flow[3] = std::nan("");  // a failed run
  table.add({.name = "repetition", .range = {}, .values = repetition});
  table.add({.name = "angle", .range = {}, .values = angle});
  table.add({.name = "flow/1", .range = {}, .values = flow});
  table::write_table({bench / "runs.csv", ""}, table);
  table::Table named;
  for (auto c : table.columns()) {
    if (c.name == "flow/1") c.name = "flow";  // no "/" in names of HDF5
    named.add(c);
  }
  table::write_table({bench / "runs.h5", "/runs"}, named);
}

TEST(ScreenCommand, FindsTheFactorsThatMatterInBothKindsOfTable) {
  const Workbench bench;
  write_screening_table(bench);
  for (const std::string method : {"stepwise", "fit-dsd", "stepwise --terms second-order"}) {
    json results[2];
    int i = 0;
    for (const std::string arguments :
         {"runs.csv --response angle,flow/1", "runs.h5 --response angle,flow"}) {
      const auto said = bench.run(
          "repose", "screen --json --replicate repetition --method " + method + " " + arguments);
      ASSERT_EQ(said.code, 0) << said.err;
      results[i] = json::parse(said.out);
      EXPECT_EQ(results[i]["selected"], json({"mu_s_pp", "mu_r_ss"}));
      EXPECT_EQ(results[i]["runs"], 37);
      EXPECT_EQ(results[i]["repetitions"], json({"6", "7", "8", "9", "10"}));
      ++i;
    }
    EXPECT_EQ(results[0]["responses"][0], results[1]["responses"][0]);
    const auto& angle = results[0]["responses"][0];
    // Five standard errors of the mean of five repetitions, 34 levels that are not 0 in each.
    EXPECT_NEAR(angle["factors"][0]["effect"].get<double>(), 3.0, 5.0 / std::sqrt(34.0 * 5.0));
    EXPECT_EQ(angle["factors"][0]["times_significant"], 5);
    EXPECT_LT(angle["factors"][0]["pooled_p"], 1e-20);
    EXPECT_LT(angle["factors"][0]["false_discovery_rate"], 1e-19);
    EXPECT_EQ(angle["models"].size(), 5u);
    EXPECT_EQ(angle["models"][0]["terms"][0]["term"], "1");
    EXPECT_EQ(angle["variance"]["observations"], 185);
    EXPECT_NEAR(angle["variance"]["noise_floor"].get<double>(), 36.0 / 184.0, 1e-15);
    EXPECT_EQ(results[0]["responses"][1]["variance"]["observations"], 184);
  }
}

TEST(ScreenCommand, PrintsTablesAndDrawsFigures) {
  const Workbench bench;
  write_screening_table(bench);
  const auto said = bench.run(
      "repose", "screen runs.csv --response angle,flow/1 --replicate repetition --plots plots");
  EXPECT_EQ(said.code, 0) << said.err;
  expect_readable(said.out);
  EXPECT_NE(said.out.find("Selected, in 80 % of the repetitions for one response at least:\n"
                          "  mu_s_pp mu_r_ss\n"),
            std::string::npos)
      << said.out;
  EXPECT_NE(said.out.find("(noise alone: 19.6 %)"), std::string::npos) << said.out;
  for (const char* figure : {"half_normal_angle.svg", "half_normal_flow_1.svg",
                             "main_effects_angle.svg", "main_effects_flow_1.svg"}) {
    const auto text = test::text_of(bench / "plots" / figure);
    EXPECT_EQ(text.rfind("</svg>\n"), text.size() - 7) << figure;
  }
  const auto figure = test::text_of(bench / "plots" / "half_normal_angle.svg");
  EXPECT_NE(figure.find("mu_s_pp"), std::string::npos);
  EXPECT_EQ(figure.find("mu_r_pp"), std::string::npos);
}

// The runs reach about 45; mu_s_pp raises the angle by 3 a half range, mu_r_ss lowers it by 2.
TEST(ScreenCommand, TellsWhichTargetsLieOutsideTheRunsAndWhereToMove) {
  const Workbench bench;
  write_screening_table(bench);
  bench.write("limits.toml",
              "[parameters]\nmu_s_pp = { lower = -1.0, upper = 1.25 }\n"
              "mu_r_ss = { lower = -3.0, upper = 3.0 }\n");
  const std::string arguments =
      "screen runs.csv --response angle,flow/1 --replicate repetition --target angle=47+-0.5 "
      "--target flow/1=2 --limits limits.toml --ranges moved.toml";
  const auto said = bench.run("repose", arguments);
  EXPECT_EQ(said.code, 0) << said.err;
  expect_readable(said.out);
  for (const char* text : {"ABOVE all runs", "raise mu_s_pp; lower mu_r_ss",
                           "no factor is significant: there is nothing to move",
                           "this KPI cannot calibrate", "(at its limit)"})
    EXPECT_NE(said.out.find(text), std::string::npos) << text << "\n" << said.out;
  const auto result = json::parse(bench.run("repose", arguments + " --json").out)["coverage"];
  const auto& angle = result["targets"][0];
  EXPECT_EQ(angle["position"], "above");
  EXPECT_TRUE(angle["can_calibrate"]);
  EXPECT_FALSE(result["targets"][1]["can_calibrate"]);
  EXPECT_EQ(angle["move"], json({{"mu_s_pp", "raise"}, {"mu_r_ss", "lower"}}));
  EXPECT_NEAR(angle["gap"].get<double>(), 47.5 - angle["highest_run"].get<double>(), 1e-12);
  for (const auto& range : result["ranges"]) {
    if (range["factor"] == "mu_s_pp") {
      EXPECT_EQ(range["upper"], 1.25);
      EXPECT_TRUE(range["at_limit"]);
    } else if (range["factor"] == "mu_r_ss") {
      // 3 * 0.25 of the gap and its margin are done by mu_s_pp, the rest is 2 delta.
      const double delta = (1.25 * angle["gap"].get<double>() - 0.75) / 2.0;
      EXPECT_NEAR(range["lower"].get<double>(), -1.0 - std::min(1.0, delta), 0.1);
    } else {
      EXPECT_FALSE(range["lower_extended"] || range["upper_extended"]);
    }
  }
  // The file serves as --factors of a new design, and holds what was proposed.
  EXPECT_EQ(bench.run("repose", "design dsd --factors moved.toml -o next.csv").code, 0);
  EXPECT_NE(test::text_of(bench / "moved.toml").find("\"mu_s_pp\" = { lower = -1, upper = 1.25 }"),
            std::string::npos)
      << test::text_of(bench / "moved.toml");
  const auto inside = bench.run(
      "repose", "screen runs.csv --response angle,flow/1 --replicate repetition --target angle=40");
  EXPECT_NE(inside.out.find("enclosed"), std::string::npos) << inside.out;
  EXPECT_EQ(inside.out.find("Proposed ranges"), std::string::npos);
  for (const char* wrong : {"angle", "angle=", "angle=a", "angle=41+-", "angle=41+-b", "mass=1",
                            "angle=46+-inf", "angle=0x30"})
    EXPECT_EQ(bench
                  .run("repose",
                       "screen runs.csv --response angle,flow/1 --replicate repetition "
                       "--target " +
                           std::string(wrong))
                  .code,
              3)
        << wrong;
}

TEST(ScreenCommand, PrintsTheAnalysisOfVarianceAndDiagnosticsOfItsFinalModels) {
  const Workbench bench;
  write_screening_table(bench);
  const std::string arguments =
      "screen runs.csv --response angle,flow/1 --replicate repetition --terms second-order "
      "--stop bic --direction forward --anova 1";
  const auto said = bench.run("repose", arguments);
  EXPECT_EQ(said.code, 0) << said.err;
  expect_readable(said.out);
  for (const char* text :
       {"forward", "smallest BIC", "analysis of variance, type I, of repetition 6", "predicted"})
    EXPECT_NE(said.out.find(text), std::string::npos) << text << "\n" << said.out;
  const auto result = json::parse(bench.run("repose", arguments + " --json").out);
  const auto& model = result["responses"][0]["models"][0];
  double sum = 0.0;
  for (const auto& row : model["anova"]["type_one"]) sum += row["sum_of_squares"].get<double>();
  const double residual = model["sigma"].get<double>() * model["sigma"].get<double>() *
                          model["residual_df"].get<double>();
  EXPECT_NEAR(model["r_squared"].get<double>(), sum / (sum + residual), 1e-12);
  EXPECT_EQ(model["runs"].size(), 37u);
  EXPECT_LT(model["predicted_r_squared"], model["r_squared"]);
  EXPECT_TRUE(model["terms"][0]["variance_inflation"].is_null());  // the intercept
  EXPECT_GT(result["responses"][0]["alpha"], result["responses"][0]["alpha_of_noise"]);
}

TEST(ScreenCommand, SaysWhenTheSearchOfTheTwoStageAnalysisWasCutShort) {
  const Workbench bench;
  write_screening_table(bench);
  const std::string arguments =
      "screen runs.csv --response angle,flow/1 --replicate repetition --method fit-dsd "
      "--alpha-second 0.999 --interactions none --quadratics none";
  const auto said = bench.run("repose", arguments + " --budget 1");
  EXPECT_EQ(said.code, 0) << said.err;
  expect_readable(said.out);
  EXPECT_NE(said.out.find("raise --budget"), std::string::npos) << said.out;
}

TEST(ScreenCommand, FindsRepetitionsByTheirNameAndIgnoresBlocksThatAreRepetitions) {
  const Workbench bench;
  write_screening_table(bench);
  const auto result = json::parse(
      bench.run("repose", "screen runs.csv --response angle,flow/1 --block repetition --json").out);
  EXPECT_EQ(result["repetitions"].size(), 5u);
  EXPECT_EQ(result["runs"], 37);
  EXPECT_FALSE(result.contains("blocks"));
  EXPECT_EQ(result["terms"], "main");
  EXPECT_EQ(result["ranges"][0]["upper"], 1.0);
}

TEST(ScreenCommand, PrintsLongAndForeignNamesWithin100Columns) {
  const Workbench bench;
  write_screening_table(bench);
  auto table = table::read_table({bench / "runs.csv", ""}, table::Missing::allow);
  table::Table renamed;
  for (auto c : table.columns()) {
    if (c.name.rfind("mu_", 0) == 0) c.name = "Reibungskoeffizient_µµµµµµµ_" + c.name;
    if (c.name == "angle")
      for (double& value : std::get<std::vector<double>>(c.values)) value *= -1e-5;
    renamed.add(c);
  }
  table::write_table({bench / "long.csv", ""}, renamed);
  const auto said = bench.run("repose",
                              "screen long.csv --response angle,flow/1 --terms second-order "
                              "--target angle=-1 --anova 2");
  EXPECT_EQ(said.code, 0) << said.err;
  std::istringstream lines(said.out);
  for (std::string line; std::getline(lines, line);)
    EXPECT_LE(
        std::count_if(line.begin(), line.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; }),
        100)
        << line;
  EXPECT_NO_THROW(json(said.out).dump());                  // refuses text that is not UTF-8
  EXPECT_NE(said.out.find("mu_s_pp"), std::string::npos);  // the end of a name tells them apart
}

TEST(ScreenCommand, KeepsBlocksInEveryModel) {
  const Workbench bench;
  write_screening_table(bench);
  auto table = table::read_table({bench / "runs.csv", ""}, table::Missing::allow);
  std::vector<std::int64_t> block;
  std::vector<double> angle = table.numbers("angle");
  for (std::size_t i = 0; i < table.rows(); ++i) {
    // The same for both runs of a pair.
    const bool later = table.numbers("mu_s_ss")[i] * table.numbers("mu_s_ps")[i] > 0.0;
    block.push_back(later ? 2 : 1);
    if (later) angle[i] += 50.0;
  }
  table::Table blocked;
  for (auto c : table.columns()) {
    if (c.name == "angle") c.values = angle;
    if (c.name != "flow/1") blocked.add(c);
  }
  blocked.add({.name = "block", .range = {}, .values = block});
  table::write_table({bench / "blocked.csv", ""}, blocked);
  for (const std::string method : {"stepwise", "fit-dsd --quadratics none --alpha-second 0.1"}) {
    const auto said = bench.run("repose",
                                "screen blocked.csv --response angle --replicate repetition --json "
                                "--method " +
                                    method);
    ASSERT_EQ(said.code, 0) << said.err;
    EXPECT_EQ(json::parse(said.out)["selected"], json({"mu_s_pp", "mu_r_ss"}));
  }
}

TEST(ScreenCommand, SaysWhatItCannotAnalyse) {
  const Workbench bench;
  write_screening_table(bench);
  const auto expect_refused = [&](const std::string& arguments, const std::string& reason) {
    const auto said = bench.run("repose", "screen " + arguments);
    EXPECT_EQ(said.code, 3) << arguments;
    EXPECT_NE(said.err.find(reason), std::string::npos) << said.err;
    EXPECT_TRUE(said.out.empty());
  };
  expect_refused("runs.csv", "no response");
  expect_refused("runs.csv --response angel", "angle");
  expect_refused("runs.csv --response flow/1 --replicate repetition",
                 "column angle has 185 different values in 185 rows: a factor or a result?");
  expect_refused("runs.csv --response angle --columns angle,mu_s_pp", "cannot be a factor");
  expect_refused("runs.csv --response angle --replicate flow/1", "flow/1");
  EXPECT_EQ(bench.run("repose", "screen runs.csv --response angle --alpha 2").code, 2);
  EXPECT_EQ(bench.run("repose", "screen runs.csv --response angle --method jmp").code, 2);
  // Options that would do nothing.
  EXPECT_EQ(bench.run("repose", "screen runs.csv --response angle --ranges moved.toml").code, 2);
  EXPECT_EQ(
      bench.run("repose", "screen runs.csv --response angle --method fit-dsd --stop bic").code, 2);
}

TEST(VarianceCommand, DecomposesTheWorkedExample) {
  const Workbench bench;
  bench.write("runs.csv",
              "run,y,z\na,1,5\na,2,5\na,3,5\nb,2,5\nb,3,5\nb,7,5\nc,10,5\n"
              "c,11,5\nc,12,5\n");
  const auto said = bench.run("repose", "variance runs.csv --response y --by run");
  EXPECT_EQ(said.code, 0) << said.err;
  expect_readable(said.out);
  // alpha = sqrt(67/3)/((2 + sqrt 7)/3), its floor 1/(sqrt 3 c4(3)); means 2, 4 and 11.
  for (const char* text : {"88.16 %", "11.84 %", "25.00 %", "87.67 %", "22.33", "3.052", "0.6515",
                           "83.40 %", "68.09 %"})
    EXPECT_NE(said.out.find(text), std::string::npos) << said.out;
  const auto result =
      json::parse(bench.run("repose", "variance runs.csv --response y,z --by run --json").out);
  EXPECT_NEAR(result["responses"][0]["parameter_share"].get<double>(), 134.0 / 152.0, 1e-14);
  EXPECT_NEAR(result["responses"][0]["f"].get<double>(), 67.0 / 3.0, 1e-12);
  EXPECT_TRUE(result["responses"][1]["parameter_share"].is_null());  // z never varies
}

TEST(VarianceCommand, RefusesWhatHasNoRuns) {
  const Workbench bench;
  bench.write("one.csv", "run,y\n1,1\n1,2\n");
  const auto said = bench.run("repose", "variance one.csv --response y --by run");
  EXPECT_EQ(said.code, 3);
  EXPECT_NE(said.err.find("column y"), std::string::npos) << said.err;
  EXPECT_TRUE(said.out.empty());
  EXPECT_EQ(bench.run("repose", "variance one.csv --response y --by x").code, 3);
  EXPECT_EQ(bench.run("repose", "variance one.csv --response y").code, 2);
}

}  // namespace
}  // namespace repose

// The commands around screening designs as a user meets them: design check, screen, variance.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.hpp"
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
    // "added" is a number of a CSV table like any other: the factors have to be named there.
    const std::string columns =
        " --columns mu_s_pp,mu_r_pp,C_r_pp,mu_s_ss,mu_r_ss,C_r_ss,mu_s_pg,mu_r_pg,C_r_pg,mu_s_sg,"
        "mu_r_sg,C_r_sg";
    EXPECT_EQ(bench.run("repose", "design check " + std::string(file) + columns).code, 0);
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

}  // namespace
}  // namespace repose

// The commands that make designs as a user meets them: what they write, say and refuse.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "program.hpp"
#include "repose/table/io.hpp"

namespace repose {
namespace {

using nlohmann::json;
using test::Workbench;

constexpr const char* kFive = R"([parameters]
mu_s = { lower = 0.3, upper = 0.9 }
mu_r = { lower = 0.05, upper = 0.35 }
c_r = { lower = 0.1, upper = 0.7 }
rho = { lower = 1000, upper = 3000, unit = "kg/m3" }
stiffness = { lower = 1e6, upper = 1e8, scale = "log", unit = "Pa" }
)";

constexpr const char* kMixed = R"([parameters]
mu_s = { lower = 0.2, upper = 0.8 }
mu_r = { lower = 0.0, upper = 0.4 }
layers = { lower = 1, upper = 5, integer = true }
mode = { categories = ["layered", "mixed"] }
[fixed]
mu_w = 0.5
[ties]
mu_m = ["mu_s", "mu_w"]
[constraints]
slope = { coefficients = { mu_s = 1, mu_r = -1 }, lower = 0.2 }
)";

json made(const Workbench& bench, const std::string& arguments) {
  const auto said = bench.run("repose", "design " + arguments + " --json");
  EXPECT_EQ(said.code, 0) << arguments << ": " << said.err;
  return said.code == 0 ? json::parse(said.out) : json();
}

table::Table written(const Workbench& bench, const std::string& file = "d.h5") {
  return table::read_table({bench / file, ""});
}

TEST(DesignCommands, MakeEveryKindOfDesignWithItsRuns) {
  const Workbench bench;
  bench.write("f.toml", kFive);
  const std::map<std::string, int> runs{{"dsd", 17},
                                        {"lhs --points 23", 23},
                                        {"sobol", 50},
                                        {"halton --points 7", 7},
                                        {"factorial", 32},
                                        {"factorial --levels 3", 243},
                                        {"factorial --runs 16", 16},
                                        {"factorial --generators D=AB,E=AC --centre-runs 2", 10},
                                        {"plackett-burman", 8},
                                        {"plackett-burman --fold-over --centre-runs 1", 17},
                                        {"central-composite", 30},
                                        {"box-behnken", 46},
                                        {"d-optimal --runs 20", 20}};
  for (const auto& [kind, expected] : runs) {
    SCOPED_TRACE(kind);
    const auto said = made(bench, kind + " --factors f.toml -o d.h5 --seed 3");
    ASSERT_FALSE(said.is_null());
    EXPECT_EQ(said["runs"], expected);
    const auto table = written(bench);
    EXPECT_EQ(table.rows(), static_cast<std::size_t>(expected));
    EXPECT_EQ(table.names_with_role(table::Role::factor),
              (std::vector<std::string>{"mu_s", "mu_r", "c_r", "rho", "stiffness"}));
    EXPECT_EQ(table.column("rho").unit, "kg/m3");
    EXPECT_EQ(table.column("stiffness").range->scale, Scale::log);
    for (const auto& name : table.names_with_role(table::Role::factor))
      for (const double v : table.numbers(name)) {
        EXPECT_GE(v, table.column(name).range->lower);
        EXPECT_LE(v, table.column(name).range->upper);
      }
    // The same seed gives the same file, another one another order or other points.
    made(bench, kind + " --factors f.toml -o again.h5 --seed 3");
    made(bench, kind + " --factors f.toml -o other.h5 --seed 4");
    EXPECT_EQ(written(bench, "again.h5").numbers("stiffness"), table.numbers("stiffness"));
    const std::vector<std::string> factors = table.names_with_role(table::Role::factor);
    EXPECT_NE(written(bench, "other.h5").matrix(factors), table.matrix(factors));
  }
}

TEST(DesignCommands, SayHowTheyAreUsed) {
  const Workbench bench;
  for (const char* kind : {"dsd", "lhs", "sobol", "halton", "factorial", "plackett-burman",
                           "central-composite", "box-behnken", "d-optimal", "augment"}) {
    const auto said = bench.run("repose", "design " + std::string(kind) + " --help");
    EXPECT_EQ(said.code, 0);
    EXPECT_NE(said.out.find("Example: repose design " + std::string(kind)), std::string::npos)
        << said.out;
    EXPECT_NE(said.out.find("--json"), std::string::npos);
    std::istringstream lines(said.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
  }
}

TEST(DesignCommands, DecodeWholeNumbersNamesTiesAndFixedValues) {
  const Workbench bench;
  bench.write("f.toml", kMixed);
  for (const std::string kind :
       {"lhs", "sobol", "halton", "d-optimal --runs 25 --model quadratic"}) {
    SCOPED_TRACE(kind);
    const auto said = made(bench, kind + " --factors f.toml -o d.h5");
    EXPECT_TRUE(said["broken_constraints"].empty());
    const auto table = written(bench);
    const auto s = table.numbers("mu_s"), r = table.numbers("mu_r"), m = table.numbers("mu_m");
    for (std::size_t i = 0; i < table.rows(); ++i) {
      EXPECT_GE(s[i] - r[i], 0.2 - 1e-9);
      EXPECT_DOUBLE_EQ(m[i], 0.5 * (s[i] + 0.5));
      EXPECT_EQ(table.numbers("mu_w")[i], 0.5);
    }
    const auto layers = table.integers("layers");  // throws unless whole
    EXPECT_EQ(*std::max_element(layers.begin(), layers.end()), 5);
    const auto& modes = table.texts("mode");
    EXPECT_EQ(std::set<std::string>(modes.begin(), modes.end()),
              (std::set<std::string>{"layered", "mixed"}));
  }
}

TEST(DesignCommands, NameTheRunsThatBreakConstraints) {
  const Workbench bench;
  bench.write("f.toml", kMixed);
  const auto said = bench.run(
      "repose", "design factorial --factors f.toml -o d.h5 --run-order structured --json");
  EXPECT_EQ(said.code, 0) << said.err;
  const auto result = json::parse(said.out);
  // mu_s = 0.2 with mu_r = 0.4, once for each of the four other combinations.
  ASSERT_EQ(result["broken_constraints"].size(), 4u);
  EXPECT_EQ(result["broken_constraints"][0]["run"], 3);
  EXPECT_EQ(result["broken_constraints"][0]["constraints"][0],
            "slope: -1 mu_r + 1 mu_s = -0.2 is below 0.2");
  EXPECT_NE(said.err.find("run 3: slope"), std::string::npos) << said.err;
}

TEST(DesignCommands, MakeScreeningDesignsWithBlocksAndTwoLevelFactorsThatPassTheCheck) {
  const Workbench bench;
  bench.write("f.toml", kMixed);
  for (const char* file : {"d.h5", "d.csv"}) {
    const auto said = made(bench, "dsd --factors f.toml --blocks 2 -o " + std::string(file));
    EXPECT_EQ(said["two_level_factors"], json({"mode"}));
    const auto table = written(bench, file);
    EXPECT_EQ(table.rows(), 16u);  // two of 6 with a mirrored pair in each block
    const auto blocks = table.integers("block");
    EXPECT_EQ(std::count(blocks.begin(), blocks.end(), 1), 8);
    EXPECT_TRUE(table.has("pair"));
    const auto check =
        bench.run("repose", "design check " + std::string(file) + " --factors f.toml --json");
    EXPECT_EQ(check.code, 0) << check.err;
    EXPECT_EQ(json::parse(check.out)["factors"].size(), 4u);
    EXPECT_EQ(json::parse(check.out)["two_level_factors"], json({"mode"}));
  }
}

TEST(DesignCommands, DescribeFractionsAndCompositeDesigns) {
  const Workbench bench;
  bench.write("f.toml", kFive);
  const auto fraction = made(bench, "factorial --factors f.toml --runs 8 -o d.h5");
  EXPECT_EQ(fraction["resolution"], 3);
  EXPECT_EQ(fraction["minimum_aberration"], true);
  EXPECT_EQ(fraction["generators"].size(), 2u);
  EXPECT_EQ(fraction["defining_relation"].size(), 3u);
  const auto text = bench.run("repose", "design factorial --factors f.toml --runs 16 -o d.h5").out;
  EXPECT_NE(text.find("resolution V, minimum aberration; generators E=ABCD"), std::string::npos)
      << text;
  EXPECT_NE(text.find("I = ABCDE"), std::string::npos);
  const auto composite =
      made(bench, "central-composite --kind circumscribed --factors f.toml -o d.h5");
  EXPECT_DOUBLE_EQ(composite["alpha"], 2.0);  // 16 factorial runs
  const auto table = written(bench);
  const auto s = table.numbers("mu_s"), k = table.numbers("stiffness");
  EXPECT_NEAR(*std::max_element(s.begin(), s.end()), 1.2, 1e-12);
  EXPECT_NEAR(*std::max_element(k.begin(), k.end()), 1e9, 1e-3);
  EXPECT_NEAR(*std::min_element(k.begin(), k.end()), 1e5, 1e-7);
  const auto& parts = table.texts("part");
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (parts[i] == "factorial") {
      EXPECT_LT(std::min(std::abs(s[i] - 0.3), std::abs(s[i] - 0.9)), 1e-12);
    }
  EXPECT_EQ(std::count(parts.begin(), parts.end(), "axial"), 10);
}

TEST(DesignCommands, AugmentATableAndKeepWhatItHolds) {
  const Workbench bench;
  bench.write("f.toml", kMixed);
  made(bench, "lhs --points 12 --factors f.toml -o d.h5");
  const auto before = written(bench);
  for (const std::string method : {"space-filling", "d-optimal"}) {
    SCOPED_TRACE(method);
    const auto said =
        made(bench, "augment d.h5 --factors f.toml --runs 8 -o more.h5 --method " + method);
    EXPECT_EQ(said["runs"], 20);
    EXPECT_TRUE(said["broken_constraints"].empty());
    const auto after = written(bench, "more.h5");
    std::vector<std::size_t> first(12);
    for (std::size_t i = 0; i < 12; ++i) first[i] = i;
    const auto kept = after.selected_rows(first);
    for (const char* name : {"mu_s", "mu_r", "layers", "mu_m", "run"})
      EXPECT_EQ(kept.numbers(name), before.numbers(name)) << name;
    EXPECT_EQ(kept.texts("mode"), before.texts("mode"));
    const auto added = after.integers("added");
    EXPECT_EQ(std::count(added.begin(), added.begin() + 12, 0), 12);
    EXPECT_EQ(std::count(added.begin() + 12, added.end(), 1), 8);
    EXPECT_EQ(after.integers("run").back(), 20);
    EXPECT_DOUBLE_EQ(after.numbers("mu_m").back(), 0.5 * (after.numbers("mu_s").back() + 0.5));
  }
}

TEST(DesignCommands, AugmentATableOfResultsWithoutAFactorsFile) {
  const Workbench bench;
  bench.write("runs.csv", "a,b,angle\n0,10,31.5\n1,20,28.0\n0.2,14,30.0\n");
  const auto said = made(bench,
                         "augment runs.csv --columns a,b --runs 3 -o more.csv --method "
                         "d-optimal --model interactions");
  EXPECT_EQ(said["runs"], 6);
  const auto table = table::read_table({bench / "more.csv", ""}, table::Missing::allow);
  EXPECT_EQ(table.numbers("angle")[1], 28.0);
  EXPECT_TRUE(std::isnan(table.numbers("angle")[3]));
  EXPECT_EQ(table.numbers("a")[2], 0.2);
}

TEST(DesignCommands, RefuseWhatADesignCannotHold) {
  const Workbench bench;
  bench.write("five.toml", kFive);
  bench.write("mixed.toml", kMixed);
  bench.write("three.toml", R"([parameters]
a = { lower = 0, upper = 1 }
b = { lower = 0, upper = 1 }
mode = { categories = ["x", "y", "z"] }
)");
  bench.write("even.toml", R"([parameters]
a = { lower = 0, upper = 1 }
b = { lower = 0, upper = 1 }
n = { lower = 1, upper = 4, integer = true }
)");
  bench.write("tight.toml", R"([parameters]
a = { lower = 0, upper = 1 }
b = { lower = 0, upper = 1 }
[constraints]
sum = { coefficients = { a = 1, b = 1 }, lower = 2.5 }
)");
  const auto refused = [&](const std::string& arguments, int code, const std::string& reason) {
    const auto said = bench.run("repose", "design " + arguments + " -o d.h5");
    EXPECT_EQ(said.code, code) << arguments << said.err;
    EXPECT_NE((said.err + said.out).find(reason), std::string::npos) << said.err << said.out;
    EXPECT_FALSE(std::filesystem::exists(bench / "d.h5"));
  };
  refused("dsd --factors three.toml", 3, "mode: it has 3 names");
  refused("plackett-burman --factors three.toml", 3, "mode: it has 3 names");
  refused("d-optimal --runs 20 --factors three.toml", 3, "mode: it has 3 names");
  refused("dsd --factors even.toml", 3, "n: 4 levels have no middle");
  refused("box-behnken --factors mixed.toml", 3, "mode: it has 2 names");
  refused("central-composite --kind inscribed --factors even.toml", 3, "n: it has 4 levels");
  refused("factorial --centre-runs 1 --factors mixed.toml", 3, "mode: it has 2 names");
  refused("factorial --runs 12 --factors five.toml", 3, "a power of two");
  refused("factorial --levels 3 --factors even.toml", 3, "4 whole numbers do not have 3");
  refused("factorial --runs 16 --levels 3 --factors five.toml", 2, "--levels");
  refused("d-optimal --runs 15 --factors five.toml", 3, "15 runs cannot estimate the 16");
  refused("dsd --blocks 9 --factors five.toml", 3, "9 blocks");
  refused("lhs --factors tight.toml", 3, "obey the constraints");
  refused("sobol --factors tight.toml", 3, "obey the constraints");
  refused("d-optimal --runs 9 --factors tight.toml", 3, "obeys the constraints");
  refused("augment missing.csv --runs 9", 6, "missing.csv");
  refused("sobol --points 0 --factors five.toml", 2, "--points");
}

}  // namespace
}  // namespace repose

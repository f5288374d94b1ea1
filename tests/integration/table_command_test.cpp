// repose table import and export as a user meets them.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.hpp"
#include "repose/table/io.hpp"

namespace repose {
namespace {

using table::Role;
using test::Workbench;
using Texts = std::vector<std::string>;

constexpr auto kRuns =
    "run,mu_s,mu_r,flow,angle_deg [deg],lab,rep\n"
    "1,0.1,0.2,3.5,20.5,Delft,1\n2,0.3,0.4,,21.5,Freiberg,2\n3,0.5,0.6,5.5,22.5,Delft,1\n";
constexpr auto kRoles =
    "--response flow,angle_deg --group lab --replicate rep --id run --unit flow=kg/s";

TEST(TableImport, MakesFactorsOfTheNumbersThatNobodyNamed) {
  const Workbench bench;
  bench.write("runs.csv", kRuns);
  const auto said = bench.run(
      "repose", std::string("table import runs.csv -o runs.h5 --allow-missing --json ") + kRoles);
  ASSERT_EQ(said.code, 0) << said.err;
  const auto json = nlohmann::json::parse(said.out);
  EXPECT_EQ(json.at("rows"), 3);
  EXPECT_EQ(json.at("factors"), (Texts{"mu_s", "mu_r"}));
  const auto table = table::read_table({bench / "runs.h5", ""}, table::Missing::allow);
  EXPECT_EQ(table.names_with_role(Role::response), (Texts{"flow", "angle_deg"}));
  EXPECT_EQ(table.names_with_role(Role::group), Texts{"lab"});
  EXPECT_EQ(table.names_with_role(Role::replicate), Texts{"rep"});
  EXPECT_EQ(table.names_with_role(Role::id), Texts{"run"});
  EXPECT_EQ(table.column("flow").unit, "kg/s");
  EXPECT_EQ(table.column("angle_deg").unit, "deg");
  EXPECT_EQ(std::get<Texts>(table.attributes.at("parents")), Texts{"runs.csv"});
}

TEST(TableImport, RefusesOrDropsRowsWithoutAValue) {
  const Workbench bench;
  bench.write("runs.csv", kRuns);
  const std::string command = std::string("table import runs.csv -o runs.h5 ") + kRoles;
  const auto refused = bench.run("repose", command);
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.err.find("row 2 of column \"flow\" has no value"), std::string::npos)
      << refused.err;
  EXPECT_EQ(bench.files(), 1U);
  const auto dropped = bench.run("repose", command + " --drop-missing");
  ASSERT_EQ(dropped.code, 0) << dropped.err;
  EXPECT_NE(dropped.err.find("1 of 3 rows"), std::string::npos) << dropped.err;
  EXPECT_EQ(table::read_table({bench / "runs.h5", ""}).integers("run"),
            (std::vector<std::int64_t>{1, 3}));
}

TEST(TableImport, ReadsWhatPandasAndMatlabStored) {
  const Workbench bench;
  const std::string data = REPOSE_TEST_DATA "/table/";
  const auto pandas = bench.run("repose", "table import " + data +
                                              "pandas_table.h5 -o p.h5 --response angle_deg "
                                              "--group lab --allow-missing");
  ASSERT_EQ(pandas.code, 0) << pandas.err;
  const auto frame = table::read_table({bench / "p.h5", ""}, table::Missing::allow);
  EXPECT_EQ(frame.names_with_role(Role::id), Texts{"index"});
  EXPECT_EQ(frame.names_with_role(Role::factor), (Texts{"mu_s_pp", "run", "passed"}));
  const auto matlab = bench.run("repose", "table export " + data + "matlab_v73.mat:/A -o a.csv");
  ASSERT_EQ(matlab.code, 0) << matlab.err;
  EXPECT_EQ(test::text_of(bench / "a.csv"), "c1,c2,c3\n1.0,10.0,100.0\n2.0,20.0,200.0\n");
  const auto object = bench.run("repose", "table show " + data + "matlab_v73.mat:/t");
  EXPECT_EQ(object.code, 3);
  EXPECT_NE(object.err.find("table2struct"), std::string::npos) << object.err;
}

TEST(TableImport, NamesAWrongCall) {
  const Workbench bench;
  bench.write("runs.csv", kRuns);
  const auto slip = bench.run("repose", "table import runs.csv -o r.h5 --response flaw");
  EXPECT_EQ(slip.code, 3);
  const auto twice =
      bench.run("repose", "table import runs.csv -o r.h5 --response flow --group flow");
  EXPECT_EQ(twice.code, 2);
  EXPECT_NE(twice.err.find("two roles, response and group"), std::string::npos) << twice.err;
  EXPECT_EQ(bench.run("repose", "table import runs.csv -o r.h5 --allow-missing --unit flow").code,
            2);
  EXPECT_EQ(bench.files(), 1U);
}

TEST(TableImport, TakesTheRangesOfFactorsFromTheDataAndSaysSo) {
  const Workbench bench;
  bench.write("runs.csv",
              "mu_s,stiffness_Pa [Pa],fixed,y\n0.1,1e6,2,1\n0.3,1e7,2,2\n0.6,1e8,2,3\n");
  const std::string command = "table import runs.csv -o runs.h5 --response y";
  const auto said = bench.run("repose", command);
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("mu_s: 0.1 ... 0.6, from the data"), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("stiffness_Pa: 1e+06 ... 1e+08 (log), from the data"), std::string::npos)
      << said.out;
  EXPECT_NE(said.out.find("fixed: no range"), std::string::npos) << said.out;
  const auto table = table::read_table({bench / "runs.h5", ""});
  EXPECT_EQ(table.column("mu_s").range, (table::FactorRange{0.1, 0.6, Scale::linear}));
  EXPECT_EQ(table.column("stiffness_Pa").range, (table::FactorRange{1e6, 1e8, Scale::log}));
  EXPECT_FALSE(table.column("fixed").range);
  const auto ranges =
      nlohmann::json::parse(bench.run("repose", command + " --json").out).at("ranges");
  EXPECT_EQ(
      ranges.at("mu_s"),
      (nlohmann::json{{"from", "data"}, {"lower", 0.1}, {"upper", 0.6}, {"scale", "linear"}}));
  EXPECT_EQ(ranges.at("fixed"), (nlohmann::json{{"from", "none"}}));
}

TEST(TableImport, TakesFactorsAndRangesFromAFactorsFile) {
  const Workbench bench;
  bench.write("runs.csv", "run,mu_s,k,y\n1,0.1,1e6,1\n2,0.3,1e7,2\n");
  bench.write("f.toml",
              "[parameters]\nmu_s = { lower = 0.05, upper = 0.9 }\n"
              "k = { lower = 1e5, upper = 1e8, scale = \"log\", unit = \"Pa\" }\n");
  const std::string command = "table import runs.csv -o runs.h5 --response y --factors f.toml";
  const auto said = bench.run("repose", command);
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("k: 100000 ... 1e+08 (log), from the factors file"), std::string::npos)
      << said.out;
  const auto table = table::read_table({bench / "runs.h5", ""});
  EXPECT_EQ(table.names_with_role(Role::factor), (Texts{"mu_s", "k"}));
  EXPECT_EQ(table.column("run").role, Role::none);
  EXPECT_EQ(table.column("k").range, (table::FactorRange{1e5, 1e8, Scale::log}));
  EXPECT_EQ(table.column("k").unit, "Pa");
  EXPECT_EQ(std::get<Texts>(table.attributes.at("parents")), (Texts{"runs.csv", "f.toml"}));

  const auto refusal = [&](const std::string& toml, int code) {
    bench.write("f.toml", "[parameters]\n" + toml);
    const auto refused = bench.run("repose", command);
    EXPECT_EQ(refused.code, code) << refused.err;
    return refused.err;
  };
  EXPECT_NE(refusal("mu_s = { lower = 0.05, upper = 0.2 }\n", 3)
                .find("row 2 of column \"mu_s\" is 0.3, outside its range [0.05, 0.2]"),
            std::string::npos);
  EXPECT_NE(refusal("mu_t = { lower = 0.05, upper = 0.9 }\n", 3).find("did you mean \"mu_s\"?"),
            std::string::npos);
  EXPECT_NE(refusal("y = { lower = 0, upper = 9 }\n", 2).find("a factor of the factors file"),
            std::string::npos);
  EXPECT_EQ(refusal("k = { lower = 1e5, upper = 1e8, unit = \"Pa\" }\n", 0), "");
  bench.write("runs.csv", "k [N/m],y\n1e6,1\n1e7,2\n");
  EXPECT_NE(refusal("k = { lower = 1e5, upper = 1e8, unit = \"Pa\" }\n", 3)
                .find("has the unit N/m, but f.toml says Pa"),
            std::string::npos);
}

TEST(TableExport, WritesTheColumnsAskedFor) {
  const Workbench bench;
  bench.write("runs.csv", kRuns);
  ASSERT_EQ(
      bench.run("repose", std::string("table import runs.csv -o r.h5 --allow-missing ") + kRoles)
          .code,
      0);
  const auto said = bench.run("repose", "table export r.h5 -o out.csv --columns lab,flow");
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(test::text_of(bench / "out.csv"),
            "lab,flow [kg/s]\nDelft,3.5\nFreiberg,nan\nDelft,5.5\n");
  const auto slip = bench.run("repose", "table export r.h5 -o out2.csv --columns lap");
  EXPECT_EQ(slip.code, 3);
  EXPECT_NE(slip.err.find("did you mean \"lab\"?"), std::string::npos) << slip.err;
}

// Whether HDF5 notices the damage or breaks, the user reads a sentence and the exit code is ours.
TEST(TableCommand, EndsWithASentenceOnFilesThatBreakTheHdf5Library) {
  const Workbench bench;
  for (const auto& file : std::filesystem::directory_iterator(REPOSE_TEST_DATA "/fuzz/known")) {
    const auto said = bench.run("repose", "table show '" + file.path().string() + "'");
    EXPECT_TRUE(said.code == 0 || said.code == 1 || said.code == 3 || said.code == 6)
        << file.path() << ": " << said.code;
    if (said.code != 0) {
      EXPECT_NE(said.err.find("repose: "), std::string::npos) << file.path() << "\n" << said.err;
    }
  }
}

TEST(TableCommand, HasHelpWithAnExample) {
  const Workbench bench;
  for (const char* command : {"table show", "table import", "table export"}) {
    const auto said = bench.run("repose", std::string(command) + " --help");
    EXPECT_EQ(said.code, 0);
    EXPECT_NE(said.out.find("Example: repose table"), std::string::npos) << command;
    std::istringstream lines(said.out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
  }
}

}  // namespace
}  // namespace repose

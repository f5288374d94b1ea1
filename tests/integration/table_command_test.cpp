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

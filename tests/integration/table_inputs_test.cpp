// Every command that takes a table takes HDF5 and CSV alike.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "repose/table/io.hpp"

namespace repose {
namespace {

using nlohmann::json;
using test::Workbench;

/// A call with TABLE for the table's file.
struct Call {
  const char* name;
  const char* arguments;
};

std::string text(Call call, const std::string& table) {
  std::string arguments = call.arguments;
  return arguments.replace(arguments.find("TABLE"), 5, table);
}

/// A definitive screening design of three factors, each run twice.
table::Table measured_design(const Workbench& bench) {
  bench.write("factors.toml",
              "[parameters]\nmu_s = { lower = 0.1, upper = 0.5 }\n"
              "mu_r = { lower = 0.2, upper = 0.8 }\nc_r = { lower = 0.3, upper = 0.9 }\n");
  const auto said = bench.run("repose", "design dsd --factors factors.toml --seed 7 -o design.h5");
  EXPECT_EQ(said.code, 0) << said.err;
  table::Table design = table::read_table({bench / "design.h5", ""});
  std::vector<std::size_t> twice;
  for (std::size_t row = 0; row < design.rows(); ++row) twice.insert(twice.end(), {row, row});
  design = design.selected_rows(twice);
  std::vector<double> y;
  std::vector<std::int64_t> repetition;
  for (std::size_t row = 0; row < design.rows(); ++row) {
    repetition.push_back(static_cast<std::int64_t>(row % 2) + 1);
    y.push_back(30.0 * design.numbers("mu_s")[row] + 10.0 * design.numbers("mu_r")[row] +
                0.1 * std::sin(static_cast<double>(row * row)));
  }
  design.add({.name = "repetition", .values = repetition});
  design.add({.name = "angle_deg", .unit = "deg", .values = y});
  return design;
}

/// Without what may differ: names of files, times, and roles and ranges, which CSV does not keep.
json comparable(const std::string& text) {
  json result = json::parse(text);
  for (const char* key : {"file", "table", "design", "seconds", "repaired"}) result.erase(key);
  if (result.contains("ranges"))
    for (auto& range : result["ranges"]) range.erase("from");
  else if (result.contains("columns"))
    result.erase("factors");
  if (result.contains("columns"))
    for (auto& column : result["columns"])
      if (column.is_object())
        for (const char* key : {"role", "lower", "upper", "scale"}) column.erase(key);
  return result;
}

class EveryTableCommand : public ::testing::TestWithParam<Call> {};

TEST_P(EveryTableCommand, SaysTheSameOfHdf5AndOfCsv) {
  const Workbench bench;
  const table::Table design = measured_design(bench);
  table::write_table({bench / "runs.h5", ""}, design);
  table::write_table({bench / "runs.csv", ""}, design);
  table::write_table({bench / "RUNS.CSV", ""}, design);
  const std::string fit =
      "fit runs.h5 --response angle_deg --input mu_s,mu_r,c_r --seed 3 -o model.h5";
  ASSERT_EQ(bench.run("repose", fit).code, 0);
  std::vector<json> results;
  for (const char* file : {"runs.h5", "runs.csv", "RUNS.CSV"}) {
    const auto said = bench.run("repose", text(GetParam(), file) + " --json");
    ASSERT_EQ(said.code, 0) << file << ": " << said.err;
    results.push_back(comparable(said.out));
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST_P(EveryTableCommand, RefusesATableThatIsDamagedOrAbsent) {
  const Workbench bench;
  const table::Table design = measured_design(bench);
  table::write_table({bench / "runs.h5", ""}, design);
  ASSERT_EQ(bench.run("repose", "fit runs.h5 --response angle_deg --input mu_s -o model.h5").code,
            0);
  const std::string bytes = test::text_of(bench / "runs.h5");
  bench.write("cut.h5", bytes.substr(0, bytes.size() / 2));
  bench.write("uneven.csv", "a,b\n1,2\n3\n");
  for (const auto& [file, code] : {std::pair{"cut.h5", 6}, std::pair{"absent.h5", 6},
                                   std::pair{"absent.csv", 6}, std::pair{"uneven.csv", 3}}) {
    const std::size_t before = bench.files();
    const auto said = bench.run("repose", text(GetParam(), file));
    EXPECT_EQ(said.code, code) << file << ": " << said.err;
    EXPECT_NE(said.err.find(file), std::string::npos) << said.err;
    EXPECT_EQ(bench.files(), before);
  }
}

TEST_P(EveryTableCommand, HasHelpWithAnExampleAndJson) {
  const Workbench bench;
  std::string command = GetParam().arguments;
  command.resize(command.find(" --") == std::string::npos
                     ? command.find(" TABLE")
                     : std::min(command.find(" TABLE"), command.find(" --")));
  if (command.starts_with("predict")) command = "predict";
  const auto said = bench.run("repose", command + " --help");
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("Example: repose " + command), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("--json"), std::string::npos);
  EXPECT_NE(said.out.find("FILE.csv"), std::string::npos) << said.out;
}

INSTANTIATE_TEST_SUITE_P(
    Commands, EveryTableCommand,
    ::testing::Values(
        Call{"show", "table show TABLE --rows 30"},
        Call{"import",
             "table import TABLE -o out.h5 --response angle_deg --replicate repetition "
             "--id run,pair"},
        Call{"export", "table export TABLE -o out.csv"},
        Call{"fit", "fit TABLE --response angle_deg --input mu_s,mu_r,c_r --seed 3 -o fitted.h5"},
        Call{"predict", "predict model.h5 TABLE -o predicted.csv"},
        Call{"check", "design check TABLE --columns mu_s,mu_r,c_r"},
        Call{"screen",
             "screen TABLE --response angle_deg --replicate repetition --columns mu_s,mu_r,c_r"},
        Call{"variance", "variance TABLE --response angle_deg --by run"}),
    [](const auto& call) { return std::string(call.param.name); });

}  // namespace
}  // namespace repose

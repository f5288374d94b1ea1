// repose transfer, as a user runs it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "program.hpp"

namespace repose::test {
namespace {

using nlohmann::json;

/// 14 rows each of a and b, and 14 of c of which the last `waiting` have no response; c is b with
/// another scale and shift.
std::string runs(int waiting) {
  std::string csv = "mu_s,mu_r,material,angle_deg\n";
  for (int i = 0; i < 42; ++i) {
    const double u = std::fmod(0.5 + 0.6180339887 * i, 1.0);
    const double v = std::fmod(0.25 + 0.7548776662 * i, 1.0);
    const double angle = 25.0 + 8.0 * v + 3.0 * std::sin(4.0 * u) + 0.02 * ((i * 7) % 5 - 2);
    const bool is_new = i >= 28;
    char line[200];
    std::snprintf(line, sizeof line, "%.6f,%.6f,%s,", u, v, is_new ? "c" : (i % 2 ? "b" : "a"));
    csv += line;
    if (i < 42 - waiting) csv += std::to_string(is_new ? 20.0 + 0.7 * angle : angle);
    csv += "\n";
  }
  return csv;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The number in a column of a line of CSV, from 0.
double number_of(const std::string& line, int column) {
  std::istringstream in(line);
  std::string cell;
  for (int k = 0; k <= column; ++k) std::getline(in, cell, ',');
  return std::stod(cell);
}

const char* const kTable = " runs.csv --response angle_deg --input mu_s,mu_r --group material ";

TEST(TransferCommand, PrintsTheLayoutOfTheThesis) {
  const Workbench bench;
  bench.write("runs.csv", runs(0));
  const auto said =
      bench.run("repose", std::string("transfer") + kTable + "--samples 0,4 --seeds 2 --folds 4");
  ASSERT_EQ(said.code, 0) << said.err;
  for (const char* text : {"angle_deg: gpr transferred by retrained, mean ± deviation over 2 seeds",
                           "transferred by weighted", "RMSE validation", "RMSE unseen", "R2 unseen",
                           "corr^2 unseen", "all were seen", "mean"})
    EXPECT_NE(said.out.find(text), std::string::npos) << text;
}

TEST(TransferCommand, SaysInJsonWhatEveryWayIsWorth) {
  const Workbench bench;
  bench.write("runs.csv", runs(0));
  const auto said = bench.run(
      "repose", std::string("transfer") + kTable + "--samples 0,4 --seeds 2 --folds 4 --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const json result = json::parse(said.out);
  ASSERT_EQ(result["scores"].size(), 12u);
  ASSERT_EQ(result["means"].size(), 4u);
  const auto score = [&](const std::string& method, const std::string& group, int samples) {
    for (const json& s : result["scores"])
      if (s["method"] == method && s["group"] == group && s["samples"] == samples) return s;
    return json();
  };
  EXPECT_LT(score("weighted", "c", 4)["unseen"]["rmse"]["mean"],
            0.5 * score("retrained", "c", 4)["unseen"]["rmse"]["mean"].get<double>());
  EXPECT_GT(score("weighted", "c", 4)["correlation"]["mean"], 0.9);
  EXPECT_TRUE(score("weighted", "c", 0)["correlation"]["mean"].is_null());
  EXPECT_LT(score("weighted", "c", 0)["unseen"]["r2"]["mean"], 0.0);  // the shift
}

TEST(TransferCommand, WritesAModelOfTheNewGroupThatPredicts) {
  const Workbench bench;
  bench.write("runs.csv", runs(6));
  const auto said =
      bench.run("repose", std::string("transfer") + kTable +
                              "--target c -o c.h5 --next 3 --next-table next.csv.h5 --json");
  ASSERT_EQ(said.code, 0) << said.err;
  const json result = json::parse(said.out);
  EXPECT_EQ(result["source_rows"], 28);
  EXPECT_EQ(result["target_rows"], 8);
  EXPECT_EQ(result["parts"].size(), 5u);
  EXPECT_GT(result["correlation"], 0.9);
  ASSERT_EQ(result["next"].size(), 3u);
  for (const json& row : result["next"]) {
    EXPECT_GE(row, 37);
    EXPECT_LE(row, 42);
  }
  const auto known = lines_of(text_of(bench / "runs.csv"));
  const auto predicted = bench.run("repose", "predict c.h5 runs.csv -o out.csv");
  ASSERT_EQ(predicted.code, 0) << predicted.err;
  const auto out = lines_of(text_of(bench / "out.csv"));
  ASSERT_EQ(out.size(), 43u);
  const auto at = static_cast<std::ptrdiff_t>(out[0].find("angle_deg_predicted"));
  const auto place = std::count(out[0].begin(), out[0].begin() + at, ',');
  for (std::size_t row = 29; row <= 36; ++row)  // c, whose noise is 0.03
    EXPECT_NEAR(number_of(out[row], static_cast<int>(place)), number_of(known[row], 3), 0.3) << row;
  const auto exported = bench.run("repose", "table export next.csv.h5 -o next.csv");
  ASSERT_EQ(exported.code, 0) << exported.err;
  const auto next = lines_of(text_of(bench / "next.csv"));
  ASSERT_EQ(next.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(number_of(next[i + 1], 0), number_of(known[result["next"][i].get<std::size_t>()], 0));
  const auto text = bench.run("repose", std::string("transfer") + kTable + "--target c --next 2");
  EXPECT_NE(text.out.find("correlation of its function with the others': "), std::string::npos);
  EXPECT_NE(text.out.find("to simulate next, in this order (rows of the table): "),
            std::string::npos);
}

TEST(TransferCommand, ChoosesTheFirstRunsOfAGroupThatHasNone) {
  const Workbench bench;
  bench.write("runs.csv", runs(14));
  const auto said = bench.run("repose", std::string("transfer") + kTable + "--target c --next 4");
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("not known without its rows"), std::string::npos);
}

/// What is not used may be incomplete: rows without a response matter for --next alone.
TEST(TransferCommand, LooksAtRowsThatWaitOnlyToChooseAmongThem) {
  const Workbench bench;
  std::string csv = "shape,mu_r,material,angle_deg\n";
  for (int i = 0; i < 24; ++i)
    csv += std::string(i % 2 ? "round" : "flat") + "," + std::to_string(0.04 * i) + "," +
           (i < 16 ? "a" : "c") + "," + std::to_string(20.0 + i + 3 * (i % 2)) + "\n";
  csv += "square,0.5,c,\nround,0.4,,\n";  // rows 25 and 26
  bench.write("runs.csv", csv);
  const std::string command =
      "transfer runs.csv --response angle_deg --input shape,mu_r --group material --target c ";
  const auto adapted = bench.run("repose", command + "-o c.h5");
  EXPECT_EQ(adapted.code, 0) << adapted.err;
  EXPECT_TRUE(std::filesystem::exists(bench / "c.h5"));
  const auto chosen = bench.run("repose", command + "--next 1");
  EXPECT_EQ(chosen.code, 3);
  EXPECT_NE(chosen.err.find("row 25, column shape: 'square' is no level"), std::string::npos)
      << chosen.err;
}

TEST(TransferCommand, KeepsLongNamesOfGroupsApart) {
  const Workbench bench;
  std::string csv = runs(0);
  const auto rename = [&csv](const std::string& from, const std::string& to) {
    for (std::size_t at = csv.find(from); at != std::string::npos;
         at = csv.find(from, at + to.size()))
      csv.replace(at, from.size(), to);
  };
  rename(",a,", ",layering_mode_1,");
  rename(",b,", ",layering_mode_2,");
  rename(",c,", ",Schüttung_é_ö_ü_ß_3,");
  bench.write("runs.csv", csv);
  const auto said = bench.run("repose", std::string("transfer") + kTable +
                                            "--method shift-and-scale --samples 4 --seeds 1");
  ASSERT_EQ(said.code, 0) << said.err;
  std::set<std::size_t> widths;  // of the lines up to the number of rows, in characters
  for (const auto& line : lines_of(said.out)) {
    for (const char* name : {"layering_mode_1 ", "layering_mode_2 ", "Schüttung_é_ö_ü_ß_3 "})
      if (line.starts_with(name)) {
        const std::string margin = line.substr(0, line.find(" 4 ") + 2);
        widths.insert(static_cast<std::size_t>(std::count_if(
            margin.begin(), margin.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; })));
      }
  }
  EXPECT_EQ(widths.size(), 1u) << said.out;
  for (const char* name : {"\nlayering_mode_1 ", "\nlayering_mode_2 ", "\nSchüttung_é_ö_ü_ß_3 "})
    EXPECT_NE(said.out.find(name), std::string::npos) << said.out;
}

TEST(TransferCommand, RefusesWhatCannotBeDone) {
  const Workbench bench;
  bench.write("runs.csv", runs(6));
  const auto refused = [&](const std::string& arguments, int code, const std::string& sentence) {
    const auto said = bench.run("repose", "transfer runs.csv --response angle_deg " + arguments);
    EXPECT_EQ(said.code, code) << arguments << said.err;
    EXPECT_NE(said.err.find(sentence), std::string::npos) << said.err;
  };
  refused("--input mu_s,mu_r --group material --target z -o c.h5", 3, "has no value 'z'");
  refused("--input mu_s,mu_r --group material --target c -o c.h5 --next 7", 3, "6 rows of c wait");
  refused("--input mu_s,mu_r --group material --next 2", 3, "without --target");
  refused("--input mu_s,mu_r --group material --target c -o c.h5 --seeds 2", 3, "with --target");
  refused("--input mu_s,mu_r --group material --target c -o c.h5 --next-table next.h5", 3,
          "without --next");
  for (const std::string target : {"", "--target c -o c.h5 "})
    refused("--input mu_s,mu_r --group material " + target +
                "--model boosted-ensemble --method source-basis",
            3, "boosted-ensemble is none");
  refused("--input mu_s,mu_r --group material --method magic", 3, "there is no way of transfer");
  refused("--input mu_s,mu_r --group material --samples 99", 3, "none would be left unseen");
  refused("--input mu_s,mu_r --group shape", 3, "shape");
  bench.write("runs.csv", "x,g,angle_deg\n1,a,2\n2,a,3\n3,a,4\n");
  refused("--input x --group g", 3, "transfer needs a group");
  EXPECT_FALSE(std::filesystem::exists(bench / "c.h5"));
}

}  // namespace
}  // namespace repose::test

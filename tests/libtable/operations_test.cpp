// Selection, join, append, groups: against what a person would do by hand, and against N^2 twins.
#include "repose/table/operations.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "folder.hpp"
#include "repose/base/random.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;
using Rows = std::vector<std::size_t>;

const double kNan = std::nan("");

Table runs() {
  Table table;
  table.add({.name = "run", .role = Role::id, .values = Integers{1, 2, 2, 3}});
  table.add({.name = "lab", .role = Role::group, .values = Texts{"a", "b", "", "a"}});
  table.add({.name = "angle_deg",
             .unit = "deg",
             .role = Role::response,
             .values = Doubles{20, 22, 24, kNan}});
  table.attributes["origin"] = std::string("test");
  return table;
}

Table design() {
  Table table;
  table.add({.name = "run", .values = Doubles{2, 1, 5}});
  table.add({.name = "mu_s",
             .role = Role::factor,
             .range = FactorRange{0.1, 0.9},
             .values = Doubles{0.5, 0.1, 0.9}});
  table.add({.name = "level", .values = Integers{0, -1, 1}});
  return table;
}

TEST(SelectedColumns, ComeInTheOrderAsked) {
  const Table table = selected_columns(runs(), {"angle_deg", "run"});
  EXPECT_EQ(table.names(), (Texts{"angle_deg", "run"}));
  EXPECT_EQ(table.attributes, runs().attributes);
  EXPECT_THROW(selected_columns(runs(), {"angel_deg"}), InputError);
  EXPECT_THROW(selected_columns(runs(), {"run", "run"}), InputError);
}

TEST(CompleteRows, LackNothingInTheColumnsNamed) {
  EXPECT_EQ(complete_rows(runs(), {"run"}), (Rows{0, 1, 2, 3}));
  EXPECT_EQ(complete_rows(runs(), {"angle_deg"}), (Rows{0, 1, 2}));
  EXPECT_EQ(complete_rows(runs(), {"lab", "angle_deg"}), (Rows{0, 1}));
}

TEST(Grouped, KeepsRowsInOrderOfFirstAppearance) {
  const auto groups = grouped(runs(), {"run"});
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[1].rows, (Rows{1, 2}));
  EXPECT_EQ(grouped(runs(), {"run", "lab"}).size(), 4U);
  EXPECT_NE(message_of<InputError>([] { grouped(runs(), {"angle_deg"}); }).find("row 4"),
            std::string::npos);
  EXPECT_THROW(grouped(runs(), {}), InputError);
}

TEST(Grouped, TextsThatOnlyTogetherLookAlikeAreDifferentKeys) {
  Table table;
  table.add({.name = "a", .values = Texts{"x", "xy"}});
  table.add({.name = "b", .values = Texts{"yz", "z"}});
  EXPECT_EQ(grouped(table, {"a", "b"}).size(), 2U);
}

TEST(GroupMeans, HaveMeanSampleVarianceAndCount) {
  const Table table = group_means(runs(), {"run"}, {"angle_deg"});
  EXPECT_EQ(table.names(), (Texts{"run", "rows", "angle_deg", "angle_deg_variance"}));
  EXPECT_EQ(table.integers("rows"), (Integers{1, 2, 1}));
  EXPECT_EQ(table.numbers("angle_deg")[1], 23.0);
  EXPECT_EQ(table.numbers("angle_deg_variance")[1], 2.0);
  EXPECT_TRUE(std::isnan(table.numbers("angle_deg_variance")[0]));
  EXPECT_TRUE(std::isnan(table.numbers("angle_deg")[2]));
  EXPECT_EQ(table.column("angle_deg_variance").unit, "deg^2");
  EXPECT_EQ(table.column("angle_deg_variance").role, Role::variance);
}

TEST(GroupMeans, VarianceSurvivesALargeMean) {
  Table table;
  table.add({.name = "g", .values = Integers{1, 1, 1}});
  table.add({.name = "y", .values = Doubles{1e9 + 1, 1e9 + 2, 1e9 + 3}});
  EXPECT_EQ(group_means(table, {"g"}, {"y"}).numbers("y_variance")[0], 1.0);
}

TEST(Joined, PairsEqualKeysIntegersWithDecimalNumbersToo) {
  const Table table = joined(runs(), design(), {"run"});
  EXPECT_EQ(table.names(), (Texts{"run", "lab", "angle_deg", "mu_s", "level"}));
  EXPECT_EQ(table.integers("run"), (Integers{1, 2, 2}));
  EXPECT_EQ(table.numbers("mu_s"), (Doubles{0.1, 0.5, 0.5}));
  EXPECT_EQ(table.column("level").values, Values(Integers{-1, 0, 0}));
  EXPECT_EQ(table.column("mu_s").range, (FactorRange{0.1, 0.9}));
  EXPECT_EQ(table.attributes, runs().attributes);
}

TEST(Joined, KeepsLeftRowsWithoutPartnerIfAsked) {
  const Table table = joined(runs(), design(), {"run"}, Join::left);
  ASSERT_EQ(table.rows(), 4U);
  EXPECT_TRUE(std::isnan(table.numbers("mu_s")[3]));
  EXPECT_TRUE(std::isnan(table.numbers("level")[3]));
}

TEST(Joined, RefusesWhatCannotBeMatched) {
  Table other;
  other.add({.name = "lab", .values = Integers{1}});
  other.add({.name = "angle_deg", .values = Doubles{1}});
  EXPECT_NE(message_of<InputError>([&] { joined(runs(), other, {"lab"}); }).find("holds text"),
            std::string::npos);
  EXPECT_NE(message_of<InputError>([&] { joined(runs(), runs(), {"run"}); }).find("\"lab\""),
            std::string::npos);
  EXPECT_THROW(joined(runs(), other, {"run"}), InputError);
  EXPECT_THROW(joined(runs(), other, {}), InputError);
}

TEST(Joined, EqualsTheDoubleLoop) {
  RandomStream random(5);
  const auto table = [&](const char* value, std::size_t rows) {
    Integers a;
    Texts b;
    Integers v;
    for (std::size_t i = 0; i < rows; ++i) {
      a.push_back(static_cast<std::int64_t>(random.below(5)));
      b.push_back(std::string(random.below(3), 'x'));
      v.push_back(static_cast<std::int64_t>(i));
    }
    Table result;
    result.add({.name = "a", .values = a});
    result.add({.name = "b", .values = b});
    result.add({.name = value, .values = v});
    return result;
  };
  const Table left = table("l", 60), right = table("r", 40);
  Integers expected_l, expected_r;
  for (std::size_t i = 0; i < left.rows(); ++i)
    for (std::size_t j = 0; j < right.rows(); ++j)
      if (left.integers("a")[i] == right.integers("a")[j] &&
          left.texts("b")[i] == right.texts("b")[j]) {
        expected_l.push_back(left.integers("l")[i]);
        expected_r.push_back(right.integers("r")[j]);
      }
  const Table both = joined(left, right, {"a", "b"});
  EXPECT_EQ(both.integers("l"), expected_l);
  EXPECT_EQ(both.integers("r"), expected_r);
  EXPECT_GT(expected_l.size(), 60U);
}

TEST(Appended, PutsTheSecondBelowTheFirst) {
  const Table table = appended(runs(), runs().selected_rows({0}));
  EXPECT_EQ(table.integers("run"), (Integers{1, 2, 2, 3, 1}));
  EXPECT_EQ(table.column("angle_deg").role, Role::response);
}

TEST(Appended, FillsUnmatchedColumnsOnlyIfAllowed) {
  EXPECT_NE(message_of<InputError>([] {
              appended(runs(), design());
            }).find("\"lab\" is only in the first"),
            std::string::npos);
  const Table table = appended(runs(), design(), Unmatched::missing);
  EXPECT_EQ(table.numbers("run"), (Doubles{1, 2, 2, 3, 2, 1, 5}));
  EXPECT_EQ(table.texts("lab")[4], "");
  EXPECT_TRUE(std::isnan(table.numbers("angle_deg")[5]));
  EXPECT_TRUE(std::isnan(table.numbers("mu_s")[3]));
  EXPECT_EQ(table.numbers("mu_s")[6], 0.9);
}

TEST(Appended, RefusesOtherUnitsAndTypes) {
  Table radians = runs();
  Table other;
  for (Column column : radians.columns()) {
    if (column.name == "angle_deg") column.unit = "rad";
    other.add(column);
  }
  EXPECT_NE(
      message_of<InputError>([&] { appended(runs(), other); }).find("deg in one table and rad"),
      std::string::npos);
  Table numbers;
  numbers.add({.name = "x", .values = Integers{1}});
  Table texts;
  texts.add({.name = "x", .values = Texts{"1"}});
  EXPECT_THROW(appended(numbers, texts), InputError);
}

TEST(WithRoles, ChangesTheNamedColumnsAndRefusesTextAsANumber) {
  const Table table = with_roles(runs(), {{"run", Role::replicate}, {"angle_deg", Role::none}});
  EXPECT_EQ(table.names(), runs().names());
  EXPECT_EQ(table.names_with_role(Role::replicate), Texts{"run"});
  EXPECT_EQ(table.names_with_role(Role::response), Texts{});
  EXPECT_EQ(table.names_with_role(Role::group), Texts{"lab"});
  EXPECT_EQ(table.attributes, runs().attributes);
  EXPECT_THROW(with_roles(runs(), {{"lab", Role::factor}}), InputError);
  EXPECT_THROW(with_roles(runs(), {{"laboratory", Role::group}}), InputError);
}

}  // namespace
}  // namespace repose::table

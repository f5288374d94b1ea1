// Tables in memory: what they accept, give and refuse.
#include "repose/table/table.hpp"

#include <gtest/gtest.h>

#include "folder.hpp"
#include "repose/base/error.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

Table small() {
  Table table;
  table.add({.name = "mu", .role = Role::factor, .values = Doubles{0.1, 0.2, 0.3}});
  table.add({.name = "run", .role = Role::id, .values = Integers{1, 2, 3}});
  table.add({.name = "lab", .role = Role::group, .values = Texts{"a", "b", "a"}});
  table.add(
      {.name = "angle", .unit = "deg", .role = Role::response, .values = Doubles{20, 21, 22}});
  return table;
}

TEST(Table, KeepsColumnsInOrder) {
  const Table table = small();
  EXPECT_EQ(table.rows(), 3u);
  EXPECT_EQ(table.names(), (Texts{"mu", "run", "lab", "angle"}));
  EXPECT_EQ(table.names_with_role(Role::factor), Texts{"mu"});
  EXPECT_EQ(table.names_with_role(Role::weight), Texts{});
  EXPECT_TRUE(table.has("lab"));
  EXPECT_FALSE(table.has("Lab"));
  EXPECT_EQ(table.column("angle").unit, "deg");
}

TEST(Table, WithoutColumnsHasNoRows) {
  EXPECT_EQ(Table{}.rows(), 0u);
  EXPECT_NE(message_of<InputError>([] { Table{}.column("x"); }).find("none at all"),
            std::string::npos);
}

TEST(Table, RefusesColumnsThatDoNotFit) {
  Table table = small();
  EXPECT_THROW(table.add({.name = "", .values = Doubles{1, 2, 3}}), InputError);
  EXPECT_THROW(table.add({.name = "mu", .values = Doubles{1, 2, 3}}), InputError);
  const std::string message = message_of<InputError>([&] {
    table.add({.name = "short", .values = Doubles{1, 2}});
  });
  EXPECT_EQ(message,
            "column \"short\" has 2 rows, but the table has 3; columns must be equally long");
  EXPECT_EQ(table.columns().size(), 4u);
}

TEST(Table, NamesWhatExistsWhenAColumnDoesNot) {
  const Table table = small();
  EXPECT_EQ(message_of<InputError>([&] { table.numbers("angel"); }),
            "the table has no column \"angel\"; did you mean \"angle\"?");
  EXPECT_EQ(message_of<InputError>([&] { table.column("discharge_rate"); }),
            "the table has no column \"discharge_rate\"; it has mu, run, lab and angle");
}

TEST(Table, ConvertsOnlyWhatKeepsItsMeaning) {
  Table table = small();
  EXPECT_EQ(table.numbers("run"), (Doubles{1, 2, 3}));
  EXPECT_EQ(table.integers("angle"), (Integers{20, 21, 22}));
  EXPECT_EQ(table.texts("lab"), (Texts{"a", "b", "a"}));
  EXPECT_THROW(table.numbers("lab"), InputError);
  EXPECT_THROW(table.texts("mu"), InputError);
  EXPECT_EQ(message_of<InputError>([&] { table.integers("mu"); }),
            "column \"mu\" holds 0.1 in row 1; an integer is needed");
  table.add({.name = "large", .values = Doubles{-9223372036854775808.0, 0, 9223372036854775808.0}});
  EXPECT_NE(message_of<InputError>([&] { table.integers("large"); }).find("row 3"),
            std::string::npos);
}

TEST(Table, MatrixHasARowForEachRowAndAColumnForEachName) {
  const Matrix x = small().matrix({"angle", "mu"});
  ASSERT_EQ(x.rows(), 3);
  ASSERT_EQ(x.cols(), 2);
  EXPECT_EQ(x(2, 0), 22.0);
  EXPECT_EQ(x(0, 1), 0.1);
}

TEST(Table, SelectedRowsKeepOrderRolesAndAttributes) {
  Table table = small();
  table.attributes["method"] = std::string("sobol");
  const Table selected = table.selected_rows({2, 0, 2});
  EXPECT_EQ(selected.integers("run"), (Integers{3, 1, 3}));
  EXPECT_EQ(selected.texts("lab"), (Texts{"a", "a", "a"}));
  EXPECT_EQ(selected.column("angle").role, Role::response);
  EXPECT_EQ(selected.attributes, table.attributes);
  EXPECT_EQ(table.selected_rows({}).rows(), 0u);
  EXPECT_THROW(table.selected_rows({3}), Error);
}

TEST(Table, FactorColumnKnowsWhatTheParameterKnows) {
  const Column column = factor_column(
      {.name = "e", .lower = 1e6, .upper = 1e8, .scale = Scale::log, .unit = "Pa"}, {1e7});
  EXPECT_EQ(column.name, "e");
  EXPECT_EQ(column.unit, "Pa");
  EXPECT_EQ(column.role, Role::factor);
  EXPECT_EQ(column.range, (FactorRange{1e6, 1e8, Scale::log}));
}

TEST(Role, NamesReadBack) {
  for (const Role role : {Role::none, Role::factor, Role::response, Role::group, Role::replicate,
                          Role::variance, Role::weight, Role::id})
    EXPECT_EQ(role_from_name(role_name(role)), role);
  EXPECT_THROW(role_from_name("Factor"), InputError);
}

TEST(Provenance, SaysVersionCommandSeedAndParents) {
  Table table;
  stamp_provenance(table, "repose design dsd", 7, {"factors.toml"});
  EXPECT_EQ(std::get<std::string>(table.attributes.at("command_line")), "repose design dsd");
  EXPECT_EQ(std::get<std::int64_t>(table.attributes.at("seed")), 7);
  EXPECT_EQ(std::get<Texts>(table.attributes.at("parents")), Texts{"factors.toml"});
  EXPECT_FALSE(std::get<std::string>(table.attributes.at("repose_version")).empty());
  stamp_provenance(table, "repose table import", std::nullopt, {});
  EXPECT_FALSE(table.attributes.contains("seed"));
  EXPECT_THROW(stamp_provenance(table, "", std::uint64_t{1} << 63, {}), InputError);
}

}  // namespace
}  // namespace repose::table

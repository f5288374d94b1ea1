// Tables that pandas, PyTables, h5py and MATLAB stored in their own ways. The files come from the
// scripts beside them, the pandas and PyTables ones written by these programs.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "folder.hpp"
#include "repose/table/io.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

std::filesystem::path data(const std::string& name) {
  return std::filesystem::path(REPOSE_TEST_DATA) / "table" / name;
}
Table read(const std::string& name, const std::string& group) {
  return read_table({data(name), group}, Missing::allow);
}
std::string refusal(const std::string& name, const std::string& group) {
  return message_of<InputError>([&] { read(name, group); });
}
void expect_says(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos) << message;
}

void expect_frame(const Table& table) {
  EXPECT_EQ(table.integers("index"), (Integers{0, 1, 2}));
  EXPECT_EQ(table.numbers("mu_s_pp"), (Doubles{0.1, 1.0 / 3.0, 0.9}));
  EXPECT_EQ(table.numbers("angle_deg")[0], 20.5);
  EXPECT_TRUE(std::isnan(table.numbers("angle_deg")[1]));
  EXPECT_EQ(table.column("run").values, Values(Integers{1, 2, std::int64_t{1} << 40}));
  EXPECT_EQ(table.texts("lab"), (Texts{"Delft", "Freiberg", "Tōkyō"}));
  EXPECT_EQ(table.column("passed").values, Values(Integers{1, 0, 1}));
  EXPECT_EQ(table.columns().size(), 6U);
  EXPECT_EQ(table.names_with_role(Role::id), Texts{"index"});
  EXPECT_TRUE(table.attributes.empty());
}

TEST(PandasFrame, InTableFormatHasItsOwnColumnNames) {
  EXPECT_EQ(list_tables(data("pandas_table.h5")), Texts{"/runs/table"});
  for (const char* group : {"", "/runs", "/runs/table"}) {
    const Table table = read("pandas_table.h5", group);
    expect_frame(table);
    EXPECT_EQ(table.names(), (Texts{"index", "mu_s_pp", "angle_deg", "run", "lab", "passed"}));
  }
  expect_says(message_of<InputError>([] {
                read_table({data("pandas_table.h5"), ""});
              }),
              "row 2 of column \"angle_deg\" has no value");
}

TEST(PandasFrame, WithDataColumnsIsTheSameTable) {
  expect_frame(read("pandas_data_columns.h5", ""));
}

TEST(PandasFrame, InFixedFormatIsRefusedWithTheWayOut) {
  expect_says(refusal("pandas_fixed.h5", ""), "store it with to_hdf(..., format=\"table\")");
  expect_says(refusal("pandas_fixed.h5", "/runs"), "format=\"fixed\"");
}

TEST(PyTablesTable, HasAColumnForEachMemberAndEachElementOfAnArray) {
  EXPECT_EQ(list_tables(data("pytables.h5")), Texts{"/study/runs"});
  const Table table = read("pytables.h5", "");
  EXPECT_EQ(table.names(), (Texts{"run", "mass_kg", "material", "is_valid", "position_m_1",
                                  "position_m_2", "position_m_3"}));
  EXPECT_EQ(table.integers("run"), (Integers{1, 2, 3, 4}));
  EXPECT_EQ(table.numbers("mass_kg"), (Doubles{0.0, 0.5, 1.0, 1.5}));
  EXPECT_EQ(table.texts("material"), (Texts{"pellet_0", "pellet_1", "pellet_2", "pellet_3"}));
  EXPECT_EQ(table.integers("is_valid"), (Integers{1, 0, 1, 0}));
  EXPECT_EQ(table.numbers("position_m_2"), (Doubles{0, 10, 20, 30}));
  EXPECT_EQ(table.numbers("position_m_3"), (Doubles{0, -1, -2, -3}));
}

TEST(CompoundDataset, GivesColumnsOfItsMembersTypes) {
  const Table table = read("arrays.h5", "/records");
  EXPECT_EQ(table.names(), (Texts{"run", "mass_kg", "note", "good", "site_1", "site_2"}));
  EXPECT_EQ(table.column("run").values, Values(Integers{1, 2}));
  EXPECT_EQ(table.column("mass_kg").values, Values(Doubles{0.5, 1.5}));
  EXPECT_EQ(table.texts("note"), (Texts{"ab", "abc"}));
  EXPECT_EQ(table.integers("good"), (Integers{1, 0}));
  EXPECT_EQ(table.integers("site_2"), (Integers{2, 4}));
  EXPECT_EQ(read("arrays.h5", "/texts").texts("lab"), (Texts{"a", "ß"}));
  expect_says(refusal("arrays.h5", "/nested"), "/nested, member \"a\" has a type that is neither");
}

TEST(Array, HasTheNamesBesideItOrNumbers) {
  const Table plain = read("arrays.h5", "/plain");
  EXPECT_EQ(plain.names(), (Texts{"c1", "c2", "c3"}));
  EXPECT_EQ(plain.numbers("c2"), (Doubles{1, 4, 7, 10}));
  for (const char* group : {"/by_column_names", "/by_columns", "/by_names"}) {
    const Table table = read("arrays.h5", group);
    EXPECT_EQ(table.names(), (Texts{"mu_s", "mu_r", "angle_deg"})) << group;
    EXPECT_EQ(table.numbers("angle_deg"), (Doubles{2, 5, 8, 11}));
    EXPECT_TRUE(table.attributes.empty());
  }
  expect_says(refusal("arrays.h5", "/misnamed"), "must be an array of 3 texts");
  expect_says(refusal("arrays.h5", "/cube"), "has 3 dimensions");
  expect_says(refusal("arrays.h5", "/words"), "does not hold real numbers");
}

TEST(Array, OfManyBlocksComesWhole) {
  const Table table = read("arrays.h5", "/chunked");
  ASSERT_EQ(table.rows(), 20000U);
  const std::vector<std::int64_t> c3 = table.integers("c3");
  for (std::size_t row = 0; row < c3.size(); ++row)
    ASSERT_EQ(c3[row], static_cast<std::int64_t>((3 * row + 2) % 97)) << row;
}

TEST(Array, BesideColumnsIsSeveralColumns) {
  const Table table = read("arrays.h5", "/mixed");
  EXPECT_EQ(table.names(), (Texts{"position_m_1", "position_m_2", "position_m_3", "x"}));
  EXPECT_EQ(table.numbers("position_m_1"), (Doubles{0, 3, 6, 9}));
}

TEST(Arrays, ThatShareAFileAreListedAndMustBeNamed) {
  EXPECT_EQ(list_tables(data("arrays.h5")),
            (Texts{"/by_column_names", "/by_columns", "/by_names", "/chunked", "/cube", "/misnamed",
                   "/nested", "/plain", "/records", "/texts", "/mixed", "/words/matrix"}));
  expect_says(refusal("arrays.h5", ""), "12 tables, /by_column_names, ");
  expect_says(refusal("arrays.h5", "/"), "choose one, e.g. " + data("arrays.h5").string() + ":/by");
}

TEST(MatlabFile, HasArraysAndStructsOfArraysAsTables) {
  EXPECT_EQ(list_tables(data("matlab_v73.mat")),
            (Texts{"/A", "/z", "/array_of_structs", "/cells", "/runs"}));
  const Table array = read("matlab_v73.mat", "/A");
  EXPECT_EQ(array.names(), (Texts{"c1", "c2", "c3"}));
  EXPECT_EQ(array.numbers("c1"), (Doubles{1, 2}));
  EXPECT_EQ(array.numbers("c3"), (Doubles{100, 200}));
  const Table runs = read("matlab_v73.mat", "/runs");
  EXPECT_EQ(runs.names(), (Texts{"angle_deg", "mu_s", "passed", "position_1", "position_2"}));
  EXPECT_EQ(runs.numbers("mu_s"), (Doubles{0.1, 0.2, 0.3}));
  EXPECT_EQ(runs.numbers("angle_deg")[1], 22.0);
  EXPECT_EQ(runs.integers("passed"), (Integers{1, 0, 1}));
  EXPECT_EQ(runs.integers("position_2"), (Integers{2, 4, 6}));
  EXPECT_TRUE(runs.attributes.empty());
}

TEST(MatlabFile, SaysWhatItHoldsThatIsNoTableAndTheWayOut) {
  expect_says(refusal("matlab_v73.mat", "/t"), "MATLAB object of class table");
  expect_says(refusal("matlab_v73.mat", "/t"), "table2struct(t, 'ToScalar', true)");
  expect_says(refusal("matlab_v73.mat", "/sparse"), "store full(x)");
  expect_says(refusal("matlab_v73.mat", "/z"), "complex numbers");
  expect_says(refusal("matlab_v73.mat", "/none"), "empty MATLAB array");
  expect_says(refusal("matlab_v73.mat", "/cells"), "has the MATLAB class cell");
  expect_says(refusal("matlab_v73.mat", "/array_of_structs"), "array of structs");
}

class MatlabBefore73 : public FolderTest {};

TEST_F(MatlabBefore73, IsRefusedWithTheWayOut) {
  std::ofstream(file("old.mat"), std::ios::binary)
      << "MATLAB 5.0 MAT-file, Platform: GLNXA64" << std::string(500, ' ');
  expect_says(message_of<StorageError>([&] {
                read_table({file("old.mat"), ""});
              }),
              "save(FILE, '-v7.3')");
}

}  // namespace
}  // namespace repose::table

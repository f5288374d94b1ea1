// Tables read by column and in blocks: the same values as at once, in little memory.
#include "repose/table/reader.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "folder.hpp"
#include "memory.hpp"
#include "python.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

class Reader : public FolderTest {};

TEST_F(Reader, GivesRowsOfEveryTypeAsReadTableDoes) {
  const Table table = every_kind_of_value();
  for (const char* name : {"t.h5", "t.csv"}) {
    write_table({file(name), ""}, table);
    const TableReader reader({file(name), ""});
    EXPECT_EQ(reader.rows(), table.rows());
    EXPECT_EQ(reader.header().names(), table.names());
    EXPECT_EQ(reader.header().column("mass_flow").unit, "kg/s");
    for (const std::string& column : table.names()) {
      const std::vector<std::size_t> middle{2, 3, 4};
      EXPECT_TRUE(same_bits(reader.values(column, 0, 7), table.column(column).values)) << column;
      EXPECT_TRUE(
          same_bits(reader.values(column, 2, 3), table.selected_rows(middle).column(column).values))
          << column;
      EXPECT_EQ(length(reader.values(column, 7, 0)), 0U);
    }
    EXPECT_THROW(reader.values("mass_flow", 5, 3), InputError);
    EXPECT_THROW(reader.values("mass_flow", 8, 0), InputError);
    EXPECT_THROW(reader.values("mass", 0, 1), InputError);
  }
}

TEST_F(Reader, ReadsRowsOfArraysAndRecords) {
  const auto data = std::filesystem::path(REPOSE_TEST_DATA) / "table";
  const TableReader records({data / "pytables.h5", ""});
  EXPECT_EQ(records.values("position_m_2", 1, 2), Values(Doubles{10, 20}));
  EXPECT_EQ(records.values("material", 3, 1), Values(Texts{"pellet_3"}));
  const TableReader array({data / "matlab_v73.mat", "/A"});
  EXPECT_EQ(array.values("c3", 1, 1), Values(Doubles{200}));
}

TEST_F(Reader, NamesTheRowThatIsNotAllowedInTheWholeTable) {
  Doubles values(300000, 1.0);
  values[200001] = std::nan("");
  Table table;
  table.add({.name = "x", .values = values});
  write_table({file("t.h5"), ""}, table);
  const auto pass = [&](Missing missing) {
    std::size_t rows = 0;
    TableReader({file("t.h5"), ""}, missing)
        .for_each_block("x", [&](std::size_t first, const Values& block) {
          EXPECT_EQ(first, rows);
          rows += length(block);
        });
    return rows;
  };
  EXPECT_NE(message_of<InputError>([&] { pass(Missing::refuse); }).find("row 200002 of column"),
            std::string::npos);
  EXPECT_EQ(pass(Missing::allow), values.size());
}

TEST_F(Reader, KeepsReadingTheFileThatItOpened) {
  Table table;
  table.add({.name = "x", .values = Integers{1, 2}});
  write_table({file("t.h5"), ""}, table);
  const TableReader reader({file("t.h5"), ""});
  write_table({file("t.h5"), ""}, Table{});
  EXPECT_EQ(reader.values("x", 0, 2), Values(Integers{1, 2}));
}

TEST_F(Reader, HoldsABlockAndNotTheColumn) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer holds freed memory back";
#endif
  constexpr double kRows = 4e6;
  run_python(file(""), R"(
with h5py.File(path, 'w') as f:
    for name in 'abc':
        f.create_dataset('t/' + name, data=np.arange(4e6), chunks=(65536,))
)");
  const TableReader reader({file("t.h5"), ""});
  reset_peak();
  const std::size_t before = peak_bytes();
  for (const char* column : {"a", "b", "c"}) {
    double sum = 0.0;
    reader.for_each_block(column, [&](std::size_t, const Values& block) {
      for (const double value : std::get<Doubles>(block)) sum += value;
    });
    EXPECT_EQ(sum, 0.5 * kRows * (kRows - 1));  // exact: below 2^53
  }
  // A column is 32 MB. A block is 1 MB, held twice at most; HDF5 caches 1 MB a dataset.
  EXPECT_LT(peak_bytes() - before, std::size_t{12} << 20);
}

}  // namespace
}  // namespace repose::table

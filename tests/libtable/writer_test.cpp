// Tables written in blocks: the same as at once, in little memory, whole or not at all.
#include "repose/table/writer.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>

#include "folder.hpp"
#include "memory.hpp"
#include "repose/base/file.hpp"
#include "repose/table/reader.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

class Writer : public FolderTest {};

/// Rows [first, first + count) of a table of every type whose values follow from their row.
Table rows_from(std::size_t first, std::size_t count) {
  Doubles x(count);
  Integers n(count);
  Texts text(count);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = 0.1 * static_cast<double>(first + i);
    n[i] = static_cast<std::int64_t>(first + i);
    text[i] = "row " + std::to_string((first + i) % 97);
  }
  Table table;
  table.add({.name = "x",
             .unit = "m",
             .role = Role::factor,
             .range = FactorRange{0.0, 1e6, Scale::linear},
             .values = std::move(x)});
  table.add({.name = "n", .role = Role::id, .values = std::move(n)});
  table.add({.name = "text", .role = Role::group, .values = std::move(text)});
  table.attributes["study"] = std::string("blocks");
  return table;
}

void expect_same(const Table& back, const Table& table) {
  ASSERT_EQ(back.names(), table.names());
  for (const std::string& name : table.names()) {
    EXPECT_TRUE(same_bits(back.column(name).values, table.column(name).values)) << name;
    EXPECT_EQ(back.column(name).unit, table.column(name).unit);
    EXPECT_EQ(back.column(name).role, table.column(name).role);
    EXPECT_EQ(back.column(name).range, table.column(name).range);
  }
}

TEST_F(Writer, MakesOfBlocksTheTableThatIsWrittenAtOnce) {
  constexpr std::size_t kRows = 200001;  // three pieces and a row
  const Table whole = rows_from(0, kRows);
  TableWriter writer({file("t.h5"), "/deep/t"}, rows_from(0, 0));
  std::size_t row = 0;
  for (const std::size_t count : {1UL, 0UL, 150000UL, 7UL, 49993UL}) {
    writer.append(rows_from(row, count));
    row += count;
    EXPECT_EQ(writer.rows(), row);
  }
  EXPECT_FALSE(std::filesystem::exists(file("t.h5")));
  writer.finish();
  EXPECT_EQ(files(), 1);
  const Table back = read_table({file("t.h5"), "/deep/t"});
  expect_same(back, whole);
  EXPECT_EQ(back.attributes.at("study"), Attribute(std::string("blocks")));
}

TEST_F(Writer, StoresASmallTableAsWriteTableDoes) {
  const Table table = every_kind_of_value();
  for (const char* name : {"small.h5", "small.csv"}) {
    write_table({file(name), ""}, table);
    const std::string at_once = read_file(file(name));
    TableWriter writer({file(name), ""}, table.selected_rows({}));
    writer.append(table.selected_rows({0, 1, 2, 3}));
    writer.append(table.selected_rows({4, 5, 6}));
    writer.finish();
    if (std::string_view(name).ends_with("csv"))
      EXPECT_EQ(read_file(file(name)), at_once);
    else
      EXPECT_EQ(std::filesystem::file_size(file(name)), at_once.size());
  }
}

TEST_F(Writer, CopiesWhatAReaderReads) {
  write_table({file("a.h5"), ""}, rows_from(0, 1000));
  const TableReader reader({file("a.h5"), ""});
  TableWriter writer({file("b.h5"), ""}, reader.header());
  for (std::size_t first = 0; first < 1000; first += 250) {
    Table block = reader.header();
    Table values;
    for (Column column : block.columns()) {
      column.values = reader.values(column.name, first, 250);
      values.add(std::move(column));
    }
    writer.append(values);
  }
  writer.finish();
  expect_same(read_table({file("b.h5"), ""}), rows_from(0, 1000));
}

TEST_F(Writer, WithoutRowsWritesATableWithoutRows) {
  TableWriter writer({file("t.h5"), ""}, rows_from(0, 0));
  writer.finish();
  EXPECT_EQ(read_table({file("t.h5"), ""}).rows(), 0U);
  EXPECT_EQ(read_table({file("t.h5"), ""}).texts("text"), Texts{});
}

TEST_F(Writer, RefusesABlockThatDoesNotFitAndGoesOn) {
  EXPECT_THROW(TableWriter({file("t.h5"), ""}, rows_from(0, 2)), InputError);
  EXPECT_THROW(TableWriter({file("t.csv"), ""}, Table{}), InputError);
  TableWriter writer({file("t.h5"), ""}, rows_from(0, 0));
  writer.append(rows_from(0, 10));
  const auto refusal = [&](const Table& block) {
    return message_of<InputError>([&] { writer.append(block); });
  };
  Table table = rows_from(10, 2);
  table.add({.name = "y", .values = Doubles{1, 2}});
  EXPECT_NE(refusal(table).find("no column \"y\", which a block has"), std::string::npos);
  EXPECT_NE(refusal(Table{}).find("no column \"x\""), std::string::npos);
  const auto with = [](Column column) {
    const Table fitting = rows_from(10, 2);
    Table block;
    for (Column other : fitting.columns())
      block.add(other.name == column.name ? column : std::move(other));
    return block;
  };
  EXPECT_NE(refusal(with({.name = "x", .unit = "cm", .values = Doubles{1, 2}})).find("the unit m"),
            std::string::npos);
  EXPECT_NE(refusal(with({.name = "n", .values = Doubles{1, 2}})).find("holds integers"),
            std::string::npos);
  EXPECT_NE(refusal(with({.name = "x", .unit = "m", .values = Doubles{1, HUGE_VAL}}))
                .find("row 12 of column \"x\" is infinite"),
            std::string::npos);
  EXPECT_NE(refusal(with({.name = "text", .values = Texts{"a", std::string("b\0", 2)}}))
                .find("NUL character"),
            std::string::npos);
  writer.append(rows_from(10, 2));
  writer.finish();
  expect_same(read_table({file("t.h5"), ""}), rows_from(0, 12));
}

TEST_F(Writer, ThatIsNotFinishedLeavesTheOldFile) {
  for (const char* name : {"t.h5", "t.csv"}) {
    write_table({file(name), ""}, rows_from(0, 3));
    const std::string before = read_file(file(name));
    {
      TableWriter writer({file(name), ""}, rows_from(0, 0));
      writer.append(rows_from(0, 100000));
      EXPECT_THROW(write_table({file(name), ""}, rows_from(0, 1)), StorageError);
      EXPECT_THROW(TableWriter({file(name), ""}, rows_from(0, 0)), StorageError);
      EXPECT_EQ(read_file(file(name)), before);
    }
    EXPECT_EQ(read_file(file(name)), before);
    std::filesystem::remove(file(name));
    EXPECT_EQ(files(), 0);
  }
}

/// Files of this process cannot grow beyond `bytes` meanwhile, as on a disk that is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST_F(Writer, SaysThatTheDiskIsFullAndLeavesTheOldFile) {
  for (const char* name : {"t.h5", "t.csv"}) {
    write_table({file(name), ""}, rows_from(0, 3));
    const std::string before = read_file(file(name));
    {
      const FullDisk disk(rlim_t{1} << 20);
      TableWriter writer({file(name), ""}, rows_from(0, 0));
      const auto fill = [&] {
        for (std::size_t k = 0; k < 8; ++k) writer.append(rows_from(k * 70000, 70000));
        writer.finish();
      };
      EXPECT_NE(message_of<StorageError>(fill).find("cannot write " + file(name).string()),
                std::string::npos);
      EXPECT_NE(message_of<StorageError>([&] { writer.append(rows_from(0, 1)); }).find("earlier"),
                std::string::npos);
      EXPECT_THROW(write_table({file("other.h5"), ""}, rows_from(0, 300000)), StorageError);
    }
    EXPECT_EQ(read_file(file(name)), before);
    std::filesystem::remove(file(name));
    EXPECT_EQ(files(), 0);
  }
}

TEST_F(Writer, HoldsAPieceAndNotTheTable) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer holds freed memory back";
#endif
  constexpr std::size_t kColumns = 20, kBlock = 50000, kBlocks = 20;
  const auto block = [](std::size_t first, std::size_t rows) {
    Table table;
    for (std::size_t j = 0; j < kColumns; ++j) {
      Doubles values(rows);
      for (std::size_t i = 0; i < rows; ++i)  // incompressible: 160 MB on disk
        values[i] = std::sqrt(static_cast<double>((first + i) * kColumns + j));
      table.add({.name = "c" + std::to_string(j), .values = std::move(values)});
    }
    return table;
  };
  reset_peak();
  const std::size_t before = peak_bytes();
  {
    TableWriter writer({file("t.h5"), ""}, block(0, 0));
    for (std::size_t k = 0; k < kBlocks; ++k) writer.append(block(k * kBlock, kBlock));
    writer.finish();
  }
  EXPECT_GT(std::filesystem::file_size(file("t.h5")), 8 * kColumns * kBlock * kBlocks);
  // A block is 8 MB, the writer's piece 10.5, HDF5's chunks as much again; vectors that grow by
  // doubling may hold twice their size.
  EXPECT_LT(peak_bytes() - before, std::size_t{48} << 20);
  const TableReader reader({file("t.h5"), ""});
  EXPECT_EQ(reader.rows(), kBlock * kBlocks);
  EXPECT_EQ(reader.values("c7", 777777, 1), Values(Doubles{std::sqrt(777777.0 * kColumns + 7)}));
}

}  // namespace
}  // namespace repose::table

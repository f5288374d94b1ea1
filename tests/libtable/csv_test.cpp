// CSV: the same bits and types come back; other programs' dialects are understood.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "folder.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "repose/table/io.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

Table parsed(const std::string& text, Missing missing = Missing::refuse) {
  return parse_csv(text, "t.csv", missing);
}
std::string refusal(const std::string& text) {
  return message_of<InputError>([&] { parsed(text); });
}

class CsvFile : public FolderTest {};

TEST_F(CsvFile, KeepsNamesUnitsTypesAndAllBits) {
  const Table table = every_kind_of_value();
  write_table({file("t.csv"), ""}, table);
  const Table back = read_table({file("t.csv"), ""});
  ASSERT_EQ(back.names(), table.names());
  for (const Column& column : table.columns()) {
    EXPECT_TRUE(same_bits(back.column(column.name).values, column.values)) << column.name;
    EXPECT_EQ(back.column(column.name).unit, column.unit);
  }
  EXPECT_EQ(files(), 1);
}

TEST_F(CsvFile, KeepsAnyBitPatternOfAFiniteDouble) {
  RandomStream random(1);
  Doubles values;
  while (values.size() < 20000) {
    const double value = std::bit_cast<double>(random.next_u64());
    if (std::isfinite(value)) values.push_back(value);
  }
  Table table;
  table.add({.name = "x", .values = values});
  EXPECT_TRUE(same_bits(parsed(csv_text(table)).column("x").values, values));
}

TEST_F(CsvFile, FailedWriteLeavesTheOldFile) {
  Table table;
  table.add({.name = "x", .values = Doubles{1.0}});
  write_csv(file("t.csv"), table);
  const std::string before = read_file(file("t.csv"));
  Table infinite;
  infinite.add({.name = "x", .values = Doubles{1.0, -std::numeric_limits<double>::infinity()}});
  EXPECT_NE(message_of<InputError>([&] {
              write_csv(file("t.csv"), infinite);
            }).find("row 2 of column \"x\" is infinite"),
            std::string::npos);
  EXPECT_EQ(read_file(file("t.csv")), before);
  EXPECT_EQ(files(), 1);
  EXPECT_THROW(write_csv(file("nowhere/t.csv"), table), StorageError);
  EXPECT_THROW(write_csv(file("t.csv"), Table{}), InputError);
  EXPECT_THROW(read_csv(file("absent.csv")), StorageError);
}

TEST(Csv, WritesWhatAPersonWouldWrite) {
  Table table;
  table.add({.name = "run", .values = Integers{1, 2}});
  table.add({.name = "flow", .unit = "kg/s", .values = Doubles{0.5, std::nan("")}});
  table.add({.name = "lab", .values = Texts{"Freiberg", ""}});
  EXPECT_EQ(csv_text(table), "run,flow [kg/s],lab\n1,0.5,Freiberg\n2,nan,\"\"\n");
}

TEST(Csv, ReadsByteOrderMarkCrlfAndMissingLastLineEnd) {
  const Table table = parsed(
      "\xef\xbb\xbf"
      "a,b [mm]\r\n1,2.5\r\n\r\n3,4");
  EXPECT_EQ(table.names(), (Texts{"a", "b"}));
  EXPECT_EQ(table.column("b").unit, "mm");
  EXPECT_EQ(table.integers("a"), (Integers{1, 3}));
  EXPECT_EQ(table.numbers("b"), (Doubles{2.5, 4.0}));
}

TEST(Csv, FindsTheTypeOfEachColumn) {
  const Table table = parsed("i,d,t,q,big\n1, 1e3 ,1,\"7\",9223372036854775808\n+2,.5,x,\"8\",1\n");
  EXPECT_EQ(table.column("i").values, Values(Doubles{1, 2}));  // "+2" is no C++ integer
  EXPECT_EQ(table.column("d").values, Values(Doubles{1000, 0.5}));
  EXPECT_EQ(table.column("t").values, Values(Texts{"1", "x"}));
  EXPECT_EQ(table.column("q").values, Values(Texts{"7", "8"}));
  EXPECT_EQ(table.column("big").values, Values(Doubles{9223372036854775808.0, 1}));
}

TEST(Csv, QuotesMeanNothingWhereEveryCellIsQuoted) {
  const Table table = parsed("\"a\",\"b\"\n\"1\",\"x\"\n\"2\",\"y\"\n");
  EXPECT_EQ(table.integers("a"), (Integers{1, 2}));
  EXPECT_EQ(table.texts("b"), (Texts{"x", "y"}));
}

TEST(Csv, NumbersBelowTheSmallestDoubleAreZeroAndAboveTheLargestAreRefused) {
  EXPECT_EQ(parsed("x\n1e-400\n-1e-400\n").numbers("x"), (Doubles{0.0, -0.0}));
  EXPECT_EQ(refusal("x\n1\n1e400\n"),
            "t.csv: row 2 of column \"x\" is infinite; values must be finite, and NaN where there "
            "is none");
}

TEST(Csv, MissingValuesAreNamedUnlessAllowed) {
  const std::string text = "a,b,c\n1,x,1.5\n,y,nan\n3,,2\n";
  EXPECT_EQ(refusal("a,b\n1,2\n3,\n"),
            "t.csv: row 2 of column \"b\" has no value; fill it in, drop the row or allow missing "
            "values");
  EXPECT_NE(refusal("a,b\n1,x\n3,\n").find("row 2 of column \"b\""), std::string::npos);
  EXPECT_NE(refusal("a\nNaN\n").find("row 1 of column \"a\""), std::string::npos);
  const Table table = parsed(text, Missing::allow);
  EXPECT_TRUE(std::isnan(table.numbers("a")[1]));
  EXPECT_TRUE(std::isnan(table.numbers("c")[1]));
  EXPECT_EQ(table.texts("b"), (Texts{"x", "y", ""}));
  EXPECT_THROW(parsed("a\ninf\n", Missing::allow), InputError);
}

TEST(Csv, EmptyCellAtTheVeryEndIsACell) {
  EXPECT_TRUE(std::isnan(parsed("a,b\n1,", Missing::allow).numbers("b")[0]));
}

TEST(Csv, HeaderAloneIsATableWithoutRows) {
  const Table table = parsed("a [m],b");
  EXPECT_EQ(table.rows(), 0u);
  EXPECT_EQ(table.column("a").unit, "m");
}

TEST(Csv, NamesTheLineThatIsWrong) {
  EXPECT_EQ(refusal("a,b\n1,2\n3\n"),
            "t.csv, line 3: there are 1 cells, but the first line names 2 columns");
  EXPECT_EQ(refusal("a,b\n\"x\ny\",2\n3,\"4\n"), "t.csv, line 4: a quoted cell is never closed");
  EXPECT_EQ(refusal("a\n\"x\"y\n"),
            "t.csv, line 2: text goes on after a closing quote; a quote inside a cell is written "
            "twice");
  EXPECT_EQ(refusal(""), "t.csv is empty; its first line must name the columns");
  EXPECT_EQ(refusal("a,b,a\n1,2,3\n"),
            "t.csv, column 3: the table has a column \"a\" already; names must differ");
  EXPECT_NE(refusal("a,,b\n1,2,3\n").find("column 2: a column of a table has no name"),
            std::string::npos);
  EXPECT_NE(refusal("a\n\xb0\xa1\n").find("not UTF-8"), std::string::npos);
}

TEST(Csv, AnyBytesAreReadOrRefusedButNeverCrash) {
  const std::string alphabet = ",\"\n\r 1.-ea[]\xc3\xbc";
  RandomStream random(2);
  int accepted = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (std::uint64_t n = random.below(24); n > 0; --n)
      text += alphabet[random.below(alphabet.size())];
    try {
      const Table table = parsed(text, Missing::allow);
      const Table again = parsed(csv_text(table), Missing::allow);
      EXPECT_EQ(again.rows(), table.rows()) << text;
      ++accepted;
    } catch (const InputError&) {
    }
  }
  EXPECT_GT(accepted, 100);
}

}  // namespace
}  // namespace repose::table

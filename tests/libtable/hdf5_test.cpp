// HDF5 tables: the same bits, roles, ranges and attributes come back; writes are whole or not at
// all.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "folder.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/table/io.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

class Hdf5Table : public FolderTest {};

Table one_column(Values values) {
  Table table;
  table.add({.name = "x", .values = std::move(values)});
  return table;
}

void expect_same(const Table& back, const Table& table) {
  ASSERT_EQ(back.names(), table.names());
  for (std::size_t j = 0; j < table.columns().size(); ++j) {
    const Column& a = back.columns()[j];
    const Column& b = table.columns()[j];
    EXPECT_TRUE(same_bits(a.values, b.values)) << b.name;
    EXPECT_EQ(a.unit, b.unit);
    EXPECT_EQ(a.role, b.role);
    EXPECT_EQ(a.range, b.range);
  }
}

TEST_F(Hdf5Table, KeepsEverythingItIsGiven) {
  Table table = every_kind_of_value();
  stamp_provenance(table, "repose design lhs", 42, {"factors.toml", "old.h5:/table"});
  table.attributes["scores"] = Doubles{0.1, 0.9};
  table.attributes["level"] = 0.1;
  table.attributes["none"] = Texts{};
  write_table({file("t.h5"), "/study/design"}, table);
  const Table back = read_table({file("t.h5"), "/study/design"});
  expect_same(back, table);
  EXPECT_EQ(back.attributes, table.attributes);
  EXPECT_EQ(files(), 1);
}

TEST_F(Hdf5Table, WithoutAGroupIsTheOnlyTable) {
  write_table({file("t.h5"), ""}, one_column(Doubles{1.5}));
  EXPECT_EQ(list_tables(file("t.h5")), Texts{"/table"});
  EXPECT_EQ(read_table({file("t.h5"), ""}).numbers("x"), Doubles{1.5});
}

TEST_F(Hdf5Table, SeveralShareAFileAndMustBeNamed) {
  const auto path = file("t.h5");
  write_tables(path, {{"/b", one_column(Integers{2})}, {"/a/deep", one_column(Integers{1})}},
               {{"repose_format", std::string("model 1")}, {"noise", 0.25}});
  EXPECT_EQ(list_tables(path), (Texts{"/a/deep", "/b"}));
  EXPECT_EQ(read_table({path, "/a/deep"}).integers("x"), Integers{1});
  EXPECT_EQ(std::get<double>(read_attributes({path, "/"}).at("noise")), 0.25);
  EXPECT_EQ(std::get<Texts>(read_attributes({path, "/b"}).at("column_order")), Texts{"x"});
  const std::string message = message_of<InputError>([&] { read_table({path, ""}); });
  EXPECT_NE(message.find("2 tables, /a/deep and /b"), std::string::npos) << message;
  EXPECT_NE(message_of<InputError>([&] {
              read_table({path, "/"});
            }).find("\"model 1\""),
            std::string::npos);
  EXPECT_NE(message_of<StorageError>([&] {
              read_table({path, "/c"});
            }).find("no such group"),
            std::string::npos);
  EXPECT_EQ(read_table({path, "/b/x"}).integers("x"), Integers{2});
}

TEST_F(Hdf5Table, MayLieInTheRootGroup) {
  write_table({file("t.h5"), "/"}, one_column(Doubles{1, 2}));
  EXPECT_EQ(read_table({file("t.h5"), ""}).rows(), 2u);
  EXPECT_THROW(write_tables(file("t.h5"), {{"/", one_column(Doubles{1})}}, {{"a", 1.0}}),
               InputError);
}

TEST_F(Hdf5Table, WithoutRowsOrColumnsComesBackSo) {
  write_tables(file("t.h5"), {{"/none", Table{}}, {"/rowless", one_column(Texts{})}});
  EXPECT_EQ(read_table({file("t.h5"), "/none"}).columns().size(), 0u);
  const Table rowless = read_table({file("t.h5"), "/rowless"});
  EXPECT_EQ(rowless.texts("x"), Texts{});
}

TEST_F(Hdf5Table, MissingValuesAreNamedUnlessAllowed) {
  write_table({file("t.h5"), ""}, one_column(Doubles{1, std::nan(""), 3}));
  EXPECT_NE(message_of<InputError>([&] {
              read_table({file("t.h5"), ""});
            }).find("row 2 of column \"x\" has no value"),
            std::string::npos);
  EXPECT_TRUE(std::isnan(read_table({file("t.h5"), ""}, Missing::allow).numbers("x")[1]));
}

TEST_F(Hdf5Table, FailedWriteLeavesTheOldFileAndNoTemporary) {
  const auto path = file("t.h5");
  write_table({path, ""}, one_column(Doubles{1}));
  const std::string before = read_file(path);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_THROW(write_table({path, ""}, one_column(Doubles{kInfinity})), InputError);
  EXPECT_THROW(write_table({path, ""}, one_column(Texts{std::string("a\0b", 3)})), InputError);
  EXPECT_THROW(write_table({path, "table"}, one_column(Doubles{1})), InputError);
  EXPECT_THROW(write_tables(path, {{"/t", one_column(Doubles{1})}, {"/t", one_column(Doubles{1})}}),
               InputError);
  Table slash;
  slash.add({.name = "m/s", .values = Doubles{1}});
  EXPECT_THROW(write_table({path, ""}, slash), InputError);
  Table reserved = one_column(Doubles{1});
  reserved.attributes["column_order"] = std::string("x");
  EXPECT_THROW(write_table({path, ""}, reserved), InputError);
  // A group where a dataset stands fails inside HDF5, when the temporary file exists.
  EXPECT_THROW(
      write_tables(path, {{"/t", one_column(Doubles{1})}, {"/t/x", one_column(Doubles{1})}}),
      StorageError);
  EXPECT_EQ(read_file(path), before);
  EXPECT_EQ(files(), 1);
}

TEST_F(Hdf5Table, CannotBeWrittenWhereThereIsNoDirectory) {
  const std::string message = message_of<StorageError>([&] {
    write_table({file("nowhere/t.h5"), ""}, one_column(Doubles{1}));
  });
  EXPECT_NE(message.find("there is no directory"), std::string::npos) << message;
  EXPECT_EQ(files(), 0);
}

TEST_F(Hdf5Table, CompressesWhatRepeatsAndKeepsItsBits) {
  Doubles levels(100000);
  for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = 0.1 * static_cast<double>(i % 3);
  write_table({file("levels.h5"), ""}, one_column(levels));
  EXPECT_LT(std::filesystem::file_size(file("levels.h5")), levels.size() * 8 / 10);
  EXPECT_TRUE(same_bits(read_table({file("levels.h5"), ""}).column("x").values, levels));

  RandomStream random(3);
  Doubles noise(100000);
  for (double& value : noise) value = random.uniform();
  write_table({file("noise.h5"), ""}, one_column(noise));
  EXPECT_TRUE(same_bits(read_table({file("noise.h5"), ""}).column("x").values, noise));
}

TEST_F(Hdf5Table, MayHaveMoreColumnsThanASmallAttributeCanName) {
  Table table;
  for (int j = 0; j < 5000; ++j)
    table.add({.name = "column_" + std::to_string(j), .values = Integers{j}});
  write_table({file("wide.h5"), ""}, table);
  EXPECT_EQ(read_table({file("wide.h5"), ""}).names(), table.names());
}

TEST_F(Hdf5Table, IsReadAndWrittenByManyThreads) {
  const auto path = [&](std::size_t i) { return file("t" + std::to_string(i) + ".h5"); };
  parallel_for(16, 4, [&](std::size_t i) {
    const auto value = static_cast<std::int64_t>(i);
    write_table({path(i), ""}, one_column(Integers{value}));
    EXPECT_EQ(read_table({path(i), ""}).integers("x"), Integers{value});
    EXPECT_THROW(read_table({file("absent.h5"), ""}), StorageError);
  });
}

TEST(Location, IsAFileAndMaybeAGroup) {
  EXPECT_EQ(parse_location("a.h5").file, "a.h5");
  EXPECT_EQ(parse_location("a.h5").group, "");
  EXPECT_EQ(parse_location("dir/a.h5:/b/c").file, "dir/a.h5");
  EXPECT_EQ(parse_location("dir/a.h5:/b/c").group, "/b/c");
  EXPECT_EQ(parse_location("12:30.csv").file, "12:30.csv");
  EXPECT_EQ(location_text(parse_location("a.h5:/b")), "a.h5:/b");
  for (const char* wrong : {"", ":/a", "a.csv:/table", "a.h5:/b/", "a.h5://b"})
    EXPECT_THROW(parse_location(wrong), InputError) << wrong;
}

}  // namespace
}  // namespace repose::table

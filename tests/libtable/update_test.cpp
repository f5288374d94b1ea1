// One writer at a time: the second is refused, and no update is lost.
#include "repose/table/update.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "folder.hpp"
#include "python.hpp"
#include "repose/base/file.hpp"

namespace repose::table {
namespace {

using Integers = std::vector<std::int64_t>;

class Update : public FolderTest {};

Table count(std::int64_t value) {
  Table table;
  table.add({.name = "n", .values = Integers{value}});
  return table;
}

void increment(Table& table) {
  const auto attributes = table.attributes;
  table = count(table.integers("n")[0] + 1);
  table.attributes = attributes;
}

/// Tries until no other writer is in the way.
void increment_times(const Location& location, int times) {
  while (times > 0) {
    try {
      update_table(location, increment);
      --times;
    } catch (const StorageError&) {
      std::this_thread::yield();
    }
  }
}

TEST_F(Update, KeepsTheOtherTablesAndAttributes) {
  Table other = every_kind_of_value();
  other.attributes["seed"] = std::int64_t{3};
  write_tables(file("t.h5"), {{"/a", count(1)}, {"/deep/b", other}}, {{"study", 0.5}});
  update_table({file("t.h5"), "/a"}, increment);
  EXPECT_EQ(read_table({file("t.h5"), "/a"}).integers("n"), Integers{2});
  const Table back = read_table({file("t.h5"), "/deep/b"});
  ASSERT_EQ(back.names(), other.names());
  for (const std::string& name : other.names())
    EXPECT_TRUE(same_bits(back.column(name).values, other.column(name).values));
  EXPECT_EQ(std::get<std::int64_t>(back.attributes.at("seed")), 3);
  EXPECT_EQ(std::get<double>(read_attributes({file("t.h5"), "/"}).at("study")), 0.5);
  EXPECT_EQ(files(), 1);
  EXPECT_THROW(update_table({file("t.h5"), ""}, increment), InputError);
  EXPECT_THROW(update_table({file("t.h5"), "/c"}, increment), InputError);
}

TEST_F(Update, WorksOnCsv) {
  write_csv(file("t.csv"), count(4));
  update_table({file("t.csv"), ""}, increment);
  EXPECT_EQ(read_csv(file("t.csv")).integers("n"), Integers{5});
  EXPECT_EQ(files(), 1);
}

TEST_F(Update, RefusesAFileOfWhichItWouldLoseSomething) {
  const auto data = std::filesystem::path(REPOSE_TEST_DATA) / "table" / "pytables.h5";
  std::filesystem::copy_file(data, file("t.h5"));
  const std::string before = read_file(file("t.h5"));
  EXPECT_NE(message_of<InputError>([&] {
              update_table({file("t.h5"), ""}, [](Table&) {});
            }).find("would be lost"),
            std::string::npos);
  write_tables(file("model.h5"), {{"/a", count(1)}}, {{"repose_format", std::string("model 1")}});
  EXPECT_THROW(update_table({file("model.h5"), ""}, increment), InputError);
  EXPECT_EQ(read_file(file("t.h5")), before);
}

TEST_F(Update, ThatFailsLeavesTheFileAndNoLock) {
  write_table({file("t.h5"), ""}, count(1));
  const std::string before = read_file(file("t.h5"));
  EXPECT_THROW(update_table({file("t.h5"), ""}, [](Table&) { throw InputError("no"); }),
               InputError);
  EXPECT_EQ(read_file(file("t.h5")), before);
  EXPECT_EQ(files(), 1);
}

TEST_F(Update, KeepsEveryOtherWriterOut) {
  write_table({file("t.h5"), ""}, count(1));
  update_table({file("t.h5"), ""}, [&](Table& table) {
    EXPECT_EQ(message_of<StorageError>([&] {
                write_table({file("t.h5"), ""}, count(7));
              }),
              "cannot write " + file("t.h5").string() +
                  ": another process or thread is writing it; try again when it is done");
    run_python(file(""), R"(
import fcntl, os
lock = open(os.path.dirname(path) + '/.t.h5.lock')
try:
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
except BlockingIOError:
    pass
else:
    raise SystemExit('another process could lock it')
)");
    EXPECT_EQ(read_table({file("t.h5"), ""}).integers("n"), Integers{1});  // readers are not
    increment(table);
  });
  EXPECT_EQ(read_table({file("t.h5"), ""}).integers("n"), Integers{2});
}

TEST_F(Update, OfManyThreadsAndProcessesIsNeverLost) {
  const Location location{file("t.h5"), ""};
  write_table(location, count(0));
  std::vector<pid_t> children;
  for (int i = 0; i < 3; ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      increment_times(location, 10);
      ::_exit(0);
    }
    children.push_back(child);
  }
  std::thread first([&] { increment_times(location, 10); });
  increment_times(location, 10);
  first.join();
  for (const pid_t child : children) {
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(read_table(location).integers("n"), Integers{50});
  EXPECT_EQ(files(), 1);
}

TEST_F(Update, GoesOnAfterAWriterThatDied) {
  write_table({file("t.h5"), ""}, count(1));
  write_file_atomically(file(".t.h5.lock"), "");  // left by a killed process; nobody holds it
  update_table({file("t.h5"), ""}, increment);
  EXPECT_EQ(read_table({file("t.h5"), ""}).integers("n"), Integers{2});
  EXPECT_EQ(files(), 1);
}

}  // namespace
}  // namespace repose::table

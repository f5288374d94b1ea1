// The store: what is recorded is there again, whatever happened to the index.
#include "repose/dem_adapter/run_store.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

RunOutcome outcome(int i) {
  RunOutcome o{.key = fmt::format("{:016x}", 1000 + i),
               .seed = static_cast<std::uint64_t>(i),
               .engine = "an engine",
               .measured_by = "a measure",
               .resources = {.wall_time_s = 0.5 * i, .cpu_time_s = 0.1, .peak_memory_bytes = 42}};
  o.measurement.kpis = {{"angle_deg", 30.0 + 0.1 * i}};
  if (i % 4 == 3) o.measurement.fail(Outcome::jammed_outlet, "jammed \"here\"\nand there \xff");
  return o;
}

void record(const RunStore& store, int i) {
  const auto o = outcome(i);
  std::filesystem::create_directories(store.folder(o.key));
  store.record(o);
}

void expect_found(const RunStore& store, int i) {
  const auto wanted = outcome(i);
  const auto found = store.find(wanted.key);
  ASSERT_TRUE(found) << i;
  EXPECT_EQ(found->key, wanted.key);
  EXPECT_EQ(found->seed, wanted.seed);
  EXPECT_EQ(found->measurement.outcome, wanted.measurement.outcome);
  EXPECT_EQ(found->measurement.kpis, wanted.measurement.kpis);
  EXPECT_EQ(found->measured_by, wanted.measured_by);
  EXPECT_EQ(found->resources.wall_time_s, wanted.resources.wall_time_s);
  EXPECT_EQ(found->resources.peak_memory_bytes, wanted.resources.peak_memory_bytes);
}

void expect_all(const std::filesystem::path& directory, int n) {
  for (const auto access : {StoreAccess::read, StoreAccess::write}) {
    const RunStore store(directory, access);
    EXPECT_EQ(store.size(), static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) expect_found(store, i);
  }
}

TEST(RunStore, FindsWhatWasRecordedByAnEarlierProcess) {
  const test::TemporaryDirectory directory;
  {
    const RunStore store(directory.path(), StoreAccess::write);
    for (int i = 0; i < 8; ++i) record(store, i);
    for (int i = 0; i < 8; ++i) expect_found(store, i);
    EXPECT_FALSE(store.find("00000000000000ff"));
  }
  expect_all(directory.path(), 8);
}

TEST(RunStore, NeedsNoIndex) {
  const test::TemporaryDirectory directory;
  {
    const RunStore store(directory.path(), StoreAccess::write);
    for (int i = 0; i < 8; ++i) record(store, i);
  }
  std::filesystem::remove(directory / "index.jsonl");
  expect_all(directory.path(), 8);
  EXPECT_TRUE(std::filesystem::exists(directory / "index.jsonl"));
}

TEST(RunStore, SurvivesAnIndexThatWasCutAtAnyByte) {
  const test::TemporaryDirectory directory;
  {
    const RunStore store(directory.path(), StoreAccess::write);
    for (int i = 0; i < 4; ++i) record(store, i);
  }
  const auto whole = read_file(directory / "index.jsonl");
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    std::ofstream(directory / "index.jsonl", std::ios::trunc) << whole.substr(0, length);
    expect_all(directory.path(), 4);
  }
}

TEST(RunStore, ReadsDamagedLinesFromTheirFolders) {
  const test::TemporaryDirectory directory;
  {
    const RunStore store(directory.path(), StoreAccess::write);
    for (int i = 0; i < 4; ++i) record(store, i);
  }
  auto text = read_file(directory / "index.jsonl");
  const auto second_line = text.find('\n') + 1;
  text.replace(second_line + 40, 5, "#####");
  text.replace(text.size() - 30, 3, "\0\0\0", 3);
  std::ofstream(directory / "index.jsonl", std::ios::trunc) << text;
  expect_all(directory.path(), 4);
}

TEST(RunStore, ForgetsARunAndTakesItsNewOutcome) {
  const test::TemporaryDirectory directory;
  const auto key = outcome(3).key;
  {
    const RunStore store(directory.path(), StoreAccess::write);
    for (int i = 0; i < 4; ++i) record(store, i);
    store.forget(key);
    EXPECT_FALSE(store.find(key));
    EXPECT_EQ(store.unfinished(), std::vector<std::string>{key});
  }
  {
    const RunStore store(directory.path(), StoreAccess::write);
    EXPECT_FALSE(store.find(key));
    record(store, 3);
  }
  expect_all(directory.path(), 4);
}

TEST(RunStore, ForgetsARunWhoseFolderIsGone) {
  const test::TemporaryDirectory directory;
  {
    const RunStore store(directory.path(), StoreAccess::write);
    for (int i = 0; i < 4; ++i) record(store, i);
    std::filesystem::remove_all(store.folder(outcome(3).key));
  }
  expect_all(directory.path(), 3);
}

TEST(RunStore, IsWrittenBySeveralProcessesAndThreadsAtOnce) {
  const test::TemporaryDirectory directory;
  const RunStore one(directory.path(), StoreAccess::write),
      two(directory.path(), StoreAccess::write);
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = t; i < 40; i += 4) record(t % 2 == 0 ? one : two, i);
    });
  for (auto& thread : threads) thread.join();
  for (int i = 0; i < 40; ++i) {
    expect_found(one, i);  // also what the other has recorded since
    expect_found(two, i);
  }
  expect_all(directory.path(), 40);
}

TEST(RunStore, LosesNothingWhenItsIndexIsCompactedUnderAWriter) {
  const test::TemporaryDirectory directory;
  const RunStore writer(directory.path(), StoreAccess::write);
  for (int i = 0; i < 6; ++i) record(writer, i);
  writer.forget(outcome(0).key);
  record(writer, 0);
  const auto before = std::filesystem::file_size(directory / "index.jsonl");
  RunStore(directory.path(), StoreAccess::write).compact_index();
  EXPECT_LT(std::filesystem::file_size(directory / "index.jsonl"), before);
  record(writer, 6);  // not into the file that is no longer the index
  expect_found(writer, 2);
  expect_all(directory.path(), 7);
}

TEST(RunStore, ForgetsForGoodWhenItsIndexWasCompactedMeanwhile) {
  const test::TemporaryDirectory directory;
  const RunStore writer(directory.path(), StoreAccess::write);
  for (int i = 0; i < 3; ++i) record(writer, i);
  RunStore(directory.path(), StoreAccess::write).compact_index();
  writer.forget(outcome(1).key);
  EXPECT_FALSE(RunStore(directory.path(), StoreAccess::read).find(outcome(1).key));
  record(writer, 1);
  expect_all(directory.path(), 3);
}

TEST(RunStore, SeesInTheFolderWhatAnotherProcessDidSince) {
  const test::TemporaryDirectory directory;
  const RunStore one(directory.path(), StoreAccess::write);
  record(one, 0);
  const RunStore two(directory.path(), StoreAccess::write);
  two.forget(outcome(0).key);
  EXPECT_FALSE(one.find_in_folder(outcome(0).key));
  EXPECT_FALSE(one.find(outcome(0).key));
  record(two, 0);
  EXPECT_TRUE(one.find_in_folder(outcome(0).key));
}

TEST(RunStore, IsOpenedWhereSomebodyCopiedAFolderUnderAnotherName) {
  const test::TemporaryDirectory directory;
  {
    const RunStore store(directory.path(), StoreAccess::write);
    record(store, 0);
  }
  const auto runs = directory / "runs";
  std::filesystem::copy(runs / outcome(0).key, runs / "backup",
                        std::filesystem::copy_options::recursive);
  const RunStore store(directory.path(), StoreAccess::write);
  EXPECT_EQ(store.keys(), std::vector<std::string>{outcome(0).key});
  expect_found(store, 0);
}

TEST(RunStore, NamesADamagedOutcome) {
  const test::TemporaryDirectory directory;
  const auto file = directory / "runs" / outcome(0).key / "outcome.json";
  {
    const RunStore store(directory.path(), StoreAccess::write);
    record(store, 0);
  }
  std::filesystem::remove(directory / "index.jsonl");
  std::ofstream(file) << "{\"run\":";
  try {
    const RunStore store(directory.path(), StoreAccess::read);
    static_cast<void>(store.find(outcome(0).key));
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("outcome.json' is damaged"), std::string::npos);
  }
}

TEST(RunStore, LeavesARunUnfinishedOnAFullDisk) {
  const test::TemporaryDirectory directory;
  const RunStore store(directory.path(), StoreAccess::write);
  for (int i = 0; i < 4; ++i) record(store, i);
  std::filesystem::create_directories(store.folder(outcome(4).key));
  const auto index = std::filesystem::file_size(directory / "index.jsonl");
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  rlimit unlimited{};
  ::getrlimit(RLIMIT_FSIZE, &unlimited);
  // Room for no byte, for outcome.json but not the index, and for half a line of the index.
  for (const rlim_t room :
       {rlim_t{1}, static_cast<rlim_t>(index), static_cast<rlim_t>(index + 9)}) {
    const rlimit small{.rlim_cur = room, .rlim_max = unlimited.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    EXPECT_THROW(store.record(outcome(4)), StorageError) << room;
    ::setrlimit(RLIMIT_FSIZE, &unlimited);
    EXPECT_EQ(std::filesystem::file_size(directory / "index.jsonl"), index);
  }
  std::signal(SIGXFSZ, previous);
  record(store, 4);
  expect_all(directory.path(), 5);
}

TEST(RunClaim, IsHeldByOneAtATime) {
  const test::TemporaryDirectory directory;
  const auto folder = directory / "run";
  const auto never = [] { return false; };
  EXPECT_FALSE(RunClaim::is_taken(folder));
  {
    const auto claim = RunClaim::take(folder, never);
    EXPECT_TRUE(RunClaim::is_taken(folder));
    EXPECT_FALSE(RunClaim::take(folder, [] { return true; }));
  }
  EXPECT_FALSE(RunClaim::is_taken(folder));
  EXPECT_TRUE(RunClaim::take(folder, never));
}

}  // namespace
}  // namespace repose::dem_adapter

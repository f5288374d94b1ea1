// The bundled engine as a child process: what becomes of success, failure, time limits and Ctrl-C.
#include "repose/dem_adapter/engine.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "repose/base/error.hpp"
#include "temporary_directory.hpp"

namespace repose::dem_adapter {
namespace {

/// An engine that is a shell script; $3 is the output folder.
std::filesystem::path script(const test::TemporaryDirectory& directory, const std::string& body) {
  const auto path = directory / "engine.sh";
  std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
  ::chmod(path.c_str(), 0755);
  return path;
}

TEST(BundledEngine, FinishesWhenItsProgramDoes) {
  const test::TemporaryDirectory directory;
  const BundledEngine engine(script(directory, "mkdir \"$3\"; echo done"));
  const auto exit = engine.run({.directory = directory.path()});
  EXPECT_EQ(exit.status, EngineStatus::finished);
  EXPECT_TRUE(std::filesystem::is_directory(directory / "output"));
}

TEST(BundledEngine, ReportsTheLastWordsOfAFailedRun) {
  const test::TemporaryDirectory directory;
  const BundledEngine engine(
      script(directory, "echo starting; echo 'particle 7 was lost' >&2; exit 5"));
  const auto exit = engine.run({.directory = directory.path()});
  EXPECT_EQ(exit.status, EngineStatus::failed);
  EXPECT_EQ(exit.message, "particle 7 was lost");
}

TEST(BundledEngine, StopsTheStudyWhereNoRunCouldSucceed) {
  const test::TemporaryDirectory directory;
  EXPECT_THROW(BundledEngine(script(directory, "exit 3")).run({.directory = directory.path()}),
               InputError);
  EXPECT_THROW(BundledEngine(script(directory, "exit 6")).run({.directory = directory.path()}),
               StorageError);
  EXPECT_THROW(BundledEngine("/nowhere/repose-dem"), StorageError);
}

TEST(BundledEngine, EndsARunAndItsChildrenAtTheTimeLimit) {
  const test::TemporaryDirectory directory;
  const BundledEngine engine(script(directory, "sleep 60 & echo $! > \"$3.pid\"; wait"));
  const auto exit = engine.run({.directory = directory.path(), .time_limit_s = 0.2});
  EXPECT_EQ(exit.status, EngineStatus::timed_out);
  EXPECT_LT(exit.wall_time_s, 30.0);
  pid_t child = 0;
  std::ifstream(directory / "output.pid") >> child;
  ASSERT_GT(child, 0);
  // Killed: gone, or a zombie until its new parent collects it.
  std::ifstream stat("/proc/" + std::to_string(child) + "/stat");
  std::string pid, name, state = "gone";
  stat >> pid >> name >> state;
  EXPECT_TRUE(state == "gone" || state == "Z") << state;
}

TEST(BundledEngine, GivesUpWhenItIsCancelled) {
  const test::TemporaryDirectory directory;
  const BundledEngine engine(script(directory, "sleep 60"));
  std::atomic<bool> cancelled{false};
  std::thread user([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    cancelled = true;
  });
  const auto exit =
      engine.run({.directory = directory.path(), .cancelled = [&] { return cancelled.load(); }});
  user.join();
  EXPECT_EQ(exit.status, EngineStatus::cancelled);
}

TEST(BundledEngine, RecordsACrashButNotBeingKilledByOthers) {
  const test::TemporaryDirectory directory;
  const auto crash =
      BundledEngine(script(directory, "kill -SEGV $$")).run({.directory = directory.path()});
  EXPECT_EQ(crash.status, EngineStatus::failed);
  EXPECT_EQ(crash.message, "the engine was killed by signal 11");
  for (const char* body : {"kill -9 $$", "kill -TERM $$", "exit 143"})
    EXPECT_THROW(BundledEngine(script(directory, body)).run({.directory = directory.path()}),
                 SimulationError)
        << body;
}

TEST(BundledEngine, KillsAnEngineThatIgnoresTheRequestToEnd) {
  const test::TemporaryDirectory directory;
  const auto path = script(directory, "trap '' TERM; mkdir \"$3\"; while :; do sleep 0.05; done");
  const BundledEngine engine(path, 0.2);
  const auto is_deaf = [&] { return std::filesystem::exists(directory / "output"); };
  const auto exit = engine.run({.directory = directory.path(), .cancelled = is_deaf});
  EXPECT_EQ(exit.status, EngineStatus::cancelled);
  EXPECT_GT(exit.wall_time_s, 0.2);  // it had its grace
  EXPECT_LT(exit.wall_time_s, 10.0);
  for (const double wrong : {-1.0, std::nan("")})
    EXPECT_THROW(BundledEngine(path, wrong), InputError);
}

TEST(BundledEngine, IsNamedByItsContent) {
  const test::TemporaryDirectory directory;
  const auto one = BundledEngine(script(directory, "exit 0")).name();
  EXPECT_EQ(BundledEngine(script(directory, "exit 0")).name(), one);
  EXPECT_NE(BundledEngine(script(directory, "exit 1")).name(), one);
}

}  // namespace
}  // namespace repose::dem_adapter

// The bundled engine as a child process: what becomes of success, failure, time limits and Ctrl-C.
#include "repose/dem_adapter/engine.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <thread>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
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
  EXPECT_LT(exit.resources.wall_time_s, 30.0);
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

TEST(BundledEngine, TellsACrashFromBeingKilledByOthers) {
  const test::TemporaryDirectory directory;
  const auto crash =
      BundledEngine(script(directory, "kill -SEGV $$")).run({.directory = directory.path()});
  EXPECT_EQ(crash.status, EngineStatus::failed);
  EXPECT_EQ(crash.failure, Outcome::crash);
  EXPECT_EQ(crash.message, "the engine crashed with signal 11");
  for (const char* body : {"kill -9 $$", "kill -TERM $$", "exit 143"})
    EXPECT_EQ(BundledEngine(script(directory, body)).run({.directory = directory.path()}).status,
              EngineStatus::killed)
        << body;
}

TEST(BundledEngine, TellsTheSignalsOfItsRanksByTheCodeOfTheirLauncher) {
  const test::TemporaryDirectory directory;
  const auto exit = [&](int signal) {
    const auto body = fmt::format("echo 'repose-dem: rank 1 of 2 died'; exit {}", 128 + signal);
    return BundledEngine(script(directory, body)).run({.directory = directory.path(), .ranks = 2});
  };
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) {
    EXPECT_EQ(exit(signal).status, EngineStatus::failed) << signal;
    EXPECT_EQ(exit(signal).failure, Outcome::crash) << signal;
    EXPECT_EQ(exit(signal).message, fmt::format("the engine crashed with signal {}", signal));
  }
  EXPECT_EQ(exit(SIGKILL).status, EngineStatus::killed);
  EXPECT_EQ(exit(SIGKILL).message, "it was killed by signal 9, not by us (out of memory?)");
}

TEST(BundledEngine, NamesWhatItsProgramFailedOf) {
  const test::TemporaryDirectory directory;
  const std::pair<const char*, Outcome> kSaid[] = {
      {"sphere 3 left the domain at (1, 0, 0), speed 2 m/s, time 0.1 s; close the gap in the walls",
       Outcome::particles_lost},
      {"sphere 3 has the position (nan, nan, nan) at time 0.1 s; lower the time step",
       Outcome::non_finite},
      {"overlap of 40 %; raise youngs_modulus_pa or lower the time step", Outcome::unphysical},
      {"rain: no room", Outcome::engine_failed}};
  for (const auto& [said, outcome] : kSaid) {
    const auto body = std::string("echo 'repose-dem: ") + said + "' >&2; exit 5";
    const auto exit = BundledEngine(script(directory, body)).run({.directory = directory.path()});
    EXPECT_EQ(exit.failure, outcome) << said;
  }
}

TEST(BundledEngine, CountsTheTimeOfItsProgramAndItsChildren) {
  const test::TemporaryDirectory directory;
  const auto exit =
      BundledEngine(script(directory, "sh -c 'i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done'"))
          .run({.directory = directory.path(), .ranks = 3});
  EXPECT_GT(exit.resources.cpu_time_s, 0.01);
  // One process that never waits cannot have more, up to the clock ticks of the system.
  EXPECT_LT(exit.resources.cpu_time_s, exit.resources.wall_time_s + 0.05);
  EXPECT_GT(exit.resources.peak_memory_bytes, 100000);
  EXPECT_EQ(exit.resources.ranks, 3);
}

TEST(BundledEngine, PassesRanksOn) {
  const test::TemporaryDirectory directory;
  const BundledEngine engine(script(directory, "echo \"$@\""));
  engine.run({.directory = directory.path(), .ranks = 4});
  engine.run({.directory = directory.path()});  // what it says is added to the log
  const auto log = read_file(directory / "engine.log");
  EXPECT_EQ(log, fmt::format("{0}/case.toml -o {0}/output --quiet --ranks 4\n"
                             "{0}/case.toml -o {0}/output --quiet\n",
                             directory.path().string()));
}

TEST(BundledEngine, KillsAnEngineThatIgnoresTheRequestToEnd) {
  const test::TemporaryDirectory directory;
  const auto path = script(directory, "trap '' TERM; mkdir \"$3\"; while :; do sleep 0.05; done");
  const BundledEngine engine(path, 0.2);
  const auto is_deaf = [&] { return std::filesystem::exists(directory / "output"); };
  const auto exit = engine.run({.directory = directory.path(), .cancelled = is_deaf});
  EXPECT_EQ(exit.status, EngineStatus::cancelled);
  EXPECT_GT(exit.resources.wall_time_s, 0.2);  // it had its grace
  EXPECT_LT(exit.resources.wall_time_s, 10.0);
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

// The program stopped by force: killed, on a full disk, by signals.
#include <csignal>

#include "repose/base/random.hpp"
#include "repose/dem/checkpoint.hpp"
#include "restart_cases.hpp"
#include "started_program.hpp"

namespace repose::dem {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

/// A second's work with a checkpoint as often as the program can.
scene::Case many_checkpoints(const fs::path& file) {
  scene::Case c = everything();
  c.output.checkpoint_wall_time_s = 1e-6;
  c.output.series_interval_s = 0.01;
  scene::write_case(file, c);
  return c;
}

TEST(Program, KilledAtAnyMomentGoesOnFromTheLastGoodCheckpoint) {
  const TestFolder folder;
  const fs::path input = folder.path / "case.toml";
  const fs::path killed = folder.path / "killed";
  many_checkpoints(input);
  ASSERT_EQ(end_of(start(input, folder.path / "straight")), 0);
  RandomStream random(1, 0);
  int code = -SIGKILL;
  int kills = 0;
  bool had_checkpoint = false;
  for (int wait_ms = 10; code != 0; wait_ms += 15) {
    const pid_t child = start(input, killed);
    std::this_thread::sleep_for(milliseconds(wait_ms + static_cast<int>(random.uniform() * 40)));
    ::kill(child, SIGKILL);
    code = end_of(child);
    ASSERT_TRUE(code == 0 || code == -SIGKILL) << code;
    const bool has_checkpoint = fs::exists(scene::checkpoint_file(killed));
    if (code != 0) {
      ++kills;
      EXPECT_TRUE(has_checkpoint || !had_checkpoint || fs::exists(killed / "run.h5"));
      if (has_checkpoint) {
        EXPECT_NO_THROW(read_checkpoint(scene::checkpoint_file(killed)));
      }
    }
    had_checkpoint = has_checkpoint;
  }
  EXPECT_GE(kills, 3);
  expect_same_output(folder.path / "straight", killed);
}

TEST(Program, OnAFullDiskFailsAndLosesNothing) {
  const TestFolder folder;
  const fs::path input = folder.path / "case.toml";
  const fs::path full = folder.path / "full";
  many_checkpoints(input);
  ASSERT_EQ(end_of(start(input, folder.path / "straight")), 0);
  const fs::path checkpoint = scene::checkpoint_file(full);
  const pid_t first = start(input, full);
  wait_for(checkpoint, first);
  ::kill(first, SIGTERM);
  ASSERT_EQ(end_of(first), 128 + SIGTERM);
  const std::string good = read_file(checkpoint);
  for (const double share : {0.1, 0.5, 0.9}) {
    const auto largest = static_cast<rlim_t>(share * static_cast<double>(good.size()));
    EXPECT_EQ(end_of(start(input, full, {.largest_file = largest})), 6) << share;
    EXPECT_EQ(read_file(checkpoint), good) << share;
  }
  ASSERT_EQ(end_of(start(input, full)), 0);
  expect_same_output(folder.path / "straight", full);
}

TEST(Program, DoesNotRunWhereAnotherOneRuns) {
  const TestFolder folder;
  scene::Case c = everything();
  c.stages[1].flow_ends.reset();
  c.stages[1].duration_s = 1e6;
  scene::write_case(folder.path / "case.toml", c);
  const fs::path run = folder.path / "run";
  const pid_t first = start(folder.path / "case.toml", run);
  wait_for(run / "log.txt", first);
  EXPECT_EQ(end_of(start(folder.path / "case.toml", run)), 6);
  EXPECT_TRUE(is_running(first));
  ::kill(first, SIGKILL);
  EXPECT_EQ(end_of(first), -SIGKILL);
  fs::remove(run / "log.txt");
  const pid_t second = start(folder.path / "case.toml", run);  // who was killed has let go
  wait_for(run / "log.txt", second);
  ::kill(second, SIGTERM);
  EXPECT_EQ(end_of(second), 128 + SIGTERM);
  EXPECT_FALSE(fs::exists(run / ".running"));
  EXPECT_TRUE(fs::exists(scene::checkpoint_file(run)));
}

TEST(Program, WritesACheckpointOnSigusr1AndGoesOn) {
  const TestFolder folder;
  scene::Case c = everything();
  scene::write_case(folder.path / "case.toml", c);
  const fs::path run = folder.path / "run";
  const pid_t child = start(folder.path / "case.toml", run);
  wait_for(run / "log.txt", child);  // its handlers are set
  ::kill(child, SIGUSR1);
  wait_for(scene::checkpoint_file(run), child);
  EXPECT_NO_THROW(read_checkpoint(scene::checkpoint_file(run)));
  EXPECT_EQ(end_of(child), 0);
  EXPECT_NE(read_file(run / "log.txt").find("as asked for"), std::string::npos);
  EXPECT_FALSE(fs::exists(scene::checkpoint_file(run)));
  EXPECT_TRUE(fs::exists(run / "run.h5"));
}

}  // namespace
}  // namespace repose::dem

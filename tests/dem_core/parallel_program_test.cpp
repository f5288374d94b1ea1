// Several processes simulate one case: the bits are those of one, and nothing hangs.
#include <fmt/format.h>

#include <csignal>
#include <fstream>

#include "repose/base/text.hpp"
#include "repose/dem/checkpoint.hpp"
#include "restart_cases.hpp"
#include "started_program.hpp"

namespace repose::dem {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> on(int ranks, const std::string& balance = "by-cost") {
  return {"--ranks", std::to_string(ranks), "--balance", balance};
}

/// How often the domain was cut.
int cuts_of(const fs::path& run) {
  const std::string log = read_file(run / "log.txt");
  const std::string before = "the domain was cut ";
  const std::size_t at = log.find(before);
  return at == std::string::npos ? 0 : std::stoi(log.substr(at + before.size()));
}

/// Runs a case on 1, 2, 3 and 4 ranks, cut once and as costs say, and compares all they leave.
/// Returns how often the domain was cut at most.
int expect_same_on_any_ranks(const scene::Case& c) {
  const TestFolder folder;
  scene::write_case(folder.path / "case.toml", c);
  EXPECT_EQ(end_of(start(folder.path / "case.toml", folder.path / "one")), 0);
  int most_cuts = 0;
  for (const int ranks : {2, 3, 4})
    for (const char* balance : {"by-cost", "never"}) {
      const fs::path run = folder.path / fmt::format("{}_{}", ranks, balance);
      EXPECT_EQ(end_of(start(folder.path / "case.toml", run, {.options = on(ranks, balance)})), 0);
      SCOPED_TRACE(run);
      // Cut at the start, when contacts are known and as the flow makes ranks unequal.
      const int cuts = cuts_of(run);
      if (std::string(balance) == "never")
        EXPECT_EQ(cuts, 1);
      else
        EXPECT_GE(cuts, 1);
      most_cuts = std::max(most_cuts, cuts);
      expect_same_output(folder.path / "one", run);
    }
  return most_cuts;
}

TEST(Ranks, OfAnyNumberGiveTheBitsOfOne) {
  EXPECT_GT(expect_same_on_any_ranks(everything()), 4);
}

TEST(Ranks, GiveTheBitsOfOneForSizesApartAndAPeriodInAllDirections) {
  scene::Case c = empty_case({.youngs_modulus = 5e6, .restitution = 0.5, .mu_s = 0.4, .mu_r = 0.1});
  c.lower_m = {0, 0, 0};
  c.upper_m = {0.09, 0.1, 0.11};
  c.periodic = {true, true, true};
  c.time_step_rayleigh_fraction = 0.25;
  c.fill = scene::Fill{{0, 0, 0},
                       {0.09, 0.1, 0.11},
                       0.3,
                       {layer_of("grain", 0.25, {{0.003, 0.005, 0.5}, {0.02, 0.025, 0.5}})}};
  scene::Grains clumps = c.fill->layers[0].mixture[0];
  clumps.clump = "sinter_3";
  clumps.mass_fraction = 0.4;
  c.fill->layers[0].mixture[0].mass_fraction = 0.6;
  clumps.sizes = std::vector<scene::SizeClass>{{0.008, 0.009, 1.0}};
  c.fill->layers[0].mixture.push_back(clumps);
  c.gravity_m_s2 = {2.0, -3.0, 4.0};  // all fall through the sides, at each other by their spread
  c.stages = {{.name = "mix", .duration_s = 0.1}};
  c.output.energy = true;
  expect_same_on_any_ranks(c);
}

TEST(Ranks, GiveTheBitsOfOneForSpheresThatTouchAtTheStart) {
  scene::Case c = empty_case({.youngs_modulus = 5e6, .restitution = 0.5, .mu_s = 0.4, .mu_r = 0.1});
  c.gravity_m_s2 = {0.3, 0.1, -9.81};
  c.walls = {rectangle("floor", {-0.2, -0.2, 0}, {0.4, 0, 0}, {0, 0.4, 0})};
  for (int z = 0; z < 4; ++z)
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 6; ++x)
        c.particles.push_back(
            grain(0.005, {-0.03 + 0.0099 * x + 0.001 * z, -0.02 + 0.0099 * y, 0.00499 + 0.0099 * z},
                  {0.1 * y, 0, 0}));
  c.stages = {{.name = "fall apart", .duration_s = 0.05}};
  c.output.energy = true;
  expect_same_on_any_ranks(c);
}

TEST(Ranks, OfAnotherNumberGoOnWithTheBitsOfAStraightRun) {
  const TestFolder folder;
  scene::Case c = everything();
  c.output.checkpoint_wall_time_s = 0.02;
  c.output.series_interval_s = 0.05;  // so that checkpoints are written in between
  scene::write_case(folder.path / "case.toml", c);
  ASSERT_EQ(end_of(start(folder.path / "case.toml", folder.path / "straight")), 0);
  const fs::path run = folder.path / "run";
  const fs::path checkpoint = scene::checkpoint_file(run);
  int code = 128 + SIGTERM;
  int stops = 0;
  for (const int ranks : {2, 3, 1, 4, 2}) {
    const pid_t child = start(folder.path / "case.toml", run, {.options = on(ranks)});
    const std::string before = fs::exists(checkpoint) ? read_file(checkpoint) : "";
    while (is_running(child) && (!fs::exists(checkpoint) || read_file(checkpoint) == before))
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ::kill(child, SIGTERM);
    code = end_of(child);
    if (code == 0) break;
    EXPECT_EQ(code, 128 + SIGTERM);
    ++stops;
  }
  EXPECT_GE(stops, 3);
  if (code != 0) {
    EXPECT_EQ(end_of(start(folder.path / "case.toml", run, {.options = on(3)})), 0);
  }
  expect_same_output(folder.path / "straight", run);
}

/// Processes of repose-dem whose parent is the launcher of `child`.
std::vector<pid_t> ranks_of(pid_t child) {
  const auto children_of = [](pid_t parent) {
    std::vector<pid_t> children;
    std::ifstream list(fmt::format("/proc/{0}/task/{0}/children", parent));
    for (pid_t one = 0; list >> one;) children.push_back(one);
    return children;
  };
  std::vector<pid_t> ranks;
  for (const pid_t launcher : children_of(child))
    for (const pid_t rank : children_of(launcher)) ranks.push_back(rank);
  return ranks;
}

TEST(Ranks, OneThatDiesEndsTheRunWithAMessageAndTheSameCommandGoesOn) {
  const TestFolder folder;
  scene::Case c = everything();
  c.output.checkpoint_wall_time_s = 0.02;
  scene::write_case(folder.path / "case.toml", c);
  ASSERT_EQ(end_of(start(folder.path / "case.toml", folder.path / "straight")), 0);
  for (const int signal : {SIGKILL, SIGSEGV}) {
    const fs::path run = folder.path / fmt::format("run_{}", signal);
    const fs::path said = folder.path / fmt::format("messages_{}.txt", signal);
    const pid_t child = start(folder.path / "case.toml", run, {.messages = said, .options = on(3)});
    wait_for(scene::checkpoint_file(run), child);
    const std::vector<pid_t> ranks = ranks_of(child);
    ASSERT_EQ(ranks.size(), 3u);
    ::kill(ranks[1], signal);
    EXPECT_EQ(end_of(child), 128 + signal);  // as a shell says of one process
    const std::string messages = read_file(said);
    EXPECT_NE(messages.find(fmt::format("rank 1 of 3 died by signal {}", signal)),
              std::string::npos)
        << messages;
    EXPECT_EQ(end_of(start(folder.path / "case.toml", run, {.options = on(2)})), 0);
    expect_same_output(folder.path / "straight", run);
  }
}

/// The exit code and what was said on two ranks.
std::pair<int, std::string> failure_of(const scene::Case& c) {
  const TestFolder folder;
  scene::write_case(folder.path / "case.toml", c);
  const fs::path messages = folder.path / "messages.txt";
  const int code = end_of(start(folder.path / "case.toml", folder.path / "run",
                                {.messages = messages, .options = on(2)}));
  return {code, read_file(messages)};
}

std::size_t count_of(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
    ++count;
  return count;
}

/// Libraries may complain of the machine in lines of their own.
void expect_one_message(const std::string& messages) {
  EXPECT_EQ(count_of("repose-dem", messages), 1u) << messages;
  EXPECT_EQ(count_of("mpirun", messages), 0u) << messages;
  EXPECT_EQ(count_of("-----", messages), 0u) << messages;
}

TEST(Ranks, SayOnceWhatWentWrongOnOneOfThem) {
  scene::Case c = empty_case({.youngs_modulus = 5e6});
  for (int k = 0; k < 8; ++k)
    c.particles.push_back(grain(0.01, {-0.9 + 0.25 * k, 0, 0}, {0, 0, k == 6 ? 4.0 : 0.0}));
  c.stages = {{.name = "fly", .duration_s = 10}};
  const auto [code, messages] = failure_of(c);
  EXPECT_EQ(code, 5);
  EXPECT_EQ(count_of("sphere 6 left the domain", messages), 1u) << messages;
  expect_one_message(messages);
}

TEST(Ranks, SayOnceThatACaseIsWrong) {
  scene::Case c = empty_case({.youngs_modulus = 5e6});
  c.particles = {grain(0.01, {0, 0, 0}), grain(0.01, {0.005, 0, 0})};
  c.stages = {{.name = "fly", .duration_s = 1}};
  const auto [code, messages] = failure_of(c);
  EXPECT_EQ(code, 3);
  EXPECT_EQ(count_of("overlaps", messages), 1u) << messages;
  expect_one_message(messages);
}

TEST(Ranks, FollowCtrlCAndWriteACheckpointWhenAsked) {
  const TestFolder folder;
  scene::write_case(folder.path / "case.toml", everything());
  const fs::path run = folder.path / "run";
  pid_t child = start(folder.path / "case.toml", run, {.options = on(2)});
  wait_for(run / "log.txt", child);
  ::kill(child, SIGUSR1);
  wait_for(scene::checkpoint_file(run), child);
  EXPECT_TRUE(is_running(child));
  ::kill(child, SIGINT);
  EXPECT_EQ(end_of(child), 128 + SIGINT);
  const std::string log = read_file(run / "log.txt");
  EXPECT_EQ(count_of("as asked for", log), 1u) << log;
  EXPECT_EQ(count_of("interrupted at", log), 1u) << log;
  child = start(folder.path / "case.toml", run, {.options = on(2)});
  EXPECT_EQ(end_of(child), 0);
}

TEST(Ranks, TakeWhatWasFinishedButNotMoved) {
  const TestFolder folder;
  scene::write_case(folder.path / "case.toml", above_nothing());
  const fs::path file = folder.path / "out.h5";
  ASSERT_EQ(end_of(start(folder.path / "case.toml", folder.path / "out.h5.parts")), 0);
  EXPECT_EQ(end_of(start(folder.path / "case.toml", file, {.options = on(2)})), 0);
  EXPECT_TRUE(fs::exists(file));
  EXPECT_FALSE(fs::exists(folder.path / "out.h5.parts"));
}

TEST(Ranks, FailTogetherWhereRootCannotWrite) {
  const TestFolder folder;
  scene::write_case(folder.path / "case.toml", above_nothing());
  const fs::path messages = folder.path / "messages.txt";
  std::ofstream(folder.path / "file") << "no folder";
  EXPECT_EQ(end_of(start(folder.path / "case.toml", folder.path / "file" / "run",
                         {.messages = messages, .options = on(2)})),
            6);
  expect_one_message(read_file(messages));
}

TEST(Ranks, MoreThanBodiesStillSimulate) {
  const TestFolder folder;
  scene::write_case(folder.path / "case.toml", above_nothing());
  ASSERT_EQ(end_of(start(folder.path / "case.toml", folder.path / "one")), 0);
  ASSERT_EQ(end_of(start(folder.path / "case.toml", folder.path / "four", {.options = on(4)})), 0);
  expect_same_output(folder.path / "one", folder.path / "four");
}

}  // namespace
}  // namespace repose::dem

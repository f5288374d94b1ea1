// The executor of SLURM beside a stand-in for its programs: what SLURM may do wrong, and what then
// becomes of runs.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <future>
#include <thread>

#include "../dem_adapter/temporary_directory.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/toml.hpp"
#include "repose/dem_adapter/compute_plan.hpp"
#include "repose/dem_adapter/slurm.hpp"
#include "repose/dem_adapter/submission.hpp"
#include "stand_in.hpp"

namespace repose::dem_adapter {
namespace {

namespace fs = std::filesystem;

class SlurmExecutorTest : public ::testing::Test {
 protected:
  SlurmOptions options() const {
    return {.program = REPOSE_BIN "/repose",
            .gather_s = 0.3,
            .ask_every_s = 0.3,
            .file_patience_s = 0.6,
            .silence_s = 0.2};
  }
  SlurmExecutor executor(const SlurmOptions& o) const { return {o, folder_ / "slurm"}; }
  SlurmExecutor executor() const { return executor(options()); }

  /// A run of shell text; it appends a line to RUN/done.
  Command command(const std::string& run, const std::string& text = "") const {
    fs::create_directories(folder_ / run);
    return {.words = {"/bin/sh", "-c", "echo done >> done; " + text},
            .folder = folder_ / run,
            .log = folder_ / run / "log",
            .home = folder_ / run};
  }
  int times_done(const std::string& run) const {
    int n = 0;
    std::ifstream in(folder_ / run / "done");
    for (std::string line; std::getline(in, line);) ++n;
    return n;
  }
  /// For what must come; the test's time limit ends it otherwise.
  template <class Condition>
  static void wait_for(const Condition& condition) {
    while (!condition()) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }

  test::TemporaryDirectory folder_;
  test::StandIn slurm_{folder_ / "bin"};
};

TEST_F(SlurmExecutorTest, SubmitsRunsWantedTogetherAsOneArray) {
  const auto slurm = executor();
  std::vector<std::future<CommandEnd>> ends;
  for (int i = 0; i < 6; ++i)
    ends.push_back(std::async(std::launch::async, [&, i] {
      return slurm.run(command(std::to_string(i), fmt::format("echo I am {0}; exit {0}", i)));
    }));
  for (int i = 0; i < 6; ++i) {
    const auto end = ends[static_cast<std::size_t>(i)].get();
    EXPECT_EQ(end.ended, CommandEnded::by_itself);
    EXPECT_EQ(end.exit_code, i);
    EXPECT_EQ(end.signal, 0);
    EXPECT_GT(end.resources.wall_time_s, 0.0);
    EXPECT_GT(end.resources.peak_memory_bytes, 0);
    EXPECT_EQ(read_file(folder_ / std::to_string(i) / "log"), fmt::format("I am {}\n", i));
  }
  EXPECT_EQ(slurm_.calls("sbatch"), 1);
  EXPECT_NE(slurm_.last_call("sbatch").find("--array=0-5"), std::string::npos);
  EXPECT_LT(slurm_.calls("squeue"), 30);  // for all runs in one call
}

TEST_F(SlurmExecutorTest, AsksForWhatARunNeeds) {
  auto o = options();
  o.partition = "long";
  o.account = "sand";
  o.memory_per_run_gb = 1.5;
  o.extra_options = {"--constraint=avx2"};
  auto run = command("a");
  run.processes = 4;
  run.time_limit_s = 3600;
  executor(o).run(run);
  const auto call = slurm_.last_call("sbatch");
  for (const char* option : {"--ntasks=4", "--nodes=1", "--time=62", "--mem=1500M",
                             "--partition=long", "--account=sand", "--constraint=avx2"})
    EXPECT_NE(call.find(option), std::string::npos) << option << " in " << call;
}

TEST_F(SlurmExecutorTest, LeavesNothingBehindOnceTheEndIsStored) {
  executor().run(command("a"));
  ASSERT_TRUE(submission_of(folder_ / "a"));  // it could be taken again after a crash
  EXPECT_EQ(executor().run(command("a")).exit_code, 0);
  EXPECT_EQ(times_done("a"), 1);
  forget_submission(folder_ / "a");
  EXPECT_FALSE(submission_of(folder_ / "a"));
  EXPECT_TRUE(fs::is_empty(folder_ / "slurm"));
}

TEST_F(SlurmExecutorTest, SaysWhySbatchRefuses) {
  slurm_.set("refuse", "invalid partition specified: long");
  try {
    executor().run(command("a"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("invalid partition specified: long"),
              std::string::npos)
        << error.what();
    EXPECT_NE(std::string(error.what()).find("[slurm] partition"), std::string::npos);
  }
  EXPECT_FALSE(submission_of(folder_ / "a"));
}

TEST_F(SlurmExecutorTest, WaitsWhereTheQueueIsFull) {
  slurm_.set("limit", "2");
  const auto slurm = executor();
  std::vector<std::future<CommandEnd>> ends;
  for (int i = 0; i < 5; ++i)
    ends.push_back(
        std::async(std::launch::async, [&, i] { return slurm.run(command(std::to_string(i))); }));
  for (auto& end : ends) EXPECT_EQ(end.get().exit_code, 0);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(times_done(std::to_string(i)), 1);
}

TEST_F(SlurmExecutorTest, HasNoMoreJobsInTheQueueThanItMay) {
  auto o = options();
  o.max_jobs = 2;
  const auto slurm = executor(o);
  std::vector<std::future<CommandEnd>> ends;
  for (int i = 0; i < 5; ++i)
    ends.push_back(
        std::async(std::launch::async, [&, i] { return slurm.run(command(std::to_string(i))); }));
  std::size_t most = 0;
  for (auto& end : ends)
    while (end.wait_for(std::chrono::milliseconds(5)) != std::future_status::ready)
      most = std::max(most, slurm_.jobs());
  EXPECT_LE(most, 2U);
}

TEST_F(SlurmExecutorTest, HasPatienceWithASilentController) {
  slurm_.set("down");
  auto o = options();
  std::promise<std::string> warning;
  o.warn = [&](std::string sentence) { warning.set_value(std::move(sentence)); };  // twice throws
  const auto slurm = executor(o);
  auto end = std::async(std::launch::async, [&] { return slurm.run(command("a")); });
  EXPECT_NE(warning.get_future().get().find("Unable to contact slurm controller"),
            std::string::npos);
  slurm_.unset("down");
  EXPECT_EQ(end.get().exit_code, 0);
  EXPECT_EQ(times_done("a"), 1);
}

TEST_F(SlurmExecutorTest, FindsAJobWhoseNumberItWasNotTold) {
  slurm_.set("hold");
  slurm_.set("hide");
  const auto slurm = executor();
  auto end = std::async(std::launch::async, [&] { return slurm.run(command("a")); });
  wait_for([&] { return slurm_.calls("squeue") > 0; });
  slurm_.unset("hold");
  EXPECT_EQ(end.get().exit_code, 0);
  EXPECT_EQ(slurm_.calls("sbatch"), 1);
  EXPECT_EQ(times_done("a"), 1);
}

TEST_F(SlurmExecutorTest, SubmitsAgainWhatNeverReachedTheQueue) {
  slurm_.set("forget");
  EXPECT_EQ(executor().run(command("a")).exit_code, 0);
  EXPECT_EQ(slurm_.calls("sbatch"), 2);
  EXPECT_EQ(times_done("a"), 1);
}

TEST_F(SlurmExecutorTest, TakesATaskThatVanishedForKilled) {
  slurm_.set("lose");
  const auto end = executor().run(command("a"));
  EXPECT_EQ(end.ended, CommandEnded::by_itself);
  EXPECT_EQ(end.signal, SIGKILL);
  EXPECT_NE(read_file(folder_ / "a/log").find("ended without a word"), std::string::npos);
}

TEST_F(SlurmExecutorTest, SaysWhyAJobDidNotReachItsRun) {
  auto o = options();
  o.setup = "echo 'module: command not found' >&2; exit 1";
  try {
    executor(o).run(command("a"));
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("module: command not found"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(times_done("a"), 0);
}

TEST_F(SlurmExecutorTest, RunsWhereItsCallerIsIfNothingElseIsSaid) {
  auto run = command("a", "pwd");
  run.folder.clear();
  EXPECT_EQ(executor().run(run).exit_code, 0);
  EXPECT_EQ(read_file(folder_ / "a/log"), fs::current_path().string() + "\n");
  fs::remove("done");
}

TEST_F(SlurmExecutorTest, RefusesARunThatCouldNotBeFoundAgain) {
  auto run = command("a");
  run.home.clear();
  EXPECT_THROW(executor().run(run), InputError);
}

TEST_F(SlurmExecutorTest, SaysThatAProgramCannotBeStartedThere) {
  auto run = command("a");
  run.log = folder_ / "nowhere" / "log";
  EXPECT_THROW(executor().run(run), Error);
  run = command("b");
  run.words = {"/nowhere/repose-dem"};
  EXPECT_EQ(executor().run(run).exit_code, 127);  // as here
}

TEST_F(SlurmExecutorTest, DoesNotRunAnotherBuildThanWasWanted) {
  slurm_.set("hold");
  auto run = command("a");
  run.words = {(folder_ / "engine").string()};
  const auto build = [&](const std::string& text) {
    std::ofstream(folder_ / "engine") << "#!/bin/sh\necho done >> done\n# " << text << '\n';
    fs::permissions(folder_ / "engine", fs::perms::owner_all);
  };
  build("one");
  const auto slurm = executor();
  auto end = std::async(std::launch::async, [&] { return slurm.run(run); });
  wait_for([&] { return slurm_.jobs() == 1; });
  build("two");
  slurm_.unset("hold");
  try {
    end.get();
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::storage);
    EXPECT_NE(std::string(error.what()).find("was replaced"), std::string::npos) << error.what();
  }
  EXPECT_EQ(times_done("a"), 0);
  EXPECT_FALSE(submission_of(folder_ / "a"));
}

TEST_F(SlurmExecutorTest, WarnsOfWhatKeepsAJobPendingForEver) {
  slurm_.set("hold");
  slurm_.set("reason", "PartitionTimeLimit");
  auto o = options();
  std::promise<std::string> warning;
  o.warn = [&](std::string sentence) { warning.set_value(std::move(sentence)); };
  const auto slurm = executor(o);
  auto end = std::async(std::launch::async, [&] { return slurm.run(command("a")); });
  EXPECT_NE(warning.get_future().get().find("PartitionTimeLimit"), std::string::npos);
  slurm_.unset("hold");
  EXPECT_EQ(end.get().exit_code, 0);
}

TEST_F(SlurmExecutorTest, PassesACancellationOnToTheProgram) {
  const auto slurm = executor();
  auto run = command("a",
                     "trap 'echo checkpoint; exit 143' TERM; echo up; "
                     "while :; do sleep 0.02; done");
  run.cancelled = [&] {
    return fs::exists(folder_ / "a/log") && read_file(folder_ / "a/log").find("up") == 0;
  };
  auto pending = command("b");
  slurm_.set("hold");
  std::atomic<bool> give_up{false};
  pending.cancelled = [&] { return give_up.load(); };
  auto never_begun = std::async(std::launch::async, [&] { return slurm.run(pending); });
  wait_for([&] { return slurm_.jobs() == 1; });
  give_up = true;
  EXPECT_EQ(never_begun.get().ended, CommandEnded::when_cancelled);
  EXPECT_EQ(times_done("b"), 0);
  slurm_.unset("hold");
  EXPECT_EQ(slurm.run(run).ended, CommandEnded::when_cancelled);
  EXPECT_NE(read_file(folder_ / "a/log").find("checkpoint"), std::string::npos);
}

TEST_F(SlurmExecutorTest, TakesACancellationByOthersForKilled) {
  const auto slurm = executor();
  auto end =
      std::async(std::launch::async, [&] { return slurm.run(command("a", "exec sleep 60")); });
  wait_for([&] { return times_done("a") == 1; });
  const auto job = read_file(submission_of(folder_ / "a")->array / "job");
  const auto call = fmt::format("{} {}_0", (slurm_ / "scancel").string(), job.substr(0, 3));
  ASSERT_EQ(std::system(call.c_str()), 0);
  EXPECT_EQ(end.get().ended, CommandEnded::by_itself);
}

TEST_F(SlurmExecutorTest, EndsAProgramAtItsTimeLimitOnTheNode) {
  auto run = command("a", "exec sleep 60");
  run.time_limit_s = 0.3;
  const auto end = executor().run(run);
  EXPECT_EQ(end.ended, CommandEnded::at_time_limit);
  EXPECT_GE(end.resources.wall_time_s, 0.3);
  // An end at an earlier limit is none for who gives it more time.
  run = command("a", "exit 4");
  run.time_limit_s = 50.0;
  EXPECT_EQ(executor().run(run).exit_code, 4);
}

TEST_F(SlurmExecutorTest, WaitsForTheJobOfACampaignThatWasKilled) {
  slurm_.set("hold");
  for (const char* moment : {"pending", "over"}) {
    const pid_t child = ::fork();
    if (child == 0) {
      executor().run(command(moment, "exit 3"));
      ::_exit(0);
    }
    wait_for([&] {
      const auto place = submission_of(folder_ / moment);
      return place && fs::exists(place->array / "job");
    });
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
  const auto pending = submission_of(folder_ / "pending");
  auto end =
      std::async(std::launch::async, [&] { return executor().run(command("pending", "exit 3")); });
  slurm_.unset("hold");
  EXPECT_EQ(end.get().exit_code, 3);
  wait_for([&] { return slurm_.jobs() == 0; });  // the other ended while nobody waited
  EXPECT_EQ(executor().run(command("over", "exit 3")).exit_code, 3);
  EXPECT_EQ(slurm_.calls("sbatch"), 2);
  EXPECT_EQ(submission_of(folder_ / "pending"), pending);
  for (const char* run : {"pending", "over"}) EXPECT_EQ(times_done(run), 1);
}

TEST_F(SlurmExecutorTest, GivesARunToOneTaskOnly) {
  slurm_.set("hold");
  slurm_.set("hide");
  const auto slurm = executor();
  auto end = std::async(std::launch::async, [&] { return slurm.run(command("a")); });
  wait_for([&] { return slurm_.jobs() == 1; });
  const auto first = *submission_of(folder_ / "a");
  // The controller forgets the job; another one is submitted, then the first comes after all.
  const auto job = *fs::directory_iterator(slurm_ / "jobs");
  fs::rename(job.path(), slurm_ / "hidden");
  wait_for([&] { return !fs::exists(first.array); });
  EXPECT_NE(submission_of(folder_ / "a"), first);
  EXPECT_THROW(run_slurm_task(first.array, first.task, {}), InputError);
  fs::create_directory(first.array);  // as long as a file system still shows it
  std::ofstream(first.array / "0.task") << (folder_ / "a").string();
  run_slurm_task(first.array, first.task, {});
  EXPECT_EQ(times_done("a"), 0);
  slurm_.unset("hold");
  EXPECT_EQ(end.get().exit_code, 0);
  EXPECT_EQ(times_done("a"), 1);
}

TEST_F(SlurmExecutorTest, KeepsThisMachineFromARunInTheQueue) {
  slurm_.set("hold");
  const auto slurm = executor();
  auto end = std::async(std::launch::async, [&] { return slurm.run(command("a")); });
  wait_for([&] { return slurm_.jobs() == 1; });
  EXPECT_THROW(LocalExecutor().run(command("a")), StorageError);
  const auto state = queue_state({folder_ / "a"});
  EXPECT_EQ(state.pending, std::vector<fs::path>{folder_ / "a"});
  EXPECT_EQ(state.reasons, std::vector<std::string>{"Resources"});
  slurm_.set("down");
  EXPECT_NE(queue_state({folder_ / "a"}).silence, "");
  slurm_.unset("down");
  slurm_.unset("hold");
  EXPECT_EQ(end.get().exit_code, 0);
}

ComputePlan plan_of(const std::string& text) {
  return read_compute_plan(TomlTable::parse(text, "study.toml"), "");
}

TEST(SlurmOptions, AreReadFromAStudy) {
  const auto plan = plan_of(
      "[compute]\nexecutor = \"slurm\"\nranks = 4\n[slurm]\npartition = \"short\"\n"
      "max_jobs = 30\nextra_options = [\"--qos=low\"]\nsetup = \"module load openmpi\"\n");
  ASSERT_TRUE(plan.slurm);
  EXPECT_EQ(plan.slurm->partition, "short");
  EXPECT_EQ(plan.slurm->setup, "module load openmpi");
  EXPECT_EQ(plan.slurm->extra_options, std::vector<std::string>{"--qos=low"});
  EXPECT_EQ(runs_at_once(plan), 30U);  // whatever cores this machine has
  EXPECT_FALSE(plan_of("[compute]\nexecutor = \"local\"\n[slurm]\nmax_jobs = 3\n").slurm);
  for (const char* wrong :
       {"[slurm]\nmax_jobs = 3\n", "[compute]\nexecutor = \"pbs\"\n",
        "[compute]\nexecutor = \"slurm\"\ncores = 4\n",
        "[compute]\nexecutor = \"slurm\"\n[slurm]\nmax_jobs = 0\n",
        "[compute]\nexecutor = \"slurm\"\n[slurm]\nextra_options = [\"qos=low\"]\n"})
    EXPECT_THROW(plan_of(wrong), InputError) << wrong;
}

TEST(SlurmExecutor, NamesThePackageOfWhatIsMissing) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  try {
    SlurmExecutor({}, "slurm");
    ADD_FAILURE();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("slurm-client"), std::string::npos) << error.what();
  }
  ::setenv("PATH", path.c_str(), 1);
}

}  // namespace
}  // namespace repose::dem_adapter

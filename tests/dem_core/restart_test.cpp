// Checkpoints: what is in them, and that going on from one gives the bits of a straight run.
#include <fstream>

#include "restart_cases.hpp"

#include "checkpoint/build_name.hpp"
#include "repose/base/error.hpp"
#include "repose/dem/run_case.hpp"

namespace repose::dem {
namespace {

namespace fs = std::filesystem;

/// From one file and back, as a restart does it.
Simulation restarted(Simulation& sim, const scene::Case& c, const fs::path& file) {
  write_checkpoint(file, sim.checkpoint());
  return {c, read_checkpoint(file)};
}

/// To the last step of `last`, with stage "flow" from step 1000 on.
void go_to(Simulation& sim, std::int64_t last) {
  while (sim.steps() < last) {
    if (sim.steps() == 0) sim.begin_stage("fill");
    if (sim.steps() == 1000) sim.begin_stage("flow");
    sim.step();
  }
}

TEST(Restart, GivesTheBitsOfAStraightRunFromAnyStep) {
  const TestFolder folder;
  const scene::Case c = everything();
  constexpr std::int64_t kLast = 3000;
  Simulation straight(c);
  go_to(straight, kLast);
  const scene::Ledger ledger = straight.ledger();
  EXPECT_GT(ledger.removed, 3);  // the case shows what it is meant to
  EXPECT_GT(straight.size(), straight.bodies().size());
  EXPECT_GT(straight.rebuilds(), 20);
  EXPECT_GT(straight.energy().released_j, 0.0);
  // Before the first step, beside and between new orders of the spheres, before and after the stage
  // begins and before and after rain.
  for (const std::int64_t step : {0, 1, 37, 50, 999, 1000, 1001, 1163, 1450, 1578, 1913, 2777}) {
    Simulation first(c);
    go_to(first, step);
    Simulation second = restarted(first, c, folder.path / "checkpoint.h5");
    EXPECT_EQ(second.state_hash(), first.state_hash()) << step;
    go_to(first, kLast);  // who wrote the checkpoint goes on undisturbed
    go_to(second, kLast);
    for (Simulation* sim : {&first, &second}) {
      EXPECT_EQ(sim->state_hash(), straight.state_hash()) << step;
      EXPECT_TRUE(sim->ledger() == ledger) << step;
      EXPECT_EQ(sim->energy().error_j, straight.energy().error_j) << step;
      EXPECT_EQ(sim->outstanding_rain_kg(), straight.outstanding_rain_kg()) << step;
    }
  }
}

TEST(Restart, OfARestartGivesTheSameCheckpoint) {
  const TestFolder folder;
  const scene::Case c = everything();
  Simulation first(c);
  go_to(first, 2613);
  Simulation second = restarted(first, c, folder.path / "a.h5");
  restarted(second, c, folder.path / "b.h5");
  for (const std::string& group : table::list_tables(folder.path / "a.h5"))
    EXPECT_EQ(all_of(folder.path / "a.h5", group), all_of(folder.path / "b.h5", group)) << group;
  EXPECT_TRUE(table::read_attributes({folder.path / "a.h5", "/"}) ==
              table::read_attributes({folder.path / "b.h5", "/"}));
}

TEST(Restart, LeavesTheLedgersAndLoadsAsTheyWere) {
  const TestFolder folder;
  const scene::Case c = everything();
  Simulation first(c);
  go_to(first, 2613);
  Simulation second = restarted(first, c, folder.path / "checkpoint.h5");
  EXPECT_EQ(first.contacts(), second.contacts());
  EXPECT_EQ(first.energy().elastic_normal_j, second.energy().elastic_normal_j);
  EXPECT_EQ(first.take_largest_overlap().ratio(), second.take_largest_overlap().ratio());
  const auto a = first.take_wall_loads();
  const auto b = second.take_wall_loads();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t w = 0; w < a.size(); ++w) {
    EXPECT_EQ(a[w].force_n, b[w].force_n);
    EXPECT_EQ(a[w].torque_n_m, b[w].torque_n_m);
    EXPECT_EQ(a[w].work_j, b[w].work_j);
  }
  EXPECT_TRUE(first.wall_poses() == second.wall_poses());
  EXPECT_EQ(first.contact_statistics()[0].mean_normal_force_n,
            second.contact_statistics()[0].mean_normal_force_n);
}

TEST(StateHash, DiffersAfterTheSmallestChangeOfAnything) {
  scene::Case c = above_nothing();
  Simulation reference(c);
  for (int k = 0; k < 3; ++k) {
    scene::Case changed = c;
    double& value = k == 0   ? changed.particles[0].position.x()
                    : k == 1 ? changed.particles[1].velocity.z()
                             : changed.particles[0].angular_velocity.y();
    value = std::nextafter(value, 1.0);
    EXPECT_NE(Simulation(changed).state_hash(), reference.state_hash()) << k;
  }
  std::swap(c.particles[0], c.particles[1]);
  EXPECT_NE(Simulation(c).state_hash(), reference.state_hash());  // they have ids
}

TEST(RunCase, StoppedAnywhereLeavesTheOutputOfAStraightRun) {
  const TestFolder folder;
  const scene::Case c = everything();
  const scene::RunSummary straight = run_case(c, folder.path / "straight");
  EXPECT_EQ(straight.state_hash.size(), 16u);
  int runs = 0;
  for (bool is_finished = false; !is_finished; ++runs) {
    int asked = 0;
    const auto request = [&] {
      ++asked;
      return asked == 9 + runs ? Request::stop
             : asked == 4      ? Request::write_checkpoint
                               : Request::none;
    };
    try {
      run_case(c, folder.path / "stopped", {.request = request});
      is_finished = true;
    } catch (const RunStopped& stopped) {
      EXPECT_NE(std::string(stopped.what()).find("the same command goes on"), std::string::npos);
      EXPECT_THROW(scene::read_run(folder.path / "stopped"), StorageError);
    }
    ASSERT_LT(runs, 50);
  }
  EXPECT_GT(runs, 3);
  expect_same_output(folder.path / "straight", folder.path / "stopped");
}

TEST(RunCase, WritesCheckpointsByWallTimeThatChangeNothing) {
  const TestFolder folder;
  scene::Case c = everything();
  c.stages = {{.name = "fill", .duration_s = 0.02}, {.name = "flow", .duration_s = 0.2}};
  c.motions.pop_back();
  run_case(c, folder.path / "without");
  bool seen = false;
  c.output.checkpoint_wall_time_s = 1e-9;
  run_case(c, folder.path / "with", {.progress = [&](double, double, std::string_view) {
             seen = seen || fs::exists(scene::checkpoint_file(folder.path / "with"));
           }});
  EXPECT_TRUE(seen);
  expect_same_output(folder.path / "without", folder.path / "with");
}

/// A stopped run of this case.
void leave_checkpoint(const scene::Case& c, const fs::path& run_dir) {
  EXPECT_THROW(run_case(c, run_dir, {.request = [] { return Request::stop; }}), RunStopped);
  ASSERT_TRUE(fs::exists(scene::checkpoint_file(run_dir)));
}

std::string refusal(const scene::Case& c, const fs::path& run_dir) {
  try {
    run_case(c, run_dir);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RunCase, RefusesTheCheckpointOfAnotherCaseByWhatDiffers) {
  const TestFolder folder;
  const scene::Case c = everything();
  leave_checkpoint(c, folder.path);
  const std::string before = read_file(scene::checkpoint_file(folder.path));
  scene::Case other = c;
  other.pairs[1].mu_s = 0.6;
  EXPECT_NE(refusal(other, folder.path)
                .find("in [[pair]] it had \"mu_s = 0.5\" where this case has \"mu_s = 0.6\""),
            std::string::npos)
      << refusal(other, folder.path);
  other = c;
  other.seed = 2;
  EXPECT_NE(refusal(other, folder.path).find("in [run] it had \"seed = 1\""), std::string::npos);
  other = c;
  other.stages[0].duration_s = 0.07;
  EXPECT_NE(refusal(other, folder.path).find("in [[stage]]"), std::string::npos)
      << refusal(other, folder.path);
  EXPECT_EQ(read_file(scene::checkpoint_file(folder.path)), before);
}

/// The same, filled with coefficients of the stage's own.
scene::Case filled_alike(scene::Case c, double mu_s) {
  c.stages[0].coefficients = scene::StageCoefficients{.restitution = 0.6, .mu_s = 0.3, .mu_r = 0.2};
  for (scene::PairCoefficients& pair : c.pairs) pair.mu_s = mu_s;
  return c;
}

TEST(RunCase, WaitsAfterAStageAndGoesOnWithAnotherCaseOfTheSameBeginning) {
  const TestFolder folder;
  const scene::Case one = everything();
  scene::Case other = one;
  other.stages[1].duration_s = 0.2;
  other.stages[1].flow_ends.reset();
  std::get<scene::Rotation>(other.motions[1].path).rate_rad_s = -12.0;
  const std::pair<scene::Case, scene::Case> kPairs[] = {
      {one, other}, {filled_alike(one, 0.5), filled_alike(one, 0.1)}};
  for (const auto& [first, second] : kPairs) {
    fs::remove_all(folder.path);
    const auto summary = run_case(first, folder.path / "shared", {.until = "fill"});
    EXPECT_EQ(summary.stages.size(), 1u);
    EXPECT_FALSE(fs::exists(folder.path / "shared/run.h5"));
    for (const auto& [c, name] : {std::pair{&first, "first"}, std::pair{&second, "second"}}) {
      const fs::path on = folder.path / name, straight = folder.path / "straight" / name;
      fs::copy(folder.path / "shared", on, fs::copy_options::recursive);
      run_case(*c, on);
      run_case(*c, straight);
      expect_same_output(straight, on);
      EXPECT_TRUE(scene::read_run(on).scene() == *c);
    }
    EXPECT_NE(scene::read_run(folder.path / "first").summary().state_hash,
              scene::read_run(folder.path / "second").summary().state_hash);
  }
}

TEST(RunCase, RefusesAWaitingRunWithAnotherBeginning) {
  const TestFolder folder;
  const scene::Case c = everything();
  run_case(c, folder.path, {.until = "fill"});
  scene::Case other = c;
  other.pairs[0].mu_s = 0.6;  // the filling uses it
  EXPECT_NE(refusal(other, folder.path).find("mu_s = 0.6"), std::string::npos);
  other = c;
  other.motions[1].walls = {"floor"};
  EXPECT_NE(refusal(other, folder.path).find("in [[motion]]"), std::string::npos);
}

TEST(RunCase, NamesTheStagesWhereItCannotWait) {
  const TestFolder folder;
  try {
    run_case(everything(), folder.path / "run", {.until = "settle"});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("it has fill and flow"), std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(fs::exists(folder.path / "run/case.toml"));
  EXPECT_THROW(run_case_into_file(everything(), folder.path / "run.h5", {.until = "fill"}),
               InputError);
}

/// What a run says that goes on in this folder.
std::string warnings(const scene::Case& c, const fs::path& run_dir) {
  std::string all;
  run_case(c, run_dir, {.warn = [&](std::string_view text) { all += text; }});
  return all;
}

TEST(RunCase, NamesBothBuildsWhereAnotherOneWroteTheCheckpoint) {
  const TestFolder folder;
  const fs::path file = scene::checkpoint_file(folder.path);
  const scene::Case c = above_nothing();
  leave_checkpoint(c, folder.path);
  EXPECT_EQ(warnings(c, folder.path), "");
  leave_checkpoint(c, folder.path);
  Checkpoint checkpoint = read_checkpoint(file);
  checkpoint.attributes["build"] = std::string("0.0.9 build 0123456789abcdef");
  write_checkpoint(file, checkpoint);
  const std::string said = warnings(c, folder.path);
  EXPECT_NE(said.find("0.0.9 build 0123456789abcdef"), std::string::npos) << said;
  EXPECT_NE(said.find("this is " + build_name()), std::string::npos) << said;
  EXPECT_NE(read_file(folder.path / "log.txt").find("warning: " + said), std::string::npos);
}

TEST(RunCase, BeginsAnewIfToldTo) {
  const TestFolder folder;
  scene::Case c = above_nothing();
  leave_checkpoint(c, folder.path);
  c.seed = 2;
  EXPECT_EQ(run_case(c, folder.path, {.start = Start::anew}).seed, 2u);
}

/// A run of this case that was finished in the folder of `file` and killed before it was moved.
void leave_finished(const scene::Case& c, const fs::path& file) {
  run_case(c, file.string() + ".parts");
}

TEST(RunCaseIntoFile, MovesARunThatWasFinishedBefore) {
  const TestFolder folder;
  const fs::path file = folder.path / "result.h5";
  scene::Case c = above_nothing();
  leave_finished(c, file);
  const std::string finished = read_file(folder.path / "result.h5.parts" / "run.h5");
  c.output.checkpoint_wall_time_s = 1.0;
  const scene::RunSummary summary = run_case_into_file(c, file);
  EXPECT_EQ(read_file(file), finished);  // with the wall time of then
  EXPECT_EQ(summary.state_hash, scene::read_run(file).summary().state_hash);
  EXPECT_FALSE(fs::exists(folder.path / "result.h5.parts"));
}

TEST(RunCaseIntoFile, RunsAnewWhereAnotherCaseOrADamagedFileIsFinished) {
  const TestFolder folder;
  const fs::path file = folder.path / "result.h5";
  scene::Case c = above_nothing();
  leave_finished(c, file);
  c.seed = 2;
  EXPECT_EQ(run_case_into_file(c, file).seed, 2u);
  fs::create_directories(folder.path / "result.h5.parts");
  std::ofstream(folder.path / "result.h5.parts" / "run.h5") << "no table";
  EXPECT_EQ(run_case_into_file(c, file).seed, 2u);
  EXPECT_EQ(scene::read_run(file).summary().seed, 2u);
}

TEST(RunCaseIntoFile, ThatCannotBeMovedStaysWholeAndIsMovedLater) {
  const TestFolder folder;
  const scene::Case c = above_nothing();
  const fs::path file = folder.path / "run.h5";
  const RunControl in_the_way{.progress = [&](double, double, std::string_view) {
    fs::create_directories(file / "something");
  }};
  EXPECT_THROW(run_case_into_file(c, file, in_the_way), StorageError);
  const fs::path parts = folder.path / "run.h5.parts";
  const std::string hash = scene::read_run(parts / "run.h5").summary().state_hash;
  fs::remove_all(file);
  EXPECT_EQ(run_case_into_file(c, file).state_hash, hash);
  EXPECT_TRUE(fs::is_regular_file(file));
  EXPECT_FALSE(fs::exists(parts));
}

TEST(RunCaseIntoFile, DoesNotBeginWhereItsResultCouldNotBePut) {
  const TestFolder folder;
  const fs::path file = folder.path / "result.h5";
  fs::create_directories(file);
  EXPECT_THROW(run_case_into_file(above_nothing(), file), StorageError);
  EXPECT_FALSE(fs::exists(folder.path / "result.h5.parts"));
}

TEST(RunCaseIntoFile, BeginsAnewIfToldTo) {
  const TestFolder folder;
  const fs::path file = folder.path / "result.h5";
  const scene::Case c = above_nothing();
  leave_finished(c, file);
  const std::string finished = read_file(folder.path / "result.h5.parts" / "run.h5");
  run_case_into_file(c, file, {.start = Start::anew});
  EXPECT_NE(read_file(file), finished);  // at least the wall time
}

TEST(RunCase, GoesOnWithAnotherIntervalOfCheckpoints) {
  const TestFolder folder;
  scene::Case c = above_nothing();
  leave_checkpoint(c, folder.path);
  c.output.checkpoint_wall_time_s = 1.0;
  EXPECT_GT(run_case(c, folder.path).steps, 0);
  EXPECT_NE(read_file(folder.path / "log.txt").find("goes on from the checkpoint"),
            std::string::npos);
}

TEST(Checkpoint, ThatIsDamagedIsRefusedWhereverTheDamage) {
  const TestFolder folder;
  const fs::path file = folder.path / "checkpoint.h5";
  const scene::Case c = above_nothing();
  Simulation sim(c);
  sim.step(10);
  write_checkpoint(file, sim.checkpoint());
  const std::string whole = read_file(file);
  constexpr std::size_t kPlaces = 500;
  for (std::size_t k = 0; k < kPlaces; ++k) {
    std::string text = whole;
    const std::size_t place = (whole.size() - 1) * k / (kPlaces - 1);
    text[place] = static_cast<char>(text[place] ^ (1 << (k % 8)));
    std::ofstream(file, std::ios::binary) << text;
    EXPECT_THROW(read_checkpoint(file), StorageError) << place;
  }
  for (const std::size_t length : {std::size_t{0}, whole.size() / 2, whole.size() - 1}) {
    std::ofstream(file, std::ios::binary) << whole.substr(0, length);
    EXPECT_THROW(read_checkpoint(file), StorageError) << length;
  }
}

TEST(Checkpoint, OfAnotherFormatOrNoneIsRefusedAsSuch) {
  const TestFolder folder;
  const fs::path file = folder.path / "checkpoint.h5";
  EXPECT_THROW(read_checkpoint(file), StorageError);
  Simulation sim(above_nothing());
  Checkpoint checkpoint = sim.checkpoint();
  checkpoint.tables.pop_back();
  write_checkpoint(file, checkpoint);
  EXPECT_THROW(Simulation(above_nothing(), read_checkpoint(file)), StorageError);
  EXPECT_THROW(run_case(above_nothing(), folder.path), StorageError);
}

}  // namespace
}  // namespace repose::dem

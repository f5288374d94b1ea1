#include <gtest/gtest.h>

#include <unistd.h>

#include <map>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/scene/run_output.hpp"
#include "sample_case.hpp"

namespace repose::scene {
namespace {

/// A folder that goes away with the test.
struct Scratch {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("repose_run_output_" + std::to_string(::getpid()));
  Scratch() { std::filesystem::remove_all(path); }
  ~Scratch() { std::filesystem::remove_all(path); }
};

/// The sample without VTP files, for which its mesh would have to be there.
Case recorded_case() {
  Case scene = sample_case();
  scene.output.vtp = false;
  return scene;
}

/// The sample with VTP files; its mesh is not there.
Case pictured_case() {
  Case scene = sample_case();
  std::erase_if(scene.walls, [](const Wall& wall) { return wall.name == "blade"; });
  std::erase_if(scene.motions, [](const Motion& m) { return m.walls.front() == "blade"; });
  return scene;
}

SeriesRow series_row() {
  return {.region_mass_kg = std::vector<double>(region_columns(sample_case()).size(), 0.0)};
}

Snapshot sample_snapshot(double time, const std::string& stage) {
  Snapshot s;
  s.time_s = time;
  s.stage = stage;
  s.materials = {"pellet", "steel"};
  s.id = {0, 1};
  s.body = {0, 0};
  s.material = {0, 0};
  s.radius_m = {0.01, 1.0 / 300.0};
  s.mass_kg = {0.1, 0.2};
  s.position = {{1, 2, 3}, {0.1, 0.2, 0.3}};
  s.velocity = {{-1, 0, 1e-17}, {4, 5, 6}};
  s.angular_velocity = {{7, 8, 9}, {0, 0, -1}};
  return s;
}

TEST(RunOutput, OfAFinishedRunReadsBackWhole) {
  const Scratch scratch;
  const Case scene = recorded_case();
  RunWriter writer(scratch.path, scene);
  const std::size_t columns = region_columns(scene).size();
  EXPECT_EQ(columns, 9u);  // three regions, each in all and of two materials
  const int rows = 10000;  // several chunks
  for (int k = 0; k < rows; ++k)
    writer.add_row({0.1 * k, 1.0 / (k + 1), 0.01, k, std::vector<double>(columns, 2.0 * k)});
  writer.write_snapshot(sample_snapshot(0.5, "fill"));
  writer.write_snapshot(sample_snapshot(2.5, "open"));
  RunSummary summary;
  summary.steps = 123;
  summary.spheres = 5;
  summary.bodies = {.inserted = 4,
                    .removed = 1,
                    .alive = 3,
                    .inserted_kg = 0.4,
                    .removed_kg = 0.1,
                    .alive_kg = 0.3};
  summary.engine = "test";
  summary.state_hash = "00ff00ff00ff00ff";
  summary.seed = 42;
  summary.stages = {{"fill", 0.5, "at rest"}, {"open", 2.5, "duration"}};
  writer.finish(summary);
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "snapshots"));
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "series"));

  const scene::Run run = read_run(scratch.path);
  EXPECT_EQ(run.summary().steps, 123);
  EXPECT_EQ(run.summary().spheres, 5);
  EXPECT_TRUE(run.summary().bodies == summary.bodies);
  EXPECT_EQ(run.summary().stages[0].reason, "at rest");
  EXPECT_EQ(run.summary().state_hash, "00ff00ff00ff00ff");
  EXPECT_TRUE(run.scene() == scene);
  ASSERT_EQ(run.series().rows(), static_cast<std::size_t>(rows));
  EXPECT_EQ(run.series().numbers("kinetic_energy_j")[9999], 1.0 / 10000);
  EXPECT_EQ(run.series().integers("contacts")[5000], 5000);
  EXPECT_EQ(run.series().numbers("mass_bin_pellet_kg")[7], 14.0);
  ASSERT_EQ(run.snapshots().size(), 2u);
  const Snapshot last = run.end_of("open");
  EXPECT_EQ(last.time_s, 2.5);
  EXPECT_EQ(last.body, (std::vector<std::int64_t>{0, 0}));
  EXPECT_EQ(last.radius_m[1], 1.0 / 300.0);
  EXPECT_EQ(last.position[0], Vec3(1, 2, 3));
  EXPECT_EQ(last.velocity[0].z(), 1e-17);
  EXPECT_EQ(last.angular_velocity[1], Vec3(0, 0, -1));
  EXPECT_THROW(run.end_of("close"), InputError);
  EXPECT_THROW(run.snapshot(2), InputError);
}

TEST(RunOutput, KeepsTheForcesOnEachWall) {
  const Scratch scratch;
  const Case scene = recorded_case();
  RunWriter writer(scratch.path, scene);
  const std::size_t walls = scene.walls.size();
  WallRow row{0.25, std::vector<Vec3>(walls, Vec3(1, 2, 3)),
              std::vector<Vec3>(walls, Vec3(4, 5, 6))};
  row.force_n.back() = {0, 0, -1.0 / 3.0};
  writer.add_row(series_row());
  writer.add_row(row);
  writer.finish({});
  const table::Table table = read_run(scratch.path).walls();
  ASSERT_EQ(table.columns().size(), 1 + 6 * walls);
  EXPECT_EQ(table.numbers("time_s"), std::vector<double>{0.25});
  EXPECT_EQ(table.numbers("fy_bin.-z_n"), std::vector<double>{2.0});
  EXPECT_EQ(table.numbers("tz_bin.-z_n_m"), std::vector<double>{6.0});
  EXPECT_EQ(table.numbers("fz_ground_n"), std::vector<double>{-1.0 / 3.0});
  EXPECT_EQ(table.column("fz_ground_n").unit, "N");
  EXPECT_EQ(table.column("tz_ground_n_m").unit, "N m");
}

TEST(RunOutput, KeepsContactsByPairOfMaterials) {
  const Scratch scratch;
  RunWriter writer(scratch.path, recorded_case());
  writer.add_row(series_row());
  writer.add_row(ContactRow{0.5, {{7, 1.5, 4.0, 0.001, 0.25}, {0, 0, 0, 0, 0}}});
  writer.add_row(ContactRow{0.6, {{8, 1.5, 4.0, 0.001, 0.5}, {1, 2.0, 2.0, 0.002, 1.0}}});
  writer.finish({});
  const table::Table table = read_run(scratch.path).contacts();
  EXPECT_EQ(table.integers("contacts_pellet_pellet"), (std::vector<std::int64_t>{7, 8}));
  EXPECT_EQ(table.numbers("mean_normal_force_steel_pellet_n"), (std::vector<double>{0.0, 2.0}));
  EXPECT_EQ(table.numbers("largest_normal_force_pellet_pellet_n")[0], 4.0);
  EXPECT_EQ(table.numbers("mean_overlap_ratio_steel_pellet")[1], 0.002);
  EXPECT_EQ(table.numbers("sliding_fraction_pellet_pellet"), (std::vector<double>{0.25, 0.5}));
}

TEST(RunOutput, KeepsTheEnergyLedger) {
  const Scratch scratch;
  RunWriter writer(scratch.path, recorded_case());
  EnergyRow row;
  row.time_s = 0.5;
  row.kinetic_rotational_j = 2.0;
  row.dissipated_sliding_j = 1.0 / 3.0;
  row.error_j = 1e-17;
  writer.add_row(series_row());
  writer.add_row(row);
  writer.finish({});
  const table::Table table = read_run(scratch.path).energy();
  EXPECT_EQ(table.columns().size(), 17u);
  EXPECT_EQ(table.numbers("kinetic_rotational_j")[0], 2.0);
  EXPECT_EQ(table.numbers("dissipated_sliding_j")[0], 1.0 / 3.0);
  EXPECT_EQ(table.numbers("error_j")[0], 1e-17);
  EXPECT_EQ(table.numbers("gravitational_j")[0], 0.0);
}

TEST(RunOutput, SaysWhatToDoForATableThatWasNotRecorded) {
  const Scratch scratch;
  RunWriter writer(scratch.path, recorded_case());
  writer.add_row(series_row());
  writer.finish({});
  try {
    read_run(scratch.path).energy();
    ADD_FAILURE() << "a table that is not there was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("output.energy = true"), std::string::npos);
  }
}

TEST(RunOutput, RefusesARowOfTheWrongLength) {
  const Scratch scratch;
  RunWriter writer(scratch.path, recorded_case());
  EXPECT_THROW(writer.add_row({0, 0, 0, 0, std::vector<double>(8, 0.0)}), std::logic_error);
}

TEST(RunOutput, HasVtpFilesIfAsked) {
  const Scratch scratch;
  RunWriter writer(scratch.path, pictured_case());
  writer.add_row(series_row());
  writer.write_snapshot(sample_snapshot(0.5, "fill"));
  writer.finish({});
  for (const char* file :
       {"particles.pvd", "particles_000001.vtp", "walls.pvd", "walls_000001.vtp"})
    EXPECT_TRUE(std::filesystem::exists(scratch.path / "vtp" / file)) << file;
}

/// Rows and snapshots of the times k = first, ..., last - 1; every second one moves the walls.
void write_times(RunWriter& writer, const Case& scene, int first, int last) {
  std::vector<WallPose> poses(scene.walls.size());
  for (int k = first; k < last; ++k) {
    SeriesRow row = series_row();
    row.time_s = k;
    writer.add_row(row);
    writer.add_row(EnergyRow{.time_s = static_cast<double>(k)});
    poses.back().translation.x() = k / 2;
    writer.write_snapshot(sample_snapshot(k, "fill"), poses);
  }
}

std::map<std::string, std::string> vtp_files(const std::filesystem::path& run_dir) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(run_dir / "vtp"))
    files[entry.path().filename().string()] = read_file(entry.path());
  return files;
}

TEST(RunOutput, GoesOnWhereItWasStoppedAsIfItHadNotBeen) {
  const Scratch scratch;
  const Case scene = pictured_case();
  {
    RunWriter writer(scratch.path / "straight", scene);
    write_times(writer, scene, 0, 7);
    writer.finish({});
  }
  OutputPosition position;
  {
    RunWriter writer(scratch.path / "stopped", scene);
    write_times(writer, scene, 0, 3);
    position = writer.position();
    write_times(writer, scene, 3, 6);  // was written, but the state of the run was not
    writer.position();
    write_file_atomically(scratch.path / "stopped" / "series" / ".x.h5.1.0.tmp", "half");
  }
  RunWriter writer(scratch.path / "stopped", scene, position);
  EXPECT_TRUE(writer.position() == position);
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "stopped" / "series" / ".x.h5.1.0.tmp"));
  write_times(writer, scene, 3, 7);
  writer.finish({});
  const scene::Run straight = read_run(scratch.path / "straight");
  const scene::Run stopped = read_run(scratch.path / "stopped");
  EXPECT_EQ(stopped.series().numbers("time_s"), straight.series().numbers("time_s"));
  EXPECT_EQ(stopped.energy().numbers("time_s"), straight.energy().numbers("time_s"));
  ASSERT_EQ(stopped.snapshots().size(), 7u);
  for (std::size_t i = 0; i < 7; ++i)
    EXPECT_EQ(stopped.snapshots()[i].time_s, static_cast<double>(i));
  EXPECT_EQ(vtp_files(scratch.path / "stopped"), vtp_files(scratch.path / "straight"));
}

TEST(RunOutput, DoesNotGoOnWithoutAPartThatItNeeds) {
  const Scratch scratch;
  const Case scene = pictured_case();
  RunWriter writer(scratch.path, scene);
  write_times(writer, scene, 0, 3);
  const OutputPosition position = writer.position();
  std::filesystem::remove(scratch.path / "snapshots" / "snapshot_000002.h5");
  try {
    const RunWriter again(scratch.path, scene, position);
    ADD_FAILURE() << "a missing snapshot was not noticed";
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("snapshot_000002.h5: is missing"), std::string::npos)
        << error.what();
  }
}

TEST(RunOutput, OfAnUnfinishedRunIsRefusedAsSuch) {
  const Scratch scratch;
  RunWriter writer(scratch.path, recorded_case());
  writer.write_snapshot(sample_snapshot(0.5, "fill"));
  try {
    read_run(scratch.path);
    FAIL();
  } catch (const StorageError& error) {
    EXPECT_NE(std::string(error.what()).find("did not finish"), std::string::npos);
  }
  EXPECT_THROW(read_run(scratch.path / "nowhere"), StorageError);
}

TEST(RunOutput, OfANewRunReplacesThatOfTheOld) {
  const Scratch scratch;
  {
    RunWriter writer(scratch.path, recorded_case());
    writer.add_row(series_row());
    writer.write_snapshot(sample_snapshot(0.5, "fill"));
    writer.finish({});
  }
  const RunWriter writer(scratch.path, recorded_case());
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "run.h5"));
}

}  // namespace
}  // namespace repose::scene

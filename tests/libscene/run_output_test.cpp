#include <gtest/gtest.h>

#include <unistd.h>

#include "repose/base/error.hpp"
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
  const Case scene = sample_case();
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
  summary.engine = "test";
  summary.seed = 42;
  summary.stages = {{"fill", 0.5, "at rest"}, {"open", 2.5, "duration"}};
  writer.finish(summary);
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "snapshots"));
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "series"));

  const scene::Run run = read_run(scratch.path);
  EXPECT_EQ(run.summary().steps, 123);
  EXPECT_EQ(run.summary().stages[0].reason, "at rest");
  EXPECT_TRUE(run.scene() == scene);
  ASSERT_EQ(run.series().rows(), static_cast<std::size_t>(rows));
  EXPECT_EQ(run.series().numbers("kinetic_energy_j")[9999], 1.0 / 10000);
  EXPECT_EQ(run.series().integers("contacts")[5000], 5000);
  EXPECT_EQ(run.series().numbers("mass_bin_pellet_kg")[7], 14.0);
  ASSERT_EQ(run.snapshots().size(), 2u);
  const Snapshot last = run.end_of("open");
  EXPECT_EQ(last.time_s, 2.5);
  EXPECT_EQ(last.radius_m[1], 1.0 / 300.0);
  EXPECT_EQ(last.position[0], Vec3(1, 2, 3));
  EXPECT_EQ(last.velocity[0].z(), 1e-17);
  EXPECT_EQ(last.angular_velocity[1], Vec3(0, 0, -1));
  EXPECT_THROW(run.end_of("close"), InputError);
  EXPECT_THROW(run.snapshot(2), InputError);
}

TEST(RunOutput, OfAnUnfinishedRunIsRefusedAsSuch) {
  const Scratch scratch;
  RunWriter writer(scratch.path, sample_case());
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
    RunWriter writer(scratch.path, sample_case());
    writer.add_row({0, 0, 0, 0, std::vector<double>(9, 0.0)});
    writer.write_snapshot(sample_snapshot(0.5, "fill"));
    writer.finish({});
  }
  const RunWriter writer(scratch.path, sample_case());
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "run.h5"));
}

}  // namespace
}  // namespace repose::scene

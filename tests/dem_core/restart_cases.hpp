// A case with everything whose state a checkpoint must hold, and what compares two runs of it.
#pragma once

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include "mesh_walls.hpp"
#include "repose/base/file.hpp"
#include "repose/scene/run_output.hpp"
#include "repose/table/io.hpp"

namespace repose::dem {

/// A folder that goes away with the test.
struct TestFolder {
  std::filesystem::path path = std::filesystem::temp_directory_path() /
                               ("repose_restart_" + std::to_string(::getpid()) + "_" +
                                ::testing::UnitTest::GetInstance()->current_test_info()->name());
  TestFolder() {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~TestFolder() { std::filesystem::remove_all(path); }
};

/// Spheres of two sizes and clumps, poured and raining, periodic in y, on a shaking mesh, stirred
/// by another one; in the second stage a side opens, behind which a region removes what comes.
inline scene::Case everything() {
  scene::Case c = empty_case({.youngs_modulus = 5e6, .restitution = 0.4, .mu_s = 0.5, .mu_r = 0.1});
  c.gravity_m_s2 = {0.5, 0.2, -9.81};
  c.lower_m = {-0.08, -0.03, -0.05};
  c.upper_m = {0.08, 0.03, 0.3};
  c.periodic.y = true;
  c.time_step_rayleigh_fraction = 0.25;
  c.walls = {mesh_wall("floor", floor_triangles(-0.04, 0.04, -0.03, 0.03, 4, 3)),
             mesh_wall("stirrer", floor_triangles(-0.01, 0.01, -0.03, 0.03, 2, 3)),
             rectangle("left", {-0.04, -0.03, -0.01}, {0, 0.06, 0}, {0, 0, 0.3}),
             rectangle("right", {0.04, -0.03, -0.01}, {0, 0.06, 0}, {0, 0, 0.3})};
  std::get<scene::Mesh>(c.walls[1].shape).translation = {0.01, 0.0, 0.025};
  c.motions = {{.walls = {"floor"}, .path = scene::Oscillation{{0, 0, 0.002}, 20.0, 0.3}},
               {.walls = {"stirrer"},
                .path = scene::Rotation{{0.01, 0, 0.025}, {0, 1, 0}, 8.0},
                .stage = "flow"}};
  c.regions = {{"inside", {-0.04, -1, -1}, {0.04, 1, 1}},
               {"sink", {0.045, -1, -1}, {1, 1, 1}, {}, true}};
  c.fill = scene::Fill{{-0.04, -0.03, 0.04},
                       {0.04, 0.03, 0.25},
                       0.2,
                       {layer_of("grain", 0.05, {{0.006, 0.010, 1.0}})}};
  scene::Rain rain;
  rain.name = "rain";
  rain.mixture = {{.material = "grain",
                   .clump = "sinter_3",
                   .sizes = std::vector<scene::SizeClass>{{0.008, 0.009, 1.0}}}};
  rain.mass_kg = 0.02;
  rain.mass_rate_kg_s = 0.2;
  rain.lower = {-0.03, -0.03, 0.2};
  rain.upper = {0.03, 0.03, 0.29};
  rain.velocity = {0, 0, -0.5};
  c.rains = {rain};
  c.stages = {{.name = "fill", .duration_s = 0.08},
              {.name = "flow", .opens = {"right"}, .duration_s = 0.25}};
  c.stages[1].flow_ends = scene::FlowEnds{.region = "inside", .fraction = 1e-6, .window_s = 0.1};
  c.stages[1].minimum_s = 0.15;
  c.output = {
      .snapshot_interval_s = 0.03, .vtp = true, .energy = true, .checkpoint_wall_time_s = 0};
  return c;
}

/// Two grains that pass each other.
inline scene::Case above_nothing() {
  scene::Case c = empty_case({.youngs_modulus = 5e6});
  c.particles = {grain(0.01, {0.1, 0.2, 0.3}, {0.5, 0, 0}, {0.1, 0.2, 0.3}),
                 grain(0.01, {0.15, 0.2, 0.3}, {0, 0.25, 0.125})};
  c.stages = {{.name = "fly", .duration_s = 0.05}};
  return c;
}

/// All values and attributes, as text that has every bit.
inline std::string all_of(const std::filesystem::path& file, const std::string& group) {
  std::string text;
  const table::Table table = table::read_table({file, group}, table::Missing::allow);
  for (const table::Column& column : table.columns()) text += column.name + ' ';
  return text + table::csv_text(table);
}

inline std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  if (!std::filesystem::exists(folder)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files[entry.path().filename().string()] = read_file(entry.path());
  return files;
}

/// Everything that two runs leave is equal, but for the time they took and their logs.
inline void expect_same_output(const std::filesystem::path& a, const std::filesystem::path& b) {
  const std::filesystem::path of_a = a / "run.h5", of_b = b / "run.h5";
  const std::vector<std::string> tables = table::list_tables(of_a);
  ASSERT_EQ(tables, table::list_tables(of_b));
  for (const std::string& group : tables) EXPECT_EQ(all_of(of_a, group), all_of(of_b, group));
  table::Attributes about_a = table::read_attributes({of_a, "/"});
  table::Attributes about_b = table::read_attributes({of_b, "/"});
  EXPECT_TRUE(about_a.contains("state_hash"));
  for (const char* of_this_run : {"wall_time_s", "case"}) {
    about_a.erase(of_this_run);
    about_b.erase(of_this_run);
  }
  EXPECT_TRUE(about_a == about_b);
  EXPECT_EQ(files_in(a / "vtp"), files_in(b / "vtp"));
  for (const char* part : {"checkpoint.h5", "series", "snapshots"})
    EXPECT_FALSE(std::filesystem::exists(b / part)) << part;
}

}  // namespace repose::dem

#include "output/run_state.hpp"

#include "checkpoint/columns.hpp"

namespace repose::dem {
namespace {

table::Table ends_table(const std::vector<scene::StageEnd>& ends) {
  TableBuilder rows(ends.size());
  rows.texts("name", [&](std::size_t r) { return ends[r].name; });
  rows.numbers("end", "s", [&](std::size_t r) { return ends[r].time_s; });
  rows.texts("reason", [&](std::size_t r) { return ends[r].reason; });
  return rows.take();
}

table::Table masses_table(const StageWatch::Progress& watch) {
  TableBuilder rows(watch.masses.size());
  rows.numbers("time", "s", [&](std::size_t r) { return watch.masses[r].time_s; });
  rows.numbers("mass", "kg", [&](std::size_t r) { return watch.masses[r].mass_kg; });
  return rows.take();
}

table::Table region_masses_table(const scene::SeriesRow& row) {
  TableBuilder rows(row.region_mass_kg.size());
  rows.numbers("mass", "kg", [&](std::size_t r) { return row.region_mass_kg[r]; });
  return rows.take();
}

table::Table poses_table(const std::vector<scene::WallPose>& poses) {
  TableBuilder rows(poses.size());
  rows.integers("open", [&](std::size_t r) { return poses[r].is_open ? 1 : 0; });
  rows.vectors("translation", "m", [&](std::size_t r) { return poses[r].translation; });
  for (int k = 0; k < 3; ++k)
    rows.vectors(std::string("rotation_row_") + "xyz"[k], "1",
                 [&](std::size_t r) { return Vec3(poses[r].rotation.row(k)); });
  return rows.take();
}

std::vector<scene::WallPose> poses_of(const table::Table& table) {
  std::vector<scene::WallPose> poses(table.rows());
  const auto open = table.integers("open");
  const VectorColumn translation(table, "translation");
  const VectorColumn rotation[3] = {VectorColumn(table, "rotation_row_x"),
                                    VectorColumn(table, "rotation_row_y"),
                                    VectorColumn(table, "rotation_row_z")};
  for (std::size_t r = 0; r < poses.size(); ++r) {
    poses[r].is_open = open[r] != 0;
    poses[r].translation = translation[r];
    for (int k = 0; k < 3; ++k) poses[r].rotation.row(k) = rotation[k][r];
  }
  return poses;
}

}  // namespace

void add_to(Checkpoint& checkpoint, const RunState& state) {
  checkpoint.tables.emplace_back("/stage_ends", ends_table(state.ends));
  checkpoint.tables.emplace_back("/stage_masses", masses_table(state.watch));
  checkpoint.tables.emplace_back("/region_masses", region_masses_table(state.last_row));
  checkpoint.tables.emplace_back("/vtp_poses", poses_table(state.output.poses));
  table::Attributes& a = checkpoint.attributes;
  a["stage"] = static_cast<std::int64_t>(state.stage);
  a["stage_begun"] = static_cast<std::int64_t>(state.is_begun ? 1 : 0);
  a["stage_last_step"] = state.last_step;
  a["stage_watch"] = std::vector<double>{state.watch.moving_until_s, state.watch.initial_mass_kg,
                                         state.watch.start_s};
  a["last_row"] = std::vector<double>{state.last_row.time_s, state.last_row.kinetic_energy_j,
                                      state.last_row.max_overlap_ratio};
  a["last_row_contacts"] = state.last_row.contacts;
  a["weight_scale_j"] = state.weight_scale_j;
  a["latest_end_s"] = state.latest_end_s;
  const LargestOverlap& overlap = state.deepest.overlap;
  a["deepest"] = std::vector<double>{overlap.overlap_m,
                                     overlap.smaller_radius_m,
                                     state.deepest.time_s,
                                     static_cast<double>(overlap.sphere),
                                     static_cast<double>(overlap.other),
                                     overlap.is_at_wall ? 1.0 : 0.0,
                                     static_cast<double>(state.deepest.material),
                                     static_cast<double>(state.deepest.partner)};
  a["sphere_steps"] = state.sphere_steps;
  a["wall_time_s"] = state.wall_time_s;
  a["processor_time_s"] = state.processor_time_s;
  a["chunks"] = std::vector<double>(state.output.chunks.begin(), state.output.chunks.end());
  a["snapshots"] = state.output.snapshots;
}

RunState run_state_of(const Checkpoint& checkpoint) {
  RunState state;
  state.stage = static_cast<std::size_t>(checkpoint.integer("stage"));
  state.is_begun = checkpoint.integer("stage_begun") != 0;
  state.last_step = checkpoint.integer("stage_last_step");
  const auto watch = checkpoint.numbers("stage_watch", 3);
  state.watch.moving_until_s = watch[0];
  state.watch.initial_mass_kg = watch[1];
  state.watch.start_s = watch[2];
  const table::Table& masses = checkpoint.table("/stage_masses");
  const auto times = masses.numbers("time");
  const auto kg = masses.numbers("mass");
  for (std::size_t r = 0; r < times.size(); ++r) state.watch.masses.push_back({times[r], kg[r]});
  const auto row = checkpoint.numbers("last_row", 3);
  state.last_row = {row[0], row[1], row[2], checkpoint.integer("last_row_contacts"),
                    checkpoint.table("/region_masses").numbers("mass")};
  state.weight_scale_j = checkpoint.number("weight_scale_j");
  state.latest_end_s = checkpoint.number("latest_end_s");
  const auto deepest = checkpoint.numbers("deepest", 8);
  const auto whole = [&](std::size_t k) { return static_cast<std::int32_t>(deepest[k]); };
  state.deepest = {
      {deepest[0], deepest[1], whole(3), whole(4), whole(5) != 0}, deepest[2], whole(6), whole(7)};
  state.sphere_steps = checkpoint.number("sphere_steps");
  state.wall_time_s = checkpoint.number("wall_time_s");
  state.processor_time_s = checkpoint.number("processor_time_s");
  const table::Table& ends = checkpoint.table("/stage_ends");
  const auto end_times = ends.numbers("end");
  for (std::size_t r = 0; r < ends.rows(); ++r)
    state.ends.push_back({ends.texts("name")[r], end_times[r], ends.texts("reason")[r]});
  for (const double chunks : checkpoint.numbers("chunks", 4))
    state.output.chunks.push_back(static_cast<std::int64_t>(chunks));
  state.output.snapshots = checkpoint.integer("snapshots");
  state.output.poses = poses_of(checkpoint.table("/vtp_poses"));
  return state;
}

}  // namespace repose::dem

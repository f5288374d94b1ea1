// What a run leaves behind: time series, snapshots of all particles and a summary.
//
// While it runs, RUN_DIR holds case.toml, log.txt, snapshots/snapshot_000001.h5 ... and
// series/series_000001.h5, walls_000001.h5 ..., each a closed HDF5 file written atomically. At the
// end they become one run.h5: tables /series, /walls, /contacts, /energy (those that have rows) and
// /snapshots/000001 ..., and the summary as attributes of the file; only then does run.h5 exist,
// and the parts are removed. RUN_DIR/vtp, if Output::vtp, stays (see vtp.hpp).
// RUN_DIR/checkpoint.h5 holds the state from which a run that was stopped goes on; it is the
// engine's and goes with the parts.
//
// Columns of all four time series: time_s, and then
//   /series    kinetic_energy_j, max_overlap_ratio (the largest since the row before), contacts,
//              and for each region mass_REGION_kg and mass_REGION_MATERIAL_kg
//   /walls     for each wall fx_WALL_n, fy_, fz_, tx_WALL_n_m, ty_, tz_: force and torque of the
//              particles on it, mean since the row before
//   /contacts  for each pair of materials A, B: contacts_A_B, mean_normal_force_A_B_n,
//              largest_normal_force_A_B_n, mean_overlap_ratio_A_B, sliding_fraction_A_B
//   /energy    the fields of EnergyRow
// Columns of a snapshot, one row a sphere: id, body, material (index into the attribute
// `materials`), radius_m, mass_kg, x_m, y_m, z_m, vx_m_s, vy_m_s, vz_m_s, wx_rad_s, wy_rad_s,
// wz_rad_s; attributes time_s, stage, materials.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "repose/scene/case.hpp"
#include "repose/scene/run_records.hpp"
#include "repose/table/table.hpp"

namespace repose::scene {

/// How far the output of a run has come: with its folder all that a RunWriter needs to go on.
struct OutputPosition {
  std::vector<std::int64_t> chunks;  ///< closed files of /series, /walls, /contacts, /energy
  std::int64_t snapshots = 0;
  std::vector<WallPose> poses;  ///< of the last snapshot as VTP
  bool operator==(const OutputPosition&) const = default;
};

/// Where the checkpoint of a run is, see docs/decisions/0008.
std::filesystem::path checkpoint_file(const std::filesystem::path& run_dir);

/// Writes a run folder as it grows.
class RunWriter {
 public:
  /// Creates the folder, removes what an earlier run left in it, writes case.toml. Throws
  /// StorageError.
  RunWriter(std::filesystem::path directory, const Case& scene);
  /// Goes on in the folder of a run that was stopped, from where position() once was: removes what
  /// was written later. Throws StorageError if something is missing.
  RunWriter(std::filesystem::path directory, const Case& scene, const OutputPosition& position);
  ~RunWriter();
  RunWriter(RunWriter&&) noexcept;
  RunWriter& operator=(RunWriter&&) noexcept;

  void add_row(const SeriesRow& row);
  void add_row(const WallRow& row);
  void add_row(const ContactRow& row);
  void add_row(const EnergyRow& row);
  /// `poses` of Case::walls at this time, for VTP files; empty: as drawn.
  void write_snapshot(const Snapshot& snapshot, const std::vector<WallPose>& poses = {});
  /// Writes all rows that wait, and tells how far the output has come. Throws StorageError.
  OutputPosition position();
  /// Appends a line to log.txt.
  void log(std::string_view line);
  /// Assembles run.h5, then removes checkpoint and parts.
  void finish(const RunSummary& summary);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A finished run. Series and summary are in memory, snapshots are read when asked for.
class Run {
 public:
  struct SnapshotInfo {
    double time_s = 0.0;
    std::string stage;
  };

  const RunSummary& summary() const { return summary_; }
  const table::Table& series() const { return series_; }
  /// The tables /walls, /contacts and /energy, read from the file. Throw InputError if the run has
  /// none.
  table::Table walls() const;
  table::Table contacts() const;
  table::Table energy() const;
  /// The case that was run.
  const Case& scene() const { return scene_; }
  const std::vector<SnapshotInfo>& snapshots() const { return infos_; }
  /// Reads snapshot i from the file. Throws StorageError.
  Snapshot snapshot(std::size_t i) const;
  /// The last snapshot of a stage. Throws InputError if there is none.
  Snapshot end_of(const std::string& stage) const;

 private:
  friend Run read_run(const std::filesystem::path& path);
  std::filesystem::path file_;
  RunSummary summary_;
  table::Table series_;
  Case scene_;
  std::vector<SnapshotInfo> infos_;
};

/// Opens a run by its folder or its run.h5. Throws StorageError, saying so if the run did not
/// finish.
Run read_run(const std::filesystem::path& path);

}  // namespace repose::scene

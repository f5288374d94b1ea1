// What a run leaves behind: the time series, snapshots of all particles and a summary.
//
// While it runs, RUN_DIR holds case.toml, log.txt, snapshots/snapshot_000001.h5 ... and
// series/series_000001.h5 ..., each a closed HDF5 file written atomically. At the end they become
// one run.h5: tables /series and /snapshots/000001 ..., and the summary as attributes of the file;
// only then does run.h5 exist, and the parts are removed.
//
// Columns of the series: time_s, kinetic_energy_j, max_overlap_ratio (the largest since the row
// before), contacts, and for each region mass_REGION_kg and mass_REGION_MATERIAL_kg. Columns of a
// snapshot: id, material (index into the attribute `materials`), radius_m, mass_kg, x_m, y_m, z_m,
// vx_m_s, vy_m_s, vz_m_s, wx_rad_s, wy_rad_s, wz_rad_s; attributes time_s, stage, materials.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "repose/scene/case.hpp"
#include "repose/table/table.hpp"

namespace repose::scene {

/// One row of the time series.
struct SeriesRow {
  double time_s = 0.0;
  double kinetic_energy_j = 0.0;
  double max_overlap_ratio = 0.0;
  std::int64_t contacts = 0;
  std::vector<double> region_mass_kg;  ///< in the order of region_columns()
};

/// Names of the region columns of a case: for each region its mass, then that of each material.
std::vector<std::string> region_columns(const Case& scene);

/// All particles at one time; vectors of equal length, by ascending id.
struct Snapshot {
  double time_s = 0.0;
  std::string stage;
  std::vector<std::string> materials;
  std::vector<std::int64_t> id;
  std::vector<std::int64_t> material;
  std::vector<double> radius_m, mass_kg;
  std::vector<Vec3> position, velocity, angular_velocity;  ///< m, m/s, rad/s

  std::size_t size() const { return id.size(); }
};

/// How and when a stage ended: "duration", "at rest" or "flow ended".
struct StageEnd {
  std::string name;
  double time_s = 0.0;
  std::string reason;
};

struct RunSummary {
  std::int64_t steps = 0;
  double time_step_s = 0.0;
  std::int64_t particles = 0;
  double mass_kg = 0.0;
  double wall_time_s = 0.0;
  double largest_overlap_ratio = 0.0;
  std::string engine;   ///< e.g. "repose-dem"
  std::string version;  ///< of the engine
  std::uint64_t seed = 0;
  std::vector<StageEnd> stages;
};

/// Writes a run folder as it grows.
class RunWriter {
 public:
  /// Creates the folder, removes what an earlier run left in it, writes case.toml. Throws
  /// StorageError.
  RunWriter(std::filesystem::path directory, const Case& scene);

  void add_row(const SeriesRow& row);
  void write_snapshot(const Snapshot& snapshot);
  /// Appends a line to log.txt.
  void log(std::string_view line);
  /// Assembles run.h5 and removes the parts.
  void finish(const RunSummary& summary);

 private:
  void write_series_chunk();

  std::filesystem::path directory_;
  std::string case_text_;
  std::vector<std::string> region_columns_;
  std::vector<SeriesRow> rows_;  // not yet written
  int chunks_ = 0;
  int snapshots_ = 0;
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

// What a run records: rows of its time series, snapshots and a summary.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "repose/scene/case.hpp"

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

/// What particles do to the walls, mean since the row before; in the order of Case::walls, zero for
/// walls that were taken away.
struct WallRow {
  double time_s = 0.0;
  std::vector<Vec3> force_n;
  /// About the centre of the wall's first rotation, else about the origin.
  std::vector<Vec3> torque_n_m;
};

/// The contacts of one pair of materials at one time.
struct PairContacts {
  std::int64_t contacts = 0;
  double mean_normal_force_n = 0.0;  ///< 0 without contacts, as all that follow
  double largest_normal_force_n = 0.0;
  double mean_overlap_ratio = 0.0;  ///< over the smaller radius
  double sliding_fraction = 0.0;    ///< of contacts whose tangential force is at its limit
};
struct ContactRow {
  double time_s = 0.0;
  std::vector<PairContacts> pairs;  ///< in the order of Case::pairs
};

/// The energy ledger. What was dissipated, done and brought in or out counts from the beginning of
/// the run.
struct EnergyRow {
  double time_s = 0.0;
  double kinetic_translational_j = 0.0, kinetic_rotational_j = 0.0;
  /// -sum(m g.x), x from the origin and on across periodic sides
  double gravitational_j = 0.0;
  double elastic_normal_j = 0.0, elastic_tangential_j = 0.0, elastic_rolling_j = 0.0;
  double dissipated_normal_j = 0.0;      ///< by damping
  double dissipated_tangential_j = 0.0;  ///< by damping
  double dissipated_sliding_j = 0.0;
  double dissipated_rolling_j = 0.0;
  /// Lost, or won if negative, because tangential and rolling stiffness follow the overlap while
  /// the displacements that load them stay: the price of a displacement history.
  double stiffness_change_j = 0.0;
  double released_j = 0.0;   ///< lost with contacts that ended while they still stored it
  double wall_work_j = 0.0;  ///< done by moving walls on particles
  double inserted_j = 0.0;   ///< brought in by particles that appeared
  double removed_j = 0.0;    ///< taken out with particles that were removed
  /// What is there now and was dissipated or removed, less what was there at first, was inserted
  /// and done by walls: 0 but for the error of integration.
  double error_j = 0.0;
};

/// All spheres at one time; vectors of equal length, by ascending id.
struct Snapshot {
  double time_s = 0.0;
  std::string stage;
  std::vector<std::string> materials;
  std::vector<std::int64_t> id;    ///< of the sphere, for life; removed ones are missing
  std::vector<std::int64_t> body;  ///< of its rigid body: spheres of one clump share it
  std::vector<std::int64_t> material;
  std::vector<double> radius_m;
  std::vector<double> mass_kg;                             ///< shares of a clump sum to its mass
  std::vector<Vec3> position, velocity, angular_velocity;  ///< m, m/s, rad/s

  std::size_t size() const { return id.size(); }
};

/// Where a wall is: x = rotation * (x as drawn in the case) + translation.
struct WallPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Vec3 translation = Vec3::Zero();
  bool is_open = false;  ///< taken away
  bool operator==(const WallPose&) const = default;
};

/// How and when a stage ended: "duration", "at rest" or "flow ended".
struct StageEnd {
  std::string name;
  double time_s = 0.0;
  std::string reason;
};

/// Bodies that came and went; a clump counts once. inserted = removed + alive: a lost particle is
/// an error.
struct Ledger {
  std::int64_t inserted = 0, removed = 0, alive = 0;
  double inserted_kg = 0.0, removed_kg = 0.0, alive_kg = 0.0;
  bool operator==(const Ledger&) const = default;
};

struct RunSummary {
  std::int64_t steps = 0;
  double time_step_s = 0.0;
  std::int64_t spheres = 0;  ///< at the end, those of clumps among them
  Ledger bodies;             ///< at the end
  double wall_time_s = 0.0;
  double largest_overlap_ratio = 0.0;
  /// 16 hexadecimal digits that stand for all bits of the final state: equal runs have equal ones.
  /// Empty if the engine gives none.
  std::string state_hash;
  std::string engine;   ///< e.g. "repose-dem"
  std::string version;  ///< of the engine
  std::uint64_t seed = 0;
  std::vector<StageEnd> stages;
};

}  // namespace repose::scene

// What a simulation is at one time, in the records of a run.
#pragma once

#include <string>
#include <vector>

#include "repose/dem/simulation.hpp"
#include "repose/scene/run_records.hpp"

namespace repose::dem {

/// What a row of the time series says of the bodies.
struct BodySums {
  double kinetic_energy_j = 0.0;
  /// In the order of scene::region_columns(); a body counts where its centre of mass is.
  std::vector<double> region_mass_kg;
  /// What the kinetic energy of particles at rest is compared with: sum(m) g d_mean, 0 without
  /// particles.
  double weight_scale_j = 0.0;
};
BodySums body_sums(const scene::Case& scene, Simulation& sim);

scene::Snapshot snapshot_of(const scene::Case& scene, const std::string& stage, Simulation& sim);

/// Loads on the walls since the last reading, which this is.
scene::WallRow wall_row_of(Simulation& sim);

/// Whether rain of this stage or of an earlier one is still to fall.
bool awaits_rain(const scene::Case& scene, const std::string& stage, const Simulation& sim);

/// Overlaps above this part of the smaller radius are worth a warning: Hertz' law is one of small
/// overlaps, and what is densely packed becomes too dense.
inline constexpr double kSoftOverlap = 0.05;

/// A deep overlap with when it was seen and the materials of the two, indices into the case.
struct DeepContact {
  LargestOverlap overlap;
  double time_s = 0.0;
  std::int32_t material = -1;  ///< of the sphere; -1 if it is gone
  std::int32_t partner = -1;   ///< of the other one; -1 if it is gone
};
DeepContact deep_contact(const scene::Case& scene, const LargestOverlap& overlap, Simulation& sim);
/// Who overlaps by how much, and the moduli with which it would be kSoftOverlap.
std::string soft_contact_text(const scene::Case& scene, const DeepContact& contact);

/// Lines for the log: what is simulated and by which law.
std::vector<std::string> head_of_log(const scene::Case& scene, Simulation& sim);

}  // namespace repose::dem

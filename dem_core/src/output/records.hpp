// What a simulation is at one time, in the records of a run.
#pragma once

#include <string>
#include <vector>

#include "repose/dem/simulation.hpp"
#include "repose/scene/run_records.hpp"

namespace repose::dem {

/// Masses in the order of scene::region_columns(); a body counts where its centre of mass is.
std::vector<double> region_masses(const scene::Case& scene, const std::vector<Body>& bodies);

scene::Snapshot snapshot_of(const scene::Case& scene, const std::string& stage, Simulation& sim);

/// Loads on the walls since the last reading, which this is.
scene::WallRow wall_row_of(Simulation& sim);

/// What the kinetic energy of particles at rest is compared with: sum(m) g d_mean, 0 without
/// particles.
double weight_scale_j(const scene::Case& scene, const std::vector<Body>& bodies);

/// Whether rain of this stage or of an earlier one is still to fall.
bool awaits_rain(const scene::Case& scene, const std::string& stage, const Simulation& sim);

/// Lines for the log: what is simulated and by which law.
std::vector<std::string> head_of_log(const scene::Case& scene, Simulation& sim);

}  // namespace repose::dem

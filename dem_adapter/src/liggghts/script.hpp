// The input script of LIGGGHTS for a case.
#pragma once

#include <string>
#include <vector>

#include "repose/scene/case.hpp"
#include "wall_bodies.hpp"

namespace repose::dem_adapter::liggghts {

/// Throws InputError naming what of the case LIGGGHTS, or this engine with it, cannot do.
void require_possible(const scene::Case& scene);

/// What follows from the particles that are there.
struct Particles {
  double time_step_s = 0.0;
  double smallest_radius_m = 0.0;
  double weight_scale_j = 0.0;  ///< sum(m) g times the mean diameter, for scene::AtRest
};

/// Reads particles.data and ID.stl of each body that is no plane. Says for each row of the time
/// series "@row STEP KINETIC_ENERGY_J CONTACTS MASS...", the masses in the order of
/// scene::region_columns(), and for the end of stage S, from 0, "@end S STEP REASON"; writes
/// stage_S.dump then, and frames.dump as often as the case wants snapshots.
std::string script_text(const scene::Case& scene, const std::vector<WallBody>& bodies,
                        const Particles& particles);

/// The box of LIGGGHTS: the domain, and in directions that are not periodic all triangles.
struct Box {
  scene::Vec3 lower = scene::Vec3::Zero(), upper = scene::Vec3::Zero();
};
Box box_of(const scene::Case& scene, const std::vector<WallBody>& bodies);

}  // namespace repose::dem_adapter::liggghts

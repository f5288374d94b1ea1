// Filling: layers of particles placed at random without overlap.
#pragma once

#include <vector>

#include "insertion/placement.hpp"

namespace repose::dem {

/// Particles of all layers of the case, at rest: random sequential addition, layer over layer,
/// largest first [Widom1966], without overlap with each other, with walls and with `present`. Sizes
/// come from RandomStream(seed, 2 * layer), places from RandomStream(seed, 2 * layer + 1). Throws
/// SimulationError with how much was placed.
std::vector<scene::Particle> place_fill(const scene::Case& scene, const Box& box,
                                        const ClearOfWalls& clear_of_walls, ClumpForms& forms,
                                        const std::vector<scene::Particle>& present);

}  // namespace repose::dem

// Filling: layers of spheres placed at random without overlap.
#pragma once

#include <vector>

#include "geometry/box.hpp"
#include "geometry/walls.hpp"

namespace repose::dem {

/// Diameters of one layer, largest class first; the mass of the layer is met to half of the
/// smallest sphere. Numbers come from RandomStream(seed, 2 * layer).
std::vector<double> draw_diameters(const scene::Layer& layer, double density_kg_m3,
                                   std::uint64_t seed, std::uint64_t layer_number);

/// Spheres of all layers of the case, at rest: random sequential addition, layer over layer,
/// largest first [Widom1966], without overlap with each other, with walls and with Case::particles.
/// Positions come from RandomStream(seed, 2 * layer + 1). Throws SimulationError with how much was
/// placed.
std::vector<scene::Particle> place_fill(const scene::Case& scene, const Box& box,
                                        const Walls& walls);

}  // namespace repose::dem

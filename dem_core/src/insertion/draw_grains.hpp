// Which particles a mixture of a given mass consists of.
#pragma once

#include <cstdint>
#include <vector>

#include "repose/base/random.hpp"
#include "repose/scene/case.hpp"

namespace repose::dem {

/// A particle to be placed.
struct Grain {
  std::int32_t kind = 0;  ///< index into the mixture
  double diameter = 0.0;  ///< of the sphere of its volume, m
  double mass = 0.0;
};

/// Diameters of one kind, largest class first; the mass is met to half of the smallest particle.
/// What rounding leaves of a class goes to the next smaller one; within a class, mass is uniform
/// over the diameter.
std::vector<double> draw_diameters(const scene::Sizes& sizes, double mass_kg, double density_kg_m3,
                                   RandomStream& random);

/// All particles of a mixture, kind by kind. Mass of a particle is density * pi d^3/6, whatever its
/// shape.
std::vector<Grain> draw_mixture(const scene::Case& scene, const std::vector<scene::Grains>& mixture,
                                double mass_kg, RandomStream& random);

}  // namespace repose::dem

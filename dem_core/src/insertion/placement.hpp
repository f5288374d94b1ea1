// A place for one particle among others.
#pragma once

#include <array>
#include <functional>

#include "insertion/occupied_space.hpp"
#include "particles/clump_forms.hpp"
#include "repose/base/random.hpp"

namespace repose::dem {

/// Whether a sphere at x touches no wall.
using ClearOfWalls = std::function<bool(const Vec3& x, double radius)>;

/// Where particles may be put: centres in [lower, upper]; along directions that are neither
/// periodic nor `free_axis`, all of their spheres too.
struct PlacingBox {
  Vec3 lower, upper;
  int free_axis = -1;  ///< 0, 1, 2 or none
};

/// Uniform over all orientations [Shoemake1992].
std::array<double, 4> random_orientation(RandomStream& random);

/// Tries up to `tries` random places and orientations until the particle overlaps nothing; sets
/// both and returns true, or returns false. `form` is null for a sphere.
bool find_place(const PlacingBox& where, const Box& box, const OccupiedSpace& occupied,
                const ClearOfWalls& clear_of_walls, const scene::ClumpForm* form, int tries,
                RandomStream& random, scene::Particle& particle);

/// Adds all spheres of a particle.
void occupy(const scene::Particle& particle, const scene::ClumpForm* form, const Box& box,
            OccupiedSpace& occupied);

}  // namespace repose::dem

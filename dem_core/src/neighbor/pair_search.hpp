// Which spheres are close to each other, whatever their sizes.
#pragma once

#include "geometry/box.hpp"
#include "neighbor/neighbor_lists.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// Pairs of different bodies, not both ghosts, closer than R_i + R_j + skin, by ascending (i, j).
/// Spheres are put on levels whose radii differ by up to a factor of two; each is sought on its own
/// level and on all coarser ones, so that a few large spheres cost the many small ones nothing
/// [Krijgsman2014].
NeighborList find_pairs(const Box& box, double skin, const Spheres& spheres);

}  // namespace repose::dem

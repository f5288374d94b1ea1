// The order of the spheres, which is that of every sum.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/box.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// Sets the keys of spheres to where they are now on the Morton curve of a fixed grid, 2^21 cells
/// over the longest side of the domain: the order of two spheres depends on these two alone.
void order_by_place(const Box& box, Spheres& spheres);

/// Spheres by key, ties by id: order[new index] = old index.
std::vector<std::int32_t> order_of(const Spheres& spheres);

/// Interleaves the low 21 bits of three numbers.
std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z);

}  // namespace repose::dem

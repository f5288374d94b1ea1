// The order of the spheres, which is that of every sum.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/box.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// Spheres along the Morton curve of their positions, ties by id: order[new index] = old index. The
/// curve is drawn on a fixed grid, 2^21 cells over the longest side of the domain: the order of two
/// spheres depends on these two alone.
std::vector<std::int32_t> morton_order(const Box& box, const Spheres& spheres);

/// Interleaves the low 21 bits of three numbers.
std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z);

}  // namespace repose::dem

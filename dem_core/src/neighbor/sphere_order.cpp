#include "neighbor/sphere_order.hpp"

#include <algorithm>

namespace repose::dem {
namespace {

constexpr double kCells = 2097152.0;  // 2^21

/// The low 21 bits of v, two zero bits between each.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffff;
  v = (v | v << 16) & 0x1f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

struct Placed {
  std::uint64_t key;
  std::int32_t id;
  std::int32_t index;
};

bool comes_before(const Placed& a, const Placed& b) {
  return a.key != b.key ? a.key < b.key : a.id < b.id;
}

}  // namespace

std::uint64_t morton_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

void order_by_place(const Box& box, Spheres& spheres) {
  const double width = (box.upper - box.lower).maxCoeff() / kCells;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    std::uint32_t at[3];
    for (int k = 0; k < 3; ++k) {
      // A sphere of a clump may reach beyond the domain.
      const double cell = (spheres.motion[i].x[k] - box.lower[k]) / width;
      at[k] = static_cast<std::uint32_t>(std::clamp(cell, 0.0, kCells - 1.0));
    }
    spheres.key[i] = morton_key(at[0], at[1], at[2]);
  }
}

std::vector<std::int32_t> order_of(const Spheres& spheres) {
  std::vector<Placed> placed;
  placed.reserve(spheres.size());
  for (std::size_t i = 0; i < spheres.size(); ++i)
    placed.push_back({spheres.key[i], spheres.id[i], static_cast<std::int32_t>(i)});
  std::sort(placed.begin(), placed.end(), comes_before);
  std::vector<std::int32_t> order;
  order.reserve(placed.size());
  for (const Placed& sphere : placed) order.push_back(sphere.index);
  return order;
}

}  // namespace repose::dem

#include "insertion/fill.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/text.hpp"

namespace repose::dem {
namespace {

constexpr int kTries = 200000;  // for one sphere

double sphere_mass(double diameter, double density) {
  return std::numbers::pi / 6.0 * diameter * diameter * diameter * density;
}

double sphere_diameter(double mass, double density) {
  return std::cbrt(6.0 * mass / (std::numbers::pi * density));
}

/// A diameter of a class whose mass is uniform over the diameter, so whose number goes with d^-3:
/// the inverse of its distribution function.
double draw_diameter(const scene::SizeClass& size, RandomStream& random) {
  if (size.lower_diameter_m == size.upper_diameter_m) return size.lower_diameter_m;
  const double a = 1.0 / (size.lower_diameter_m * size.lower_diameter_m);
  const double b = 1.0 / (size.upper_diameter_m * size.upper_diameter_m);
  return 1.0 / std::sqrt(a - random.uniform() * (a - b));
}

/// Spheres of one class until the wanted mass is met to half of the smallest; returns what is
/// missing (negative: too much).
double draw_class(const scene::SizeClass& size, double wanted, double density, RandomStream& random,
                  std::vector<double>& diameters) {
  const double smallest = sphere_mass(size.lower_diameter_m, density);
  const double largest = sphere_mass(size.upper_diameter_m, density);
  while (wanted >= 0.5 * smallest) {
    double diameter = draw_diameter(size, random);
    if (sphere_mass(diameter, density) > wanted)  // the last one makes up the rest
      diameter = std::clamp(sphere_diameter(std::clamp(wanted, smallest, largest), density),
                            size.lower_diameter_m, size.upper_diameter_m);
    diameters.push_back(diameter);
    wanted -= sphere_mass(diameter, density);
  }
  return wanted;
}

/// Spheres placed so far, in cells of one largest diameter, for a fast overlap test.
class Placed {
 public:
  Placed(const Box& box, const Vec3& lower, const Vec3& upper, double width) : box_(box) {
    for (int k = 0; k < 3; ++k) {
      origin_[k] = box.periodic[k] ? box.lower[k] : lower[k];
      const double extent = (box.periodic[k] ? box.upper[k] : upper[k]) - origin_[k];
      count_[k] = std::max(1, static_cast<int>(std::min(extent / width, 400.0)));
      width_[k] = extent / count_[k];
    }
    cells_.resize(static_cast<std::size_t>(count_[0]) * static_cast<std::size_t>(count_[1]) *
                  static_cast<std::size_t>(count_[2]));
  }

  void add(const Vec3& x, double radius) {
    int c[3];
    locate(x, c);
    cell(c).push_back({x, radius});
  }

  bool is_free(const Vec3& x, double radius) const {
    int c[3];
    locate(x, c);
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          int other[3] = {c[0] + dx, c[1] + dy, c[2] + dz};
          if (shift_inside(other) && overlaps(cell(other), x, radius)) return false;
        }
    return true;
  }

 private:
  struct Ball {
    Vec3 x;
    double radius;
  };

  void locate(const Vec3& x, int c[3]) const {
    for (int k = 0; k < 3; ++k)
      c[k] = std::clamp(static_cast<int>(std::floor((x[k] - origin_[k]) / width_[k])), 0,
                        count_[k] - 1);
  }
  bool shift_inside(int c[3]) const {
    for (int k = 0; k < 3; ++k) {
      if (box_.periodic[k]) c[k] = (c[k] + count_[k]) % count_[k];
      if (c[k] < 0 || c[k] >= count_[k]) return false;
    }
    return true;
  }
  std::size_t slot(const int c[3]) const {
    return static_cast<std::size_t>((c[2] * count_[1] + c[1]) * count_[0] + c[0]);
  }
  std::vector<Ball>& cell(const int c[3]) { return cells_[slot(c)]; }
  const std::vector<Ball>& cell(const int c[3]) const { return cells_[slot(c)]; }
  bool overlaps(const std::vector<Ball>& balls, const Vec3& x, double radius) const {
    for (const Ball& ball : balls) {
      const double reach = radius + ball.radius;
      if (box_.nearest_image(ball.x - x).squaredNorm() < reach * reach) return true;
    }
    return false;
  }

  const Box& box_;
  Vec3 origin_;
  Vec3 width_;
  int count_[3];
  std::vector<std::vector<Ball>> cells_;
};

/// Where the centres of one layer may be.
struct Slab {
  Vec3 lower, upper;
};

/// A uniform position of a centre in the slab, a radius off the sides that are not periodic.
Vec3 draw_position(const Slab& slab, const Box& box, double radius, RandomStream& random) {
  Vec3 x;
  for (int k = 0; k < 3; ++k) {
    const double margin = box.periodic[k] || k == 2 ? 0.0 : radius;
    x[k] = random.uniform(slab.lower[k] + margin, slab.upper[k] - margin);
  }
  return x;
}

[[noreturn]] void does_not_fit(const scene::Case& scene, std::size_t layer, std::size_t placed,
                               const std::vector<double>& diameters, double placed_mass) {
  const scene::Fill& fill = *scene.fill;
  throw SimulationError("fill.layer " + std::to_string(layer + 1) + " (" +
                        fill.layers[layer].mixture.front().material + "): placed " +
                        std::to_string(placed) + " of " + std::to_string(diameters.size()) +
                        " spheres, " + shortest(std::round(placed_mass * 1e6) / 1e6) + " of " +
                        shortest(fill.layers[layer].mass_kg) +
                        " kg; no room was found for one of diameter " +
                        shortest(diameters[placed]) +
                        " m; lower fill.solid_fraction = " + shortest(fill.solid_fraction) +
                        " (0.25 suits narrow columns), raise fill.upper_m.z to "
                        "match, or widen the column");
}

}  // namespace

std::vector<double> draw_diameters(const scene::Layer& layer, double density_kg_m3,
                                   std::uint64_t seed, std::uint64_t layer_number) {
  std::vector<scene::SizeClass> classes = scene::size_classes(layer.mixture.front().sizes);
  std::stable_sort(classes.begin(), classes.end(), [](const auto& a, const auto& b) {
    return a.lower_diameter_m > b.lower_diameter_m;
  });
  RandomStream random(seed, 2 * layer_number);
  std::vector<double> diameters;
  double missing = 0.0;
  for (const scene::SizeClass& size : classes)
    missing = draw_class(size, size.mass_fraction * layer.mass_kg + missing, density_kg_m3, random,
                         diameters);
  std::stable_sort(diameters.begin(), diameters.end(), std::greater<>());
  return diameters;
}

std::vector<scene::Particle> place_fill(const scene::Case& scene, const Box& box,
                                        const Walls& walls) {
  const scene::Fill& fill = *scene.fill;
  double largest = 0.0;
  for (const scene::Layer& layer : fill.layers)
    for (const scene::Grains& kind : layer.mixture)
      largest = std::max(largest, scene::largest_diameter_m(kind.sizes));
  double cell = largest;
  for (const scene::Particle& particle : scene.particles)
    cell = std::max(cell, 2.0 * particle.radius_m);
  Placed placed(box, fill.lower, fill.upper, cell);
  for (const scene::Particle& particle : scene.particles)
    placed.add(particle.position, particle.radius_m);

  std::vector<scene::Particle> spheres;
  Slab slab{fill.lower, fill.upper};
  slab.upper.z() = fill.lower.z() + 0.5 * largest;
  for (std::size_t l = 0; l < fill.layers.size(); ++l) {
    const scene::Layer& layer = fill.layers[l];
    const double density = scene
                               .materials[static_cast<std::size_t>(
                                   scene::material_index(scene, layer.mixture.front().material))]
                               .density_kg_m3;
    const Vec3 extent = fill.upper - fill.lower;
    slab.lower.z() = slab.upper.z();
    slab.upper.z() += layer.mass_kg / (density * extent.x() * extent.y() * fill.solid_fraction);
    const std::vector<double> diameters = draw_diameters(layer, density, scene.seed, l);
    RandomStream random(scene.seed, 2 * l + 1);
    double placed_mass = 0.0;
    for (std::size_t d = 0; d < diameters.size(); ++d) {
      const double radius = 0.5 * diameters[d];
      scene::Particle sphere;
      sphere.material = layer.mixture.front().material;
      sphere.radius_m = radius;
      bool found = false;
      for (int t = 0; t < kTries && !found; ++t) {
        sphere.position = draw_position(slab, box, radius, random);
        found = placed.is_free(sphere.position, radius) && walls.is_clear(sphere.position, radius);
      }
      if (!found) does_not_fit(scene, l, d, diameters, placed_mass);
      placed.add(sphere.position, radius);
      placed_mass += sphere_mass(diameters[d], density);
      spheres.push_back(sphere);
    }
  }
  return spheres;
}

}  // namespace repose::dem

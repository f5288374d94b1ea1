#include "insertion/fill.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "insertion/draw_grains.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem {
namespace {

constexpr int kTries = 200000;  // for one particle

std::string names_of(const scene::Layer& layer) {
  std::vector<std::string> names;
  for (const scene::Grains& kind : layer.mixture) names.push_back(kind.material);
  return listed(names);
}

[[noreturn]] void does_not_fit(const scene::Case& scene, std::size_t layer, std::size_t placed,
                               const std::vector<Grain>& grains, double placed_mass) {
  const scene::Fill& fill = *scene.fill;
  throw SimulationError(
      "fill.layer " + std::to_string(layer + 1) + " (" + names_of(fill.layers[layer]) +
      "): placed " + std::to_string(placed) + " of " + std::to_string(grains.size()) +
      " particles, " + shortest(std::round(placed_mass * 1e6) / 1e6) + " of " +
      shortest(fill.layers[layer].mass_kg) + " kg; no room was found for one of diameter " +
      shortest(grains[placed].diameter) +
      " m; lower fill.solid_fraction = " + shortest(fill.solid_fraction) +
      " (0.25 suits narrow columns and clumps), raise fill.upper_m.z to "
      "match, or widen the column");
}

/// Largest extents that occur in the fill.
struct Extents {
  double particle = 0.0;  ///< across the bounding sphere
  double sphere = 0.0;    ///< diameter of a sphere
};

Extents extents_of(const scene::Fill& fill, ClumpForms& forms) {
  Extents largest;
  for (const scene::Layer& layer : fill.layers)
    for (const scene::Grains& kind : layer.mixture) {
      const double diameter = scene::largest_diameter_m(kind.sizes);
      const scene::ClumpForm* form = forms.find(kind.clump);
      largest.particle =
          std::max(largest.particle, form == nullptr ? diameter : diameter * form->bounding_radius);
      largest.sphere = std::max(largest.sphere, diameter * ClumpForms::largest_sphere(form));
    }
  return largest;
}

}  // namespace

std::vector<scene::Particle> place_fill(const scene::Case& scene, const Box& box,
                                        const ClearOfWalls& clear_of_walls, ClumpForms& forms,
                                        const std::vector<scene::Particle>& present) {
  const scene::Fill& fill = *scene.fill;
  const Extents largest = extents_of(fill, forms);
  double cell = largest.sphere;
  for (const scene::Particle& particle : present)
    cell = std::max(
        cell, 2.0 * particle.radius_m * ClumpForms::largest_sphere(forms.find(particle.clump)));
  std::vector<std::vector<Grain>> grains_of;
  std::size_t count = present.size();
  for (std::size_t l = 0; l < fill.layers.size(); ++l) {
    const scene::Layer& layer = fill.layers[l];
    RandomStream sizes(scene.seed, 2 * l);
    grains_of.push_back(draw_mixture(scene, layer.mixture, layer.mass_kg, sizes));
    std::stable_sort(grains_of[l].begin(), grains_of[l].end(),
                     [](const Grain& a, const Grain& b) { return a.diameter > b.diameter; });
    count += grains_of[l].size();
  }
  OccupiedSpace occupied(box, fill.lower, fill.upper, cell, count);
  for (const scene::Particle& particle : present)
    occupy(particle, forms.find(particle.clump), box, occupied);

  std::vector<scene::Particle> particles;
  PlacingBox slab{fill.lower, fill.upper, 2};
  slab.upper.z() = fill.lower.z() + 0.5 * largest.particle;
  for (std::size_t l = 0; l < fill.layers.size(); ++l) {
    const scene::Layer& layer = fill.layers[l];
    const std::vector<Grain>& grains = grains_of[l];
    const Vec3 extent = fill.upper - fill.lower;
    slab.lower.z() = slab.upper.z();
    for (const scene::Grains& kind : layer.mixture) {
      const auto m = static_cast<std::size_t>(scene::material_index(scene, kind.material));
      slab.upper.z() +=
          layer.mass_kg * kind.mass_fraction /
          (scene.materials[m].density_kg_m3 * extent.x() * extent.y() * fill.solid_fraction);
    }
    RandomStream places(scene.seed, 2 * l + 1);
    double placed_mass = 0.0;
    for (std::size_t g = 0; g < grains.size(); ++g) {
      const scene::Grains& kind = layer.mixture[static_cast<std::size_t>(grains[g].kind)];
      const scene::ClumpForm* form = forms.find(kind.clump);
      scene::Particle particle;
      particle.material = kind.material;
      particle.clump = kind.clump;
      particle.radius_m = 0.5 * grains[g].diameter;
      if (!find_place(slab, box, occupied, clear_of_walls, form, kTries, places, particle))
        does_not_fit(scene, l, g, grains, placed_mass);
      occupy(particle, form, box, occupied);
      placed_mass += grains[g].mass;
      particles.push_back(particle);
    }
  }
  return particles;
}

}  // namespace repose::dem

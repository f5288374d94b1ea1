#include "insertion/draw_grains.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace repose::dem {
namespace {

double mass_of(double diameter, double density) {
  return std::numbers::pi / 6.0 * diameter * diameter * diameter * density;
}

double diameter_of(double mass, double density) {
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

/// Particles of one class until the wanted mass is met to half of the smallest; returns what is
/// missing (negative: too much).
double draw_class(const scene::SizeClass& size, double wanted, double density, RandomStream& random,
                  std::vector<double>& diameters) {
  const double smallest = mass_of(size.lower_diameter_m, density);
  const double largest = mass_of(size.upper_diameter_m, density);
  while (wanted >= 0.5 * smallest) {
    double diameter = draw_diameter(size, random);
    if (mass_of(diameter, density) > wanted)  // the last one makes up the rest
      diameter = std::clamp(diameter_of(std::clamp(wanted, smallest, largest), density),
                            size.lower_diameter_m, size.upper_diameter_m);
    diameters.push_back(diameter);
    wanted -= mass_of(diameter, density);
  }
  return wanted;
}

}  // namespace

std::vector<double> draw_diameters(const scene::Sizes& sizes, double mass_kg, double density_kg_m3,
                                   RandomStream& random) {
  std::vector<scene::SizeClass> classes = scene::size_classes(sizes);
  std::stable_sort(classes.begin(), classes.end(), [](const auto& a, const auto& b) {
    return a.lower_diameter_m > b.lower_diameter_m;
  });
  std::vector<double> diameters;
  double missing = 0.0;
  for (const scene::SizeClass& size : classes)
    missing =
        draw_class(size, size.mass_fraction * mass_kg + missing, density_kg_m3, random, diameters);
  std::stable_sort(diameters.begin(), diameters.end(), std::greater<>());
  return diameters;
}

std::vector<Grain> draw_mixture(const scene::Case& scene, const std::vector<scene::Grains>& mixture,
                                double mass_kg, RandomStream& random) {
  std::vector<Grain> grains;
  for (std::size_t k = 0; k < mixture.size(); ++k) {
    const auto material =
        static_cast<std::size_t>(scene::material_index(scene, mixture[k].material));
    const double density = scene.materials[material].density_kg_m3;
    for (double diameter :
         draw_diameters(mixture[k].sizes, mass_kg * mixture[k].mass_fraction, density, random))
      grains.push_back({static_cast<std::int32_t>(k), diameter, mass_of(diameter, density)});
  }
  return grains;
}

}  // namespace repose::dem

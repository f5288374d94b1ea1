// Materials and their pairs.
#include <algorithm>
#include <set>

#include "repose/base/error.hpp"
#include "validate/checks.hpp"

namespace repose::scene {
namespace {

void check_pairs(const Case& scene) {
  std::set<std::pair<int, int>> seen;
  std::set<std::string> columns;
  for (const PairCoefficients& pair : scene.pairs) {
    const std::string name = "pair [\"" + pair.first + "\", \"" + pair.second + "\"]: ";
    const int a = material_index(scene, pair.first);
    const int b = material_index(scene, pair.second);
    if (!seen.insert({std::min(a, b), std::max(a, b)}).second)
      throw InputError(name + "stands twice; order does not matter, keep one");
    if (!columns.insert(pair.first + "_" + pair.second).second)
      throw InputError(name + "another pair has the same columns \"..._" + pair.first + "_" +
                       pair.second + "\" in the output; rename a material");
    if (!(pair.restitution > 0.0 && pair.restitution <= 1.0))
      refuse(name + "restitution", pair.restitution, "must be in (0, 1]");
    require_non_negative(name + "mu_s", pair.mu_s);
    require_non_negative(name + "mu_r", pair.mu_r);
    require_non_negative(name + "rolling_damping", pair.rolling_damping);
    require_non_negative(name + "cohesion_energy_density_j_m3", pair.cohesion_energy_density_j_m3);
  }
}

}  // namespace

void check_materials(const Case& scene) {
  if (scene.materials.empty()) throw InputError("the case has no material; add [[material]]");
  require_unique_names("material", scene.materials);
  for (const Material& material : scene.materials) {
    const std::string name = "material \"" + material.name + "\": ";
    require_positive(name + "density_kg_m3", material.density_kg_m3);
    require_positive(name + "youngs_modulus_pa", material.youngs_modulus_pa);
    if (!(material.poissons_ratio > -1.0 && material.poissons_ratio <= 0.5))
      refuse(name + "poissons_ratio", material.poissons_ratio, "must be in (-1, 0.5]");
  }
  check_pairs(scene);
}

/// Each particle material with every particle and wall material.
void check_pairs_present(const Case& scene) {
  std::set<int> grains;
  const auto add = [&](const std::vector<Grains>& mixture) {
    for (const Grains& kind : mixture) grains.insert(material_index(scene, kind.material));
  };
  if (scene.fill)
    for (const Layer& layer : scene.fill->layers) add(layer.mixture);
  for (const Rain& rain : scene.rains) add(rain.mixture);
  for (const ParticleTable& table : scene.particle_tables)
    if (!table.material.empty()) grains.insert(material_index(scene, table.material));
  for (const Particle& particle : scene.particles)
    grains.insert(material_index(scene, particle.material));
  std::set<int> all = grains;
  for (const Wall& wall : scene.walls) all.insert(material_index(scene, wall.material));
  for (int a : grains)
    for (int b : all)
      if (pair_index(scene, a, b) < 0) {
        const auto name = [&](int m) { return scene.materials[static_cast<std::size_t>(m)].name; };
        throw InputError("pair [\"" + name(a) + "\", \"" + name(b) +
                         "\"] is missing; add a [[pair]] with restitution, mu_s and mu_r");
      }
}

}  // namespace repose::scene

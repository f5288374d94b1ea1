// What a case must satisfy before its first step.
#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/scene/case.hpp"

namespace repose::scene {
namespace {

const char* const kAxes[3] = {"x", "y", "z"};

/// quantity = value: what is wrong.
[[noreturn]] void refuse(const std::string& quantity, double value, const std::string& what) {
  throw InputError(quantity + " = " + shortest(value) + ": " + what);
}

void require_positive(const std::string& quantity, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) refuse(quantity, value, "must be above 0");
}

void require_non_negative(const std::string& quantity, double value) {
  if (!(value >= 0.0) || !std::isfinite(value)) refuse(quantity, value, "must be at least 0");
}

void require_finite(const std::string& quantity, const Vec3& value) {
  for (int k = 0; k < 3; ++k)
    if (!std::isfinite(value[k]))
      refuse(quantity + "." + kAxes[k], value[k], "must be a finite number");
}

template <class Items>
void require_unique_names(const char* kind, const Items& items) {
  std::set<std::string> names;
  for (const auto& item : items) {
    if (item.name.empty())
      throw InputError(std::string("a ") + kind + " has an empty name; give it one");
    if (!names.insert(item.name).second)
      throw InputError(std::string(kind) + " \"" + item.name +
                       "\" stands twice; names must differ");
  }
}

bool is_periodic(const Case& scene, int axis) {
  return axis == 0 ? scene.periodic.x : axis == 1 ? scene.periodic.y : scene.periodic.z;
}

void check_run(const Case& scene) {
  const double fraction = scene.time_step_rayleigh_fraction;
  require_positive("time_step_rayleigh_fraction", fraction);
  if (fraction > 0.5)
    refuse("time_step_rayleigh_fraction", fraction,
           "must be at most 0.5, else contacts are unstable; 0.1 to 0.3 is usual");
  if (scene.seed >= (1ULL << 63))
    throw InputError("seed = " + std::to_string(scene.seed) + ": must be below 2^63");
  require_finite("gravity_m_s2", scene.gravity_m_s2);
  require_finite("domain.lower_m", scene.lower_m);
  require_finite("domain.upper_m", scene.upper_m);
  for (int k = 0; k < 3; ++k)
    if (!(scene.upper_m[k] > scene.lower_m[k]))
      refuse(std::string("domain.upper_m.") + kAxes[k], scene.upper_m[k],
             "must be above domain.lower_m = " + shortest(scene.lower_m[k]));
  require_non_negative("output.snapshot_interval_s", scene.output.snapshot_interval_s);
  require_positive("output.series_interval_s", scene.output.series_interval_s);
}

void check_materials(const Case& scene) {
  require_unique_names("material", scene.materials);
  for (const Material& material : scene.materials) {
    const std::string name = "material \"" + material.name + "\": ";
    require_positive(name + "density_kg_m3", material.density_kg_m3);
    require_positive(name + "youngs_modulus_pa", material.youngs_modulus_pa);
    if (!(material.poissons_ratio > -1.0 && material.poissons_ratio <= 0.5))
      refuse(name + "poissons_ratio", material.poissons_ratio, "must be in (-1, 0.5]");
  }
}

void check_pairs(const Case& scene) {
  std::set<std::pair<int, int>> seen;
  for (const PairCoefficients& pair : scene.pairs) {
    const std::string name = "pair [\"" + pair.first + "\", \"" + pair.second + "\"]: ";
    const int a = material_index(scene, pair.first);
    const int b = material_index(scene, pair.second);
    if (!seen.insert({std::min(a, b), std::max(a, b)}).second)
      throw InputError(name + "stands twice; order does not matter, keep one");
    if (!(pair.restitution > 0.0 && pair.restitution <= 1.0))
      refuse(name + "restitution", pair.restitution, "must be in (0, 1]");
    require_non_negative(name + "mu_s", pair.mu_s);
    require_non_negative(name + "mu_r", pair.mu_r);
    require_non_negative(name + "rolling_damping", pair.rolling_damping);
  }
}

/// Each particle material with every particle and wall material.
void check_pairs_present(const Case& scene) {
  std::set<int> grains;
  std::set<int> all;
  if (scene.fill)
    for (const Layer& layer : scene.fill->layers)
      for (const Grains& kind : layer.mixture) grains.insert(material_index(scene, kind.material));
  for (const Particle& particle : scene.particles)
    grains.insert(material_index(scene, particle.material));
  all = grains;
  for (const Wall& wall : scene.walls) all.insert(material_index(scene, wall.material));
  for (int a : grains)
    for (int b : all)
      if (pair_index(scene, a, b) < 0) {
        const auto name = [&](int m) { return scene.materials[static_cast<std::size_t>(m)].name; };
        throw InputError("pair [\"" + name(a) + "\", \"" + name(b) +
                         "\"] is missing; add a [[pair]] with restitution, mu_s and mu_r");
      }
}

/// Along a periodic direction a wall must go on forever, as its images do.
void check_wall_periodic(const Case& scene, const Wall& wall, int axis) {
  const std::string name = "wall \"" + wall.name + "\": ";
  const Vec3 direction = Vec3::Unit(axis);
  if (const auto* plane = std::get_if<Plane>(&wall.shape)) {
    if (std::abs(plane->normal.normalized().dot(direction)) > 1e-9)
      throw InputError(name + "its normal has a component along the periodic direction " +
                       kAxes[axis] + "; planes must be parallel to it");
    return;
  }
  const auto& rectangle = std::get<Rectangle>(wall.shape);
  for (const Vec3& edge : {rectangle.edge_u, rectangle.edge_v}) {
    if (std::abs(edge[axis]) < (1.0 - 1e-9) * edge.norm()) continue;
    const double slack = 1e-9 * (scene.upper_m[axis] - scene.lower_m[axis]);
    const double lower = std::min(rectangle.origin[axis], rectangle.origin[axis] + edge[axis]);
    const double upper = std::max(rectangle.origin[axis], rectangle.origin[axis] + edge[axis]);
    if (lower <= scene.lower_m[axis] + slack && upper >= scene.upper_m[axis] - slack) return;
  }
  throw InputError(name + "must have an edge that spans the whole period from " +
                   shortest(scene.lower_m[axis]) + " to " + shortest(scene.upper_m[axis]) +
                   " m of direction " + kAxes[axis]);
}

void check_walls(const Case& scene) {
  require_unique_names("wall", scene.walls);
  for (const Wall& wall : scene.walls) {
    const std::string name = "wall \"" + wall.name + "\": ";
    material_index(scene, wall.material);
    if (const auto* plane = std::get_if<Plane>(&wall.shape)) {
      require_finite(name + "origin_m", plane->origin);
      require_finite(name + "normal", plane->normal);
      if (!(plane->normal.norm() > 0.0))
        throw InputError(name + "normal is zero; give the direction towards the particles");
    } else {
      const auto& rectangle = std::get<Rectangle>(wall.shape);
      require_finite(name + "origin_m", rectangle.origin);
      require_finite(name + "edge_u_m", rectangle.edge_u);
      require_finite(name + "edge_v_m", rectangle.edge_v);
      const double u = rectangle.edge_u.norm();
      const double v = rectangle.edge_v.norm();
      if (!(u > 0.0) || !(v > 0.0))
        throw InputError(name + "an edge has no length; give edge_u_m and edge_v_m");
      if (std::abs(rectangle.edge_u.dot(rectangle.edge_v)) > 1e-9 * u * v)
        throw InputError(name + "edge_u_m and edge_v_m must be perpendicular");
    }
    for (int k = 0; k < 3; ++k)
      if (is_periodic(scene, k)) check_wall_periodic(scene, wall, k);
  }
}

void check_diameter(const Case& scene, const std::string& name, double diameter) {
  for (int k = 0; k < 3; ++k) {
    const double length = scene.upper_m[k] - scene.lower_m[k];
    if (is_periodic(scene, k) && length < 2.0 * diameter)
      refuse(name + "diameter_m", diameter,
             std::string("the period ") + shortest(length) + " m of direction " + kAxes[k] +
                 " must be at least two of the largest diameters");
  }
}

void check_layer(const Case& scene, const Layer& layer, std::size_t number) {
  const std::string name = "fill.layer " + std::to_string(number + 1) + ": ";
  const Fill& fill = *scene.fill;
  require_positive(name + "mass_kg", layer.mass_kg);
  if (layer.mixture.empty()) throw InputError(name + "has no particles; give their material");
  const Grains& kind = layer.mixture.front();
  material_index(scene, kind.material);
  const std::vector<SizeClass> sizes = size_classes(kind.sizes);
  if (sizes.empty())
    throw InputError(name + "has no sizes; add sizes = [{diameter_m = ..., mass_fraction = 1}]");
  double sum = 0.0;
  for (const SizeClass& size : sizes) {
    require_positive(name + "lower_diameter_m", size.lower_diameter_m);
    require_positive(name + "upper_diameter_m", size.upper_diameter_m);
    require_positive(name + "mass_fraction", size.mass_fraction);
    if (size.upper_diameter_m < size.lower_diameter_m)
      refuse(name + "upper_diameter_m", size.upper_diameter_m,
             "must be at least lower_diameter_m = " + shortest(size.lower_diameter_m));
    check_diameter(scene, name, size.upper_diameter_m);
    for (int k = 0; k < 3; ++k)
      if (!is_periodic(scene, k) && fill.upper[k] - fill.lower[k] < size.upper_diameter_m)
        refuse(name + "upper_diameter_m", size.upper_diameter_m,
               std::string("the fill column is only ") + shortest(fill.upper[k] - fill.lower[k]) +
                   " m wide along " + kAxes[k]);
    sum += size.mass_fraction;
  }
  if (std::abs(sum - 1.0) > 1e-9) refuse(name + "sum of mass_fraction", sum, "must be 1");
}

/// The column of all layers at the wanted solid fraction.
void check_fill_height(const Case& scene) {
  const Fill& fill = *scene.fill;
  const Vec3 extent = fill.upper - fill.lower;
  double height = 0.0;
  double largest = 0.0;
  for (const Layer& layer : fill.layers) {
    for (const Grains& kind : layer.mixture) {
      const int m = material_index(scene, kind.material);
      const double density = scene.materials[static_cast<std::size_t>(m)].density_kg_m3;
      height += layer.mass_kg * kind.mass_fraction /
                (density * extent.x() * extent.y() * fill.solid_fraction);
      largest = std::max(largest, largest_diameter_m(kind.sizes));
    }
  }
  if (height + largest > extent.z())
    refuse("fill.upper_m.z", fill.upper.z(),
           "the column of all layers is " + shortest(height + largest) +
               " m high at this solid_fraction; raise fill.upper_m.z to " +
               shortest(fill.lower.z() + height + largest) +
               " or more, widen the column or pour less");
}

void check_fill(const Case& scene) {
  const Fill& fill = *scene.fill;
  require_finite("fill.lower_m", fill.lower);
  require_finite("fill.upper_m", fill.upper);
  require_positive("fill.solid_fraction", fill.solid_fraction);
  if (fill.solid_fraction > 0.36)
    refuse("fill.solid_fraction", fill.solid_fraction,
           "must be at most 0.36: spheres placed at random jam near 0.38");
  for (int k = 0; k < 3; ++k) {
    if (!(fill.upper[k] > fill.lower[k]))
      refuse(std::string("fill.upper_m.") + kAxes[k], fill.upper[k],
             "must be above fill.lower_m = " + shortest(fill.lower[k]));
    if (fill.lower[k] < scene.lower_m[k] || fill.upper[k] > scene.upper_m[k])
      throw InputError("fill from " + shortest(fill.lower[k]) + " to " + shortest(fill.upper[k]) +
                       " m along " + kAxes[k] + " reaches out of the domain; keep it within " +
                       shortest(scene.lower_m[k]) + " and " + shortest(scene.upper_m[k]));
  }
  if (fill.layers.empty()) throw InputError("fill has no layers; add [[fill.layer]]");
  for (std::size_t l = 0; l < fill.layers.size(); ++l) check_layer(scene, fill.layers[l], l);
  check_fill_height(scene);
}

void check_particles(const Case& scene) {
  for (std::size_t p = 0; p < scene.particles.size(); ++p) {
    const Particle& particle = scene.particles[p];
    const std::string name = "particle " + std::to_string(p + 1) + ": ";
    material_index(scene, particle.material);
    require_positive(name + "radius_m", particle.radius_m);
    require_finite(name + "position_m", particle.position);
    require_finite(name + "velocity_m_s", particle.velocity);
    require_finite(name + "angular_velocity_rad_s", particle.angular_velocity);
    check_diameter(scene, name, 2.0 * particle.radius_m);
    for (int k = 0; k < 3; ++k)
      if (particle.position[k] < scene.lower_m[k] || particle.position[k] >= scene.upper_m[k])
        refuse(name + "position_m." + kAxes[k], particle.position[k], "is outside the domain");
  }
  if (scene.particles.empty() && !scene.fill)
    throw InputError("the case has no particles; add [fill] or [[particle]]");
}

void check_regions(const Case& scene) {
  require_unique_names("region", scene.regions);
  for (const Region& region : scene.regions)
    for (int k = 0; k < 3; ++k)
      if (!(region.upper[k] > region.lower[k]))
        refuse("region \"" + region.name + "\": upper bound of " + kAxes[k], region.upper[k],
               "must be above its lower bound " + shortest(region.lower[k]));
}

void check_opens(const Case& scene, const Stage& stage, std::set<int>& opened) {
  std::vector<std::string> names;
  for (const Wall& wall : scene.walls) names.push_back(wall.name);
  for (const std::string& name : stage.opens) {
    const std::vector<int> walls = walls_named(scene, name);
    if (walls.empty())
      throw InputError("stage \"" + stage.name + "\": opens = \"" + name +
                       "\" is not a wall; the case has " +
                       (names.empty() ? std::string("none") : listed(names)));
    for (int wall : walls)
      if (!opened.insert(wall).second)
        throw InputError("stage \"" + stage.name + "\": opens = \"" + name +
                         "\" was taken away before; name it once");
  }
}

void check_stages(const Case& scene) {
  if (scene.stages.empty()) throw InputError("the case has no stage; add [[stage]]");
  require_unique_names("stage", scene.stages);
  std::set<int> opened;
  for (const Stage& stage : scene.stages) {
    const std::string name = "stage \"" + stage.name + "\": ";
    require_positive(name + "duration_s", stage.duration_s);
    require_non_negative(name + "minimum_s", stage.minimum_s);
    if (stage.minimum_s > stage.duration_s)
      refuse(name + "minimum_s", stage.minimum_s,
             "must be at most duration_s = " + shortest(stage.duration_s));
    check_opens(scene, stage, opened);
    if (stage.at_rest) {
      require_positive(name + "at_rest.kinetic_energy_ratio", stage.at_rest->kinetic_energy_ratio);
      require_positive(name + "at_rest.window_s", stage.at_rest->window_s);
      if (!(scene.gravity_m_s2.norm() > 0.0))
        throw InputError(name +
                         "at_rest compares with the weight, but gravity_m_s2 is zero; "
                         "take at_rest out");
    }
    if (stage.flow_ends) {
      const FlowEnds& ends = *stage.flow_ends;
      const bool known = std::any_of(scene.regions.begin(), scene.regions.end(),
                                     [&](const Region& r) { return r.name == ends.region; });
      if (!known)
        throw InputError(name + "flow_ends.region = \"" + ends.region +
                         "\" is not a region; add a [[region]] of this name");
      require_positive(name + "flow_ends.fraction", ends.fraction);
      require_positive(name + "flow_ends.window_s", ends.window_s);
    }
  }
}

}  // namespace

void validate(const Case& scene) {
  check_run(scene);
  if (scene.materials.empty()) throw InputError("the case has no material; add [[material]]");
  check_materials(scene);
  check_pairs(scene);
  check_walls(scene);
  if (scene.fill) check_fill(scene);
  check_particles(scene);
  check_pairs_present(scene);
  check_regions(scene);
  check_stages(scene);
}

}  // namespace repose::scene

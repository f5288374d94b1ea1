// How particles come in: fill, rain, tables and particles placed by hand.
#include <algorithm>
#include <cmath>
#include <map>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "repose/table/io.hpp"
#include "validate/checks.hpp"

namespace repose::scene {
namespace {

/// A box in which particles are placed takes the largest of them.
void check_room(const Case& scene, const std::string& what, const char* box, const Vec3& extent,
                double diameter) {
  for (int k = 0; k < 3; ++k)
    if (!is_periodic(scene, k) && extent[k] < diameter)
      refuse(what + "upper_diameter_m", diameter,
             std::string("the largest particle does not fit: ") + box + " is only " +
                 shortest(extent[k]) + " m wide along " + kAxes[k]);
}

/// Whether a point is inside the side of a cone, between its ends.
bool is_inside(const Cone& cone, const Vec3& point) {
  const Vec3 along = cone.end - cone.start;
  const double t = (point - cone.start).dot(along) / along.squaredNorm();
  if (t < 0.0 || t > 1.0) return false;
  const double radius = cone.start_radius_m + t * (cone.end_radius_m - cone.start_radius_m);
  return (point - cone.start - t * along).norm() < radius;
}

/// A cylinder or cone that holds the middle of the column must be wider than a particle.
void check_container(const Case& scene, const std::string& what, double diameter) {
  const Fill& fill = *scene.fill;
  for (const Wall& wall : scene.walls) {
    const auto* cone = std::get_if<Cone>(&wall.shape);
    if (cone == nullptr) continue;
    const double width = 2.0 * std::max(cone->start_radius_m, cone->end_radius_m);
    Vec3 middle = 0.5 * (fill.lower + fill.upper);
    bool holds = false;
    for (double z : {fill.lower.z(), middle.z(), fill.upper.z()}) {
      middle.z() = z;
      holds = holds || is_inside(*cone, middle);
    }
    if (holds && width < diameter)
      refuse(what + "upper_diameter_m", diameter,
             "the largest particle does not fit: wall \"" + wall.name + "\" around the fill is " +
                 shortest(width) + " m wide");
  }
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
    }
    largest = std::max(largest, largest_bounding_diameter_m(scene, layer.mixture));
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
  require_box(scene, "fill", fill.lower, fill.upper);
  require_positive("fill.solid_fraction", fill.solid_fraction);
  if (fill.solid_fraction > 0.36)
    refuse("fill.solid_fraction", fill.solid_fraction,
           "must be at most 0.36: spheres placed at random jam near 0.38");
  if (fill.layers.empty()) throw InputError("fill has no layers; add [[fill.layer]]");
  for (std::size_t l = 0; l < fill.layers.size(); ++l) {
    const std::string what = "fill.layer " + std::to_string(l + 1) + ": ";
    require_positive(what + "mass_kg", fill.layers[l].mass_kg);
    check_mixture(scene, what, fill.layers[l].mixture);
    const double largest = largest_bounding_diameter_m(scene, fill.layers[l].mixture);
    check_room(scene, what, "the fill column", fill.upper - fill.lower, largest);
    check_container(scene, what, largest);
  }
  check_fill_height(scene);
}

void check_rain(const Case& scene, const Rain& rain) {
  const std::string name = "rain \"" + rain.name + "\"";
  const std::string what = name + ": ";
  require_positive(what + "mass_kg", rain.mass_kg);
  require_positive(what + "mass_rate_kg_s", rain.mass_rate_kg_s);
  require_box(scene, name, rain.lower, rain.upper);
  require_finite(what + "velocity_m_s", rain.velocity);
  require_non_negative(what + "start_s", rain.start_s);
  check_mixture(scene, what, rain.mixture);
  check_room(scene, what, "its box", rain.upper - rain.lower,
             largest_bounding_diameter_m(scene, rain.mixture));
  const double time = longest_time_after_s(scene, what, rain.stage) - rain.start_s;
  const double needed = rain.mass_kg / rain.mass_rate_kg_s;
  if (time < needed)
    refuse(what + "mass_rate_kg_s", rain.mass_rate_kg_s,
           "the mass takes " + shortest(needed) + " s, but the stages leave " +
               shortest(std::max(0.0, time)) + " s; rain faster, less or earlier");
}

void check_particle_table(const Case& scene, const ParticleTable& particles) {
  const std::string what = "particle_table \"" + particles.location + "\": ";
  try {
    table::parse_location(particles.location);
  } catch (const InputError& error) {
    throw InputError(what + error.what());
  }
  if (!particles.material.empty()) material_index(scene, particles.material);
  require_clump(scene, what, particles.clump);
}

/// `ratio` is the bounding ratio of its clump.
void check_particle(const Case& scene, const Particle& particle, double ratio,
                    const std::string& what) {
  material_index(scene, particle.material);
  require_positive(what + "radius_m", particle.radius_m);
  require_finite(what + "position_m", particle.position);
  require_finite(what + "velocity_m_s", particle.velocity);
  require_finite(what + "angular_velocity_rad_s", particle.angular_velocity);
  double norm2 = 0.0;
  for (double q : particle.orientation_wxyz) norm2 += q * q;
  if (!(std::abs(norm2 - 1.0) <= 1e-6))
    refuse(what + "norm of orientation_wxyz", std::sqrt(norm2), "must be 1, a unit quaternion");
  check_diameter_in_periods(scene, what, 2.0 * particle.radius_m * ratio);
  for (int k = 0; k < 3; ++k)
    if (particle.position[k] < scene.lower_m[k] || particle.position[k] >= scene.upper_m[k])
      refuse(what + "position_m." + kAxes[k], particle.position[k], "is outside the domain");
}

void check_particles(const Case& scene) {
  std::map<std::string, double> ratios;  // a form takes a while, and there may be many particles
  for (std::size_t p = 0; p < scene.particles.size(); ++p) {
    const Particle& particle = scene.particles[p];
    const std::string what = "particle " + std::to_string(p + 1) + ": ";
    require_clump(scene, what, particle.clump);
    if (!ratios.contains(particle.clump))
      ratios[particle.clump] = bounding_ratio(scene, particle.clump);
    check_particle(scene, particle, ratios[particle.clump], what);
  }
}

}  // namespace

void check_insertion(const Case& scene) {
  if (scene.fill) check_fill(scene);
  require_unique_names("rain", scene.rains);
  for (const Rain& rain : scene.rains) check_rain(scene, rain);
  for (const ParticleTable& particles : scene.particle_tables)
    check_particle_table(scene, particles);
  check_particles(scene);
  if (!scene.fill && scene.rains.empty() && scene.particle_tables.empty() &&
      scene.particles.empty())
    throw InputError(
        "the case has no particles; add [fill], [[rain]], [[particle_table]] or [[particle]]");
}

}  // namespace repose::scene

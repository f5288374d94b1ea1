// What happens before the first step: particles, checks, the time step.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "insertion/fill.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "simulation_state.hpp"

namespace repose::dem {
namespace {

constexpr double kLargestStepOverRadius = 0.1;  // way of the fastest particle in one step

}  // namespace

ClearOfWalls Simulation::State::clear_of_walls() const {
  return [this](const Vec3& x, double radius) { return walls.is_clear(x, radius); };
}

/// A sphere, or a clump of several, with new ids.
std::int32_t Simulation::State::add(const scene::Particle& particle) {
  const int material = scene::material_index(scene, particle.material);
  const double density = scene.materials[static_cast<std::size_t>(material)].density_kg_m3;
  const double radius = particle.radius_m;
  const double mass = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius * density;
  const scene::ClumpForm* form = forms.find(particle.clump);
  const bool is_sphere = form == nullptr || form->spheres.size() == 1;
  const auto count = static_cast<std::int32_t>(is_sphere ? 1 : form->spheres.size());
  // Before spheres are shared out all processes hold all.
  const bool is_here = dt == 0.0 || domain.decomposition().owner_of(particle.position) ==
                                        domain.communicator().rank();
  if (is_here && is_sphere) {
    spheres.add({.motion = {particle.position, radius, particle.velocity, 1.0 / mass},
                 .spin = {particle.angular_velocity, 2.5 / (mass * radius * radius)},
                 .material = material,
                 .id = next_sphere,
                 .body = next_body,
                 .mass = mass});
  } else if (is_here) {
    add_clump(*form, particle, material, density, next_body, next_sphere, box, clumps, spheres);
  }
  next_sphere += count;
  spheres_present += count;
  ++ledger.inserted;
  ledger.inserted_kg += mass;
  return next_body++;
}

std::int32_t Simulation::State::check_and_add(const scene::Particle& particle) {
  if (dt > 0.0)
    throw InputError("a particle was added after the first step; add all before, or use rain");
  const double radius = particle.radius_m;
  const std::string name = "particle " + std::to_string(next_body) + ": ";
  if (!(radius > 0.0) || !std::isfinite(radius))
    throw InputError(name + "radius_m = " + shortest(radius) + ": must be above 0");
  if (!box.contains(particle.position))
    throw InputError(name + "position " + place_text(particle.position) + " is outside the domain");
  const scene::ClumpForm* form = forms.find(particle.clump);
  const double largest = form == nullptr ? radius : radius * form->bounding_radius;
  for (int k = 0; k < 3; ++k)
    if (box.periodic[k] && box.length[k] < 4.0 * largest)
      throw InputError(name + "diameter " + shortest(2.0 * largest) + " m: a period of " +
                       shortest(box.length[k]) + " m must hold two of it");
  return add(particle);
}

/// The particles of the case: those given one by one, those of tables, the fill; rain is prepared.
void Simulation::State::place_all() {
  std::vector<scene::Particle> present = scene.particles;
  for (const scene::ParticleTable& table : scene.particle_tables)
    for (const scene::Particle& particle : scene::load_particles(scene, table))
      present.push_back(particle);
  for (const scene::Particle& particle : present) check_and_add(particle);
  if (scene.fill)
    for (const scene::Particle& particle : place_fill(scene, box, clear_of_walls(), forms, present))
      check_and_add(particle);
  prepare_insertion();
}

/// Rain that is to come, regions that remove.
void Simulation::State::prepare_insertion() {
  for (std::size_t r = 0; r < scene.rains.size(); ++r) rains.emplace_back(scene, r, forms);
  for (const scene::Region& region : scene.regions)
    if (region.removes) sinks.push_back(region);
}

/// Fixes the time step, computes the first forces and puts velocities half a step back.
void Simulation::State::prepare() {
  if (dt > 0.0) return;
  if (spheres.size() == 0 && rains.empty())
    throw InputError("the simulation has no particles; add some");
  require_pairs();
  const double rayleigh = smallest_rayleigh_time_s();
  const double step = options.time_step_s > 0.0 ? options.time_step_s
                                                : scene.time_step_rayleigh_fraction * rayleigh;
  if (!(step <= 0.5 * rayleigh))
    throw InputError("time_step_s = " + shortest(step) +
                     ": must be at most half of the smallest "
                     "Rayleigh time, " +
                     shortest(0.5 * rayleigh) + " s");
  check_speed(step);
  least_radius = smallest_radius();
  skin = Skin(least_radius, options.skin_radii);
  if (!domain.is_alone()) domain.share_out(box, population());
  rebuild_lists();
  watch_speed();
  compute_forces(0.0);
  // Only now it is known what bodies cost.
  if (!domain.is_alone() && options.balance == Balance::by_cost) rebuild_lists();
  dt = step;
  kick_all(-0.5 * dt);
  domain.update_ghosts(spheres);
  walls.clear_loads();  // the forces at the start belong to no step
  wall_load_steps = 0;
  initial_j = stored_j() + sum_over_bodies(1, [this](const Body& body, std::span<double> numbers) {
                numbers[0] = mechanical_j(body);
              })[0];
  agree(0.0, false);
}

/// Each material of particles, present or to come, with every other and with all walls.
void Simulation::State::require_pairs() const {
  std::vector<bool> present(scene.materials.size(), false);
  for (std::int32_t m : spheres.material) present[static_cast<std::size_t>(m)] = true;
  for (const scene::Rain& rain : scene.rains)
    for (const scene::Grains& kind : rain.mixture)
      present[static_cast<std::size_t>(scene::material_index(scene, kind.material))] = true;
  for (std::size_t a = 0; a < present.size(); ++a) {
    if (!present[a]) continue;
    for (std::size_t b = 0; b <= a; ++b)
      if (present[b])
        laws.require(scene, static_cast<std::int32_t>(a), static_cast<std::int32_t>(b));
    for (std::size_t w = 0; w < walls.size(); ++w)
      laws.require(scene, static_cast<std::int32_t>(a), walls.at(w).material);
  }
}

/// Of the spheres that are present or will come.
double Simulation::State::smallest_rayleigh_time_s() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < spheres.size(); ++i)
    smallest = std::min(
        smallest, rayleigh_time_s(scene.materials[static_cast<std::size_t>(spheres.material[i])],
                                  spheres.motion[i].radius));
  for (const RainSource& source : rains)
    for (const RainSource::Smallest& of_kind : source.smallest_of_kinds()) {
      const auto m = static_cast<std::size_t>(scene::material_index(scene, of_kind.material));
      smallest = std::min(smallest, rayleigh_time_s(scene.materials[m], of_kind.radius));
    }
  return smallest;
}

double Simulation::State::smallest_radius() const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Motion& sphere : spheres.motion) smallest = std::min(smallest, sphere.radius);
  for (const RainSource& source : rains) smallest = std::min(smallest, source.smallest_radius());
  return smallest;
}

/// Nothing may jump over a good part of a particle within a step.
void Simulation::State::check_speed(double step) const {
  double fastest = 0.0;
  for (const Motion& sphere : spheres.motion) fastest = std::max(fastest, sphere.v.norm());
  for (const scene::Rain& rain : scene.rains) fastest = std::max(fastest, rain.velocity.norm());
  const double radius = smallest_radius();
  if (fastest * step <= kLargestStepOverRadius * radius) return;
  throw InputError("time step " + shortest(step) + " s: the fastest particle, " +
                   shortest(fastest) + " m/s, moves " + shortest(fastest * step) +
                   " m within a step; at most a tenth of the smallest radius, " +
                   shortest(kLargestStepOverRadius * radius) +
                   " m, is allowed: lower time_step_rayleigh_fraction or the speed");
}

}  // namespace repose::dem

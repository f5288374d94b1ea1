#include "repose/dem/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "contact/contact_forces.hpp"
#include "insertion/fill.hpp"
#include "particles/integration.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem {
namespace {

constexpr double kLargestOverlapRatio = 0.5;
constexpr double kLargestWallStep = 0.25;  // of the smallest radius, in one time step

std::string place_text(const Vec3& x) {
  const auto mm = [](double v) {
    return shortest(std::isfinite(v) ? std::round(v * 1e6) / 1e6 : v);
  };
  return "(" + mm(x.x()) + ", " + mm(x.y()) + ", " + mm(x.z()) + ") m";
}

}  // namespace

struct Simulation::State {
  State(const scene::Case& given, const SimulationOptions& chosen)
      : scene(given), options(chosen), box(given), walls(given), laws(given) {}

  scene::Case scene;
  SimulationOptions options;
  Box box;
  Walls walls;
  LawTable laws;
  Spheres spheres;
  NeighborLists lists;
  ContactPool pool;
  std::vector<TouchingPair> touching;
  DeepestOverlap deepest;  // since it was last taken
  WallContacts wall_contacts;
  std::int64_t wall_load_steps = 0;  // summed in the loads of walls
  double dt = 0.0;                   // 0 until prepared
  double skin = 0.0;
  std::int64_t steps = 0;
  std::int64_t rebuilds = 0;

  std::int32_t add(const scene::Particle& particle);
  void prepare();
  void one_step();
  void rebuild_lists();
  void compute_forces(double history_dt);
  double time_s() const { return static_cast<double>(steps) * dt; }
  void check_overlap(const DeepestOverlap& now) const;
  void check_wall_speed() const;
  [[noreturn]] void lost(std::size_t i) const;
  std::string speed_and_time(std::size_t i) const;
};

std::int32_t Simulation::State::add(const scene::Particle& particle) {
  if (dt > 0.0) throw InputError("a sphere was added after the first step; add all spheres before");
  const int material = scene::material_index(scene, particle.material);
  const double radius = particle.radius_m;
  const std::string name = "sphere " + std::to_string(spheres.size()) + ": ";
  if (!(radius > 0.0) || !std::isfinite(radius))
    throw InputError(name + "radius_m = " + shortest(radius) + ": must be above 0");
  if (!box.contains(particle.position))
    throw InputError(name + "position " + place_text(particle.position) + " is outside the domain");
  for (int k = 0; k < 3; ++k)
    if (box.periodic[k] && box.length[k] < 4.0 * radius)
      throw InputError(name + "diameter " + shortest(2.0 * radius) + " m: a period of " +
                       shortest(box.length[k]) + " m must hold two of it");
  const double density = scene.materials[static_cast<std::size_t>(material)].density_kg_m3;
  const double mass = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius * density;
  const auto id = static_cast<std::int32_t>(spheres.size());
  spheres.motion.push_back({particle.position, radius, particle.velocity, 1.0 / mass});
  spheres.spin.push_back({particle.angular_velocity, 2.5 / (mass * radius * radius)});
  spheres.load.push_back({Vec3::Zero(), Vec3::Zero()});
  spheres.x_listed.push_back(particle.position);
  spheres.material.push_back(material);
  spheres.id.push_back(id);
  spheres.mass.push_back(mass);
  return id;
}

/// Fixes the time step, computes the first forces and puts velocities half a step back.
void Simulation::State::prepare() {
  if (dt > 0.0) return;
  if (spheres.size() == 0) throw InputError("the simulation has no spheres; add some");
  double rayleigh = std::numeric_limits<double>::infinity();
  double smallest = std::numeric_limits<double>::infinity();
  std::vector<bool> present(scene.materials.size(), false);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const auto m = static_cast<std::size_t>(spheres.material[i]);
    const double radius = spheres.motion[i].radius;
    rayleigh = std::min(rayleigh, rayleigh_time_s(scene.materials[m], radius));
    smallest = std::min(smallest, radius);
    present[m] = true;
  }
  for (std::size_t a = 0; a < present.size(); ++a) {
    if (!present[a]) continue;
    for (std::size_t b = 0; b <= a; ++b)
      if (present[b])
        laws.require(scene, static_cast<std::int32_t>(a), static_cast<std::int32_t>(b));
    for (std::size_t w = 0; w < walls.size(); ++w)
      laws.require(scene, static_cast<std::int32_t>(a), walls.at(w).material);
  }
  const double step = options.time_step_s > 0.0 ? options.time_step_s
                                                : scene.time_step_rayleigh_fraction * rayleigh;
  if (!(step <= 0.5 * rayleigh))
    throw InputError("time_step_s = " + shortest(step) +
                     ": must be at most half of the smallest "
                     "Rayleigh time, " +
                     shortest(0.5 * rayleigh) + " s");
  skin = options.skin_radii * smallest;
  rebuild_lists();
  dt = step;
  compute_forces(0.0);
  kick(scene.gravity_m_s2, -0.5 * dt, spheres);
}

void Simulation::State::rebuild_lists() {
  rebuild(box, skin, walls, spheres, lists, pool, wall_contacts);
  walls.mark_listed();
  ++rebuilds;
}

void Simulation::State::compute_forces(double history_dt) {
  DeepestOverlap now;
  find_touching(box, spheres, lists.pairs, pool, touching);
  add_pair_forces(laws, history_dt, touching, spheres, pool, now);
  add_wall_forces(laws, history_dt, lists.walls, walls, spheres, wall_contacts, now);
  ++wall_load_steps;
  check_overlap(now);
  deepest.see(now.overlap, now.radius, now.sphere, now.other, now.is_wall);
}

void Simulation::State::one_step() {
  kick(scene.gravity_m_s2, dt, spheres);
  const DriftResult moved = drift(box, dt, spheres);
  ++steps;
  if (moved.out >= 0) lost(static_cast<std::size_t>(moved.out));
  walls.advance(time_s());
  check_wall_speed();
  const double moved_most = std::sqrt(moved.moved2);
  if (moved_most > 0.5 * skin || moved_most + walls.displacement() > skin) rebuild_lists();
  compute_forces(dt);
}

/// A wall that jumped over the centre of a sphere would push it on.
void Simulation::State::check_wall_speed() const {
  const double speed = walls.largest_speed();
  if (speed * dt <= kLargestWallStep * skin / options.skin_radii) return;
  throw SimulationError("a wall moves with " + shortest(speed) + " m/s at time " +
                        shortest(time_s()) +
                        " s, by more than a quarter of the smallest radius in a time step of " +
                        shortest(dt) + " s; lower time_step_rayleigh_fraction or its speed");
}

std::string Simulation::State::speed_and_time(std::size_t i) const {
  return "speed " + shortest(std::round(spheres.motion[i].v.norm() * 1e4) / 1e4) + " m/s, time " +
         shortest(time_s()) + " s";
}

void Simulation::State::lost(std::size_t i) const {
  const Vec3& x = spheres.motion[i].x;
  const std::string name = "sphere " + std::to_string(spheres.id[i]);
  if (!x.allFinite())
    throw SimulationError(name + " has the position " + place_text(x) + " at time " +
                          shortest(time_s()) +
                          " s; lower the time step (time_step_rayleigh_fraction)");
  throw SimulationError(name + " left the domain at " + place_text(x) + ", " + speed_and_time(i) +
                        "; close the gap in the walls, widen [domain] or lower the time step");
}

void Simulation::State::check_overlap(const DeepestOverlap& now) const {
  if (!(now.ratio() > kLargestOverlapRatio)) return;
  const auto i = static_cast<std::size_t>(now.sphere);
  const auto other = static_cast<std::size_t>(now.other);
  const std::string partner = now.is_wall ? "wall \"" + scene.walls[other].name + "\""
                                          : "sphere " + std::to_string(spheres.id[other]);
  throw SimulationError(
      "sphere " + std::to_string(spheres.id[i]) + " at " + place_text(spheres.motion[i].x) +
      " overlaps " + partner + " by " + shortest(std::round(100.0 * now.ratio())) +
      " % of the smaller radius, " + speed_and_time(i) +
      "; at most 50 % is allowed: raise youngs_modulus_pa or lower the time step");
}

Simulation::Simulation(const scene::Case& scene, const SimulationOptions& options)
    : state_(std::make_unique<State>(scene, options)) {
  for (const scene::Particle& particle : scene.particles) state_->add(particle);
  if (scene.fill)
    for (const scene::Particle& particle : place_fill(scene, state_->box, state_->walls))
      state_->add(particle);
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

std::int32_t Simulation::add_sphere(const scene::Particle& particle) {
  return state_->add(particle);
}

void Simulation::step(std::int64_t n) {
  state_->prepare();
  for (std::int64_t k = 0; k < n; ++k) state_->one_step();
}

void Simulation::open(const std::string& name) {
  const std::vector<int> found = scene::walls_named(state_->scene, name);
  if (found.empty()) throw InputError("wall \"" + name + "\" is not known; it cannot be opened");
  for (const int w : found) {
    state_->walls.open(static_cast<std::size_t>(w));
    state_->wall_contacts.end_with(w);
  }
}

void Simulation::begin_stage(const std::string& name) {
  const auto& stages = state_->scene.stages;
  const auto stage = std::find_if(stages.begin(), stages.end(),
                                  [&](const scene::Stage& s) { return s.name == name; });
  if (stage == stages.end()) throw InputError("stage \"" + name + "\" is not in the case");
  for (const std::string& wall : stage->opens) open(wall);
  state_->walls.begin_stage(name, time_s());
}

std::vector<WallLoad> Simulation::take_wall_loads() {
  std::vector<WallLoad> loads;
  const double steps = static_cast<double>(std::max<std::int64_t>(state_->wall_load_steps, 1));
  for (const WallLoadSum& sum : state_->walls.loads())
    loads.push_back({sum.force / steps, sum.torque / steps, sum.work});
  state_->walls.clear_loads();
  state_->wall_load_steps = 0;
  return loads;
}

std::vector<scene::WallPose> Simulation::wall_poses() const {
  std::vector<scene::WallPose> poses;
  for (std::size_t w = 0; w < state_->walls.size(); ++w) {
    const WallBody& wall = state_->walls.at(w);
    poses.push_back({wall.now.pose.turn, wall.now.pose.shift, !wall.present});
  }
  return poses;
}

std::int64_t Simulation::steps() const {
  return state_->steps;
}
double Simulation::time_s() const {
  return state_->time_s();
}
std::size_t Simulation::size() const {
  return state_->spheres.size();
}
std::int64_t Simulation::rebuilds() const {
  return state_->rebuilds;
}

double Simulation::time_step_s() {
  state_->prepare();
  return state_->dt;
}

double Simulation::mass_kg() const {
  double sum = 0.0;
  for (double mass : state_->spheres.mass) sum += mass;
  return sum;
}

std::vector<Sphere> Simulation::spheres() {
  state_->prepare();
  const Spheres& all = state_->spheres;
  const double half = 0.5 * state_->dt;
  std::vector<Sphere> out(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Motion& m = all.motion[i];
    Sphere& sphere = out[static_cast<std::size_t>(all.id[i])];
    sphere.id = all.id[i];
    sphere.material = all.material[i];
    sphere.radius_m = m.radius;
    sphere.mass_kg = all.mass[i];
    sphere.position = m.x;
    sphere.velocity = m.v + (all.load[i].force * m.inv_mass + state_->scene.gravity_m_s2) * half;
    sphere.angular_velocity = all.spin[i].w + all.load[i].torque * (all.spin[i].inv_inertia * half);
  }
  return out;
}

double Simulation::kinetic_energy_j() {
  double energy = 0.0;
  for (const Sphere& sphere : spheres())
    energy += 0.5 * sphere.mass_kg *
              (sphere.velocity.squaredNorm() +
               0.4 * sphere.radius_m * sphere.radius_m * sphere.angular_velocity.squaredNorm());
  return energy;
}

std::size_t Simulation::contacts() {
  state_->prepare();
  return state_->touching.size() + state_->wall_contacts.all.size();
}

double Simulation::take_largest_overlap_ratio() {
  state_->prepare();
  return std::exchange(state_->deepest, DeepestOverlap{}).ratio();
}

std::vector<std::pair<std::int32_t, std::int32_t>> Simulation::listed_pairs() {
  state_->prepare();
  const Spheres& all = state_->spheres;
  const NeighborList& list = state_->lists.pairs;
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::int32_t p = list.first[i]; p < list.first[i + 1]; ++p) {
      const auto j = static_cast<std::size_t>(list.entries[static_cast<std::size_t>(p)].other);
      pairs.push_back(std::minmax(all.id[i], all.id[j]));
    }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace repose::dem

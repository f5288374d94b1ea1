#include "repose/dem/simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "contact/contact_forces.hpp"
#include "geometry/cross.hpp"
#include "insertion/fill.hpp"
#include "insertion/rain.hpp"
#include "particles/integration.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem {
namespace {

constexpr double kLargestOverlapRatio = 0.5;
constexpr double kLargestStepOverRadius = 0.1;  // way of the fastest particle in one step
constexpr double kLargestWallStep = 0.25;       // of the smallest radius, in one time step
constexpr std::int64_t kStepsBetweenRain = 50;

std::string place_text(const Vec3& x) {
  const auto mm = [](double v) {
    return shortest(std::isfinite(v) ? std::round(v * 1e6) / 1e6 : v);
  };
  return "(" + mm(x.x()) + ", " + mm(x.y()) + ", " + mm(x.z()) + ") m";
}

}  // namespace

struct Simulation::State {
  State(const scene::Case& given, const SimulationOptions& chosen)
      : scene(given), options(chosen), box(given), walls(given), laws(given), forms(scene) {}

  scene::Case scene;
  SimulationOptions options;
  Box box;
  Walls walls;
  LawTable laws;
  ClumpForms forms;
  Spheres spheres;
  Clumps clumps;
  std::vector<RainSource> rains;
  std::vector<scene::Region> sinks;  // regions that remove what comes into them
  std::map<std::string, double> stage_start_s;
  NeighborLists lists;
  ContactPool pool;
  std::vector<TouchingPair> touching;
  DeepestOverlap deepest;  // since it was last taken
  WallContacts wall_contacts;
  std::int64_t wall_load_steps = 0;  // summed in the loads of walls
  scene::Ledger ledger;
  std::int32_t next_sphere = 0;  // ids
  std::int32_t next_body = 0;
  double dt = 0.0;  // 0 until prepared
  double skin = 0.0;
  std::int64_t steps = 0;
  std::int64_t rebuilds = 0;

  double time_s() const { return static_cast<double>(steps) * dt; }
  std::int32_t check_and_add(const scene::Particle& particle);
  std::int32_t add(const scene::Particle& particle);
  void place_all();
  void prepare();
  void require_pairs() const;
  double smallest_rayleigh_time_s() const;
  double smallest_radius() const;
  void check_speed(double step) const;
  void check_wall_speed() const;
  void one_step();
  void rebuild_lists();
  void compute_forces(double history_dt);
  void kick_all(double span);
  void let_rain_fall();
  double rain_time_s(const scene::Rain& rain) const;
  void remove_what_is_in_sinks();
  std::vector<std::int32_t> bodies_in_sinks() const;
  ClearOfWalls clear_of_walls() const;
  std::string overlap_text(const DeepestOverlap& now) const;
  [[noreturn]] void lost(std::size_t i) const;
  std::string name_of(std::size_t i) const;
  std::string speed_and_time(std::size_t i) const;
};

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
  if (form == nullptr || form->spheres.size() == 1) {
    spheres.add({.motion = {particle.position, radius, particle.velocity, 1.0 / mass},
                 .spin = {particle.angular_velocity, 2.5 / (mass * radius * radius)},
                 .material = material,
                 .id = next_sphere,
                 .body = next_body,
                 .mass = mass});
    ++next_sphere;
  } else {
    add_clump(*form, particle, material, density, next_body, next_sphere, box, clumps, spheres);
    next_sphere += static_cast<std::int32_t>(form->spheres.size());
  }
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
  const double largest = radius * ClumpForms::largest_sphere(forms.find(particle.clump));
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
  skin = options.skin_radii * smallest_radius();
  rebuild_lists();
  dt = step;
  compute_forces(0.0);
  if (deepest.ratio() > kLargestOverlapRatio)
    throw InputError("at the start " + overlap_text(deepest) +
                     "; move them apart, or the particle is larger than its container");
  kick_all(-0.5 * dt);
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
    for (const scene::Grains& kind : source.rain().mixture) {
      const auto m = static_cast<std::size_t>(scene::material_index(scene, kind.material));
      smallest = std::min(smallest, rayleigh_time_s(scene.materials[m], source.smallest_radius()));
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

void Simulation::State::rebuild_lists() {
  rebuild(box, skin, walls, spheres, clumps, lists, pool, wall_contacts);
  walls.mark_listed();
  ++rebuilds;
}

void Simulation::State::compute_forces(double history_dt) {
  DeepestOverlap now;
  find_touching(box, spheres, lists.pairs, pool, touching);
  add_pair_forces(laws, history_dt, touching, spheres, pool, now);
  add_wall_forces(laws, history_dt, lists.walls, walls, spheres, wall_contacts, now);
  ++wall_load_steps;
  gather_loads(spheres, clumps);
  deepest.see(now.overlap, now.radius, now.sphere, now.other, now.is_wall);
  if (steps > 0 && now.ratio() > kLargestOverlapRatio)
    throw SimulationError(overlap_text(now) + ", " +
                          speed_and_time(static_cast<std::size_t>(now.sphere)) +
                          "; raise youngs_modulus_pa or lower the time step");
}

void Simulation::State::kick_all(double span) {
  kick(scene.gravity_m_s2, span, spheres);
  kick(scene.gravity_m_s2, span, clumps);
}

double Simulation::State::rain_time_s(const scene::Rain& rain) const {
  if (rain.stage.empty()) return time_s() - rain.start_s;
  const auto begun = stage_start_s.find(rain.stage);
  return begun == stage_start_s.end() ? -1.0 : time_s() - begun->second - rain.start_s;
}

/// Velocities of new particles are meant at the present time and are put half a step back.
void Simulation::State::let_rain_fall() {
  for (RainSource& source : rains) {
    const double since = rain_time_s(source.rain());
    if (since < 0.0 || !source.is_due(since)) continue;
    double largest = source.largest_radius();
    for (const Motion& sphere : spheres.motion) largest = std::max(largest, sphere.radius);
    OccupiedSpace occupied(box, source.rain().lower, source.rain().upper, 2.0 * largest);
    for (const Motion& sphere : spheres.motion) occupied.add(sphere.x, sphere.radius);
    const std::vector<scene::Particle> fallen = source.fall(since, box, clear_of_walls(), occupied);
    for (scene::Particle particle : fallen) {
      particle.velocity -= 0.5 * dt * scene.gravity_m_s2;
      add(particle);
    }
    if (!fallen.empty()) rebuild_lists();
  }
}

/// Ids of the bodies whose centre is in a region that removes.
std::vector<std::int32_t> Simulation::State::bodies_in_sinks() const {
  std::vector<std::int32_t> bodies;
  const auto is_removed = [this](const Vec3& x) {
    return std::any_of(sinks.begin(), sinks.end(),
                       [&](const scene::Region& sink) { return scene::is_inside(sink, x); });
  };
  for (std::size_t i = 0; i < spheres.size(); ++i)
    if (spheres.member[i] < 0 && is_removed(spheres.motion[i].x)) bodies.push_back(spheres.body[i]);
  for (const Clump& clump : clumps.all)
    if (is_removed(clump.x)) bodies.push_back(clump.body);
  std::sort(bodies.begin(), bodies.end());
  return bodies;
}

void Simulation::State::remove_what_is_in_sinks() {
  const std::vector<std::int32_t> removed = bodies_in_sinks();
  if (removed.empty()) return;
  std::vector<std::int32_t> kept;
  std::vector<std::int32_t> new_index(spheres.size(), -1);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    if (std::binary_search(removed.begin(), removed.end(), spheres.body[i])) {
      ledger.removed_kg += spheres.mass[i];
      continue;
    }
    new_index[i] = static_cast<std::int32_t>(kept.size());
    kept.push_back(static_cast<std::int32_t>(i));
  }
  ledger.removed += static_cast<std::int64_t>(removed.size());
  remove_spheres(new_index, lists, pool, wall_contacts);
  spheres.select(kept);
  remove_clumps(new_index, spheres, clumps);
}

void Simulation::State::one_step() {
  kick_all(dt);
  const DriftResult of_spheres = drift(box, dt, spheres);
  const DriftResult of_clumps = drift(box, dt, clumps, spheres);
  ++steps;
  if (of_spheres.out >= 0) lost(static_cast<std::size_t>(of_spheres.out));
  if (of_clumps.out >= 0) lost(static_cast<std::size_t>(of_clumps.out));
  if (!sinks.empty()) remove_what_is_in_sinks();
  walls.advance(time_s());
  check_wall_speed();
  const double moved = std::sqrt(std::max(of_spheres.moved2, of_clumps.moved2));
  if (moved > 0.5 * skin || moved + walls.displacement() > skin) rebuild_lists();
  if (!rains.empty() && steps % kStepsBetweenRain == 0) let_rain_fall();
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

std::string Simulation::State::name_of(std::size_t i) const {
  const std::string sphere = "sphere " + std::to_string(spheres.id[i]);
  if (spheres.member[i] < 0) return sphere;
  return sphere + " of clump " + std::to_string(spheres.body[i]);
}

std::string Simulation::State::speed_and_time(std::size_t i) const {
  return "speed " + shortest(std::round(spheres.motion[i].v.norm() * 1e4) / 1e4) + " m/s, time " +
         shortest(static_cast<double>(steps) * dt) + " s";
}

void Simulation::State::lost(std::size_t i) const {
  const Vec3& x = spheres.motion[i].x;
  const std::string name = name_of(i);
  if (!x.allFinite())
    throw SimulationError(name + " has the position " + place_text(x) + " at time " +
                          shortest(static_cast<double>(steps) * dt) +
                          " s; lower the time step (time_step_rayleigh_fraction)");
  throw SimulationError(name + " left the domain at " + place_text(x) + ", " + speed_and_time(i) +
                        "; close the gap in the walls, widen [domain] or lower the time step");
}

std::string Simulation::State::overlap_text(const DeepestOverlap& now) const {
  const auto i = static_cast<std::size_t>(now.sphere);
  const auto other = static_cast<std::size_t>(now.other);
  const std::string partner =
      now.is_wall ? "wall \"" + scene.walls[other].name + "\"" : name_of(other);
  return name_of(i) + " at " + place_text(spheres.motion[i].x) + " overlaps " + partner + " by " +
         shortest(std::round(100.0 * now.ratio())) +
         " % of the smaller radius; at most 50 % is allowed";
}

Simulation::Simulation(const scene::Case& scene, const SimulationOptions& options)
    : state_(std::make_unique<State>(scene, options)) {
  state_->place_all();
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;
Simulation& Simulation::operator=(Simulation&&) noexcept = default;

std::int32_t Simulation::add_particle(const scene::Particle& particle) {
  return state_->check_and_add(particle);
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
  state_->stage_start_s[name] = time_s();
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

scene::Ledger Simulation::ledger() const {
  scene::Ledger ledger = state_->ledger;
  ledger.alive = static_cast<std::int64_t>(state_->clumps.size());
  for (std::int32_t member : state_->spheres.member) ledger.alive += member < 0 ? 1 : 0;
  ledger.alive_kg = mass_kg();
  REPOSE_ASSERT(ledger.inserted == ledger.alive + ledger.removed,
                std::to_string(ledger.inserted) + " inserted, " + std::to_string(ledger.alive) +
                    " alive, " + std::to_string(ledger.removed) + " removed");
  return ledger;
}

double Simulation::outstanding_rain_kg() const {
  double sum = 0.0;
  for (const RainSource& source : state_->rains)
    if (!source.is_finished()) sum += source.rain().mass_kg - source.placed_kg();
  return sum;
}

std::vector<Body> Simulation::bodies() {
  state_->prepare();
  const Spheres& all = state_->spheres;
  const Vec3& gravity = state_->scene.gravity_m_s2;
  const double half = 0.5 * state_->dt;
  std::vector<Body> out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all.member[i] >= 0) continue;
    const Motion& m = all.motion[i];
    Body body;
    body.id = all.body[i];
    body.material = all.material[i];
    body.radius_m = m.radius;
    body.mass_kg = all.mass[i];
    body.inertia_kg_m2.setConstant(1.0 / all.spin[i].inv_inertia);
    body.position = m.x;
    body.velocity = m.v + (all.load[i].force * m.inv_mass + gravity) * half;
    body.angular_velocity = all.spin[i].w + all.load[i].torque * (all.spin[i].inv_inertia * half);
    out.push_back(body);
  }
  for (const Clump& clump : state_->clumps.all) {
    Body body;
    body.id = clump.body;
    body.material = clump.material;
    body.spheres = clump.count;
    body.radius_m = clump.radius;
    body.mass_kg = clump.mass;
    body.inertia_kg_m2 = clump.inertia;
    body.position = clump.x;
    body.velocity = clump.v + (clump.force * (1.0 / clump.mass) + gravity) * half;
    body.angular_velocity = clump.angular_velocity(clump.l + clump.torque * half);
    body.orientation_wxyz = {clump.q.w, clump.q.x, clump.q.y, clump.q.z};
    out.push_back(body);
  }
  std::sort(out.begin(), out.end(), [](const Body& a, const Body& b) { return a.id < b.id; });
  return out;
}

std::vector<Sphere> Simulation::spheres() {
  const std::vector<Body> bodies = this->bodies();
  const Spheres& all = state_->spheres;
  std::vector<Sphere> out;
  out.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Body& body =
        *std::lower_bound(bodies.begin(), bodies.end(), all.body[i],
                          [](const Body& candidate, std::int32_t id) { return candidate.id < id; });
    Sphere sphere;
    sphere.id = all.id[i];
    sphere.body = all.body[i];
    sphere.material = all.material[i];
    sphere.radius_m = all.motion[i].radius;
    sphere.mass_kg = all.mass[i];
    sphere.position = all.motion[i].x;
    sphere.velocity = body.velocity;
    if (all.member[i] >= 0)
      sphere.velocity += cross(body.angular_velocity,
                               state_->clumps.members[static_cast<std::size_t>(all.member[i])].arm);
    sphere.angular_velocity = body.angular_velocity;
    out.push_back(sphere);
  }
  std::sort(out.begin(), out.end(), [](const Sphere& a, const Sphere& b) { return a.id < b.id; });
  return out;
}

double Body::kinetic_energy_j() const {
  return 0.5 * mass_kg * velocity.squaredNorm() + 0.5 * angular_velocity.dot(angular_momentum());
}

Vec3 Body::angular_momentum() const {
  const Eigen::Matrix3d turn = rotation_matrix(quaternion_of(orientation_wxyz));
  return turn * inertia_kg_m2.cwiseProduct(turn.transpose() * angular_velocity);
}

double Simulation::kinetic_energy_j() {
  double energy = 0.0;
  for (const Body& body : bodies()) energy += body.kinetic_energy_j();
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

// One time step.
#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "simulation_state.hpp"

namespace repose::dem {
namespace {

constexpr double kLargestWallStep = 0.25;  // of the smallest radius, in one time step
constexpr std::int64_t kStepsBetweenRain = 50;
constexpr std::int64_t kStepsBetweenSorts = 1000;
constexpr std::int64_t kStepsBetweenLooks = 64;  // at speeds

}  // namespace

std::string place_text(const Vec3& x) {
  const auto mm = [](double v) {
    return shortest(std::isfinite(v) ? std::round(v * 1e6) / 1e6 : v);
  };
  return "(" + mm(x.x()) + ", " + mm(x.y()) + ", " + mm(x.z()) + ") m";
}

void Simulation::State::rebuild_lists(Order order) {
  rebuild(box, skin.width(), order, walls, spheres, clumps, lists, pool, wall_contacts);
  walls.mark_listed();
  listed_step = steps;
  ++rebuilds;
}

void Simulation::State::keep_lists_valid(double moved) {
  const double worn = std::max(moved, 0.5 * (moved + walls.displacement()));
  const bool sorts = steps % kStepsBetweenSorts == 0;
  if (!sorts && worn <= 0.5 * skin.width()) return;
  skin.adapt(worn, steps - listed_step);
  rebuild_lists(sorts ? Order::sorted : Order::kept);
}

void Simulation::State::compute_forces(double history_dt) {
  DeepestOverlap now;
  ContactEnergies sum;
  ContactEnergies* const energies = scene.output.energy ? &sum : nullptr;
  add_pair_forces(box, laws, history_dt, spheres, lists.pairs, pool, now, energies);
  add_wall_forces(laws, history_dt, lists.walls, walls, spheres, wall_contacts, now, energies);
  if (scene.output.energy) count_dissipation(sum, history_dt);
  ++wall_load_steps;
  gather_loads(spheres, clumps);
  watch_overlap(now);
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
    OccupiedSpace occupied(box, source.rain().lower, source.rain().upper, 2.0 * largest,
                           spheres.size());
    for (const Motion& sphere : spheres.motion) occupied.add(sphere.x, sphere.radius);
    const std::vector<scene::Particle> fallen = source.fall(since, box, clear_of_walls(), occupied);
    for (scene::Particle particle : fallen) {
      const double before_kg = ledger.inserted_kg;
      const Vec3 velocity = particle.velocity;
      particle.velocity -= 0.5 * dt * scene.gravity_m_s2;
      add(particle);
      counted.inserted_j +=
          (ledger.inserted_kg - before_kg) *
          (0.5 * velocity.squaredNorm() - scene.gravity_m_s2.dot(particle.position));
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
  if (scene.output.energy)
    for (const Body& body : bodies())
      if (std::binary_search(removed.begin(), removed.end(), body.id))
        counted.removed_j += mechanical_j(body);
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
  kick(scene.gravity_m_s2, dt, clumps);
  const DriftResult of_spheres = kick_and_drift(box, scene.gravity_m_s2, dt, spheres);
  const DriftResult of_clumps = drift(box, dt, clumps, spheres);
  ++steps;
  if (of_spheres.out >= 0) lost(static_cast<std::size_t>(of_spheres.out));
  if (of_clumps.out >= 0) lost(static_cast<std::size_t>(of_clumps.out));
  if (!sinks.empty()) remove_what_is_in_sinks();
  wrapped_kg_m += of_spheres.moved_kg_m + of_clumps.moved_kg_m;
  walls.advance(time_s(), dt);
  check_wall_speed();
  const double moved = std::sqrt(std::max(of_spheres.moved2, of_clumps.moved2));
  check_displacement(moved);
  keep_lists_valid(moved);
  if (!rains.empty() && steps % kStepsBetweenRain == 0) let_rain_fall();
  compute_forces(dt);
  if (steps % kStepsBetweenLooks == 0) watch_speed();
}

/// Lists are rebuilt before a sphere has moved by half the skin, so that more than that and a
/// radius can only come from one step in which it jumped.
void Simulation::State::check_displacement(double moved) const {
  if (moved <= 0.5 * skin.width() + least_radius) return;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    if (box.nearest_image(spheres.motion[i].x - spheres.x_listed[i]).norm() >= moved)
      throw SimulationError(name_of(i) + " at " + place_text(spheres.motion[i].x) +
                            " moved by more than the smallest radius in one time step, " +
                            speed_and_time(i) +
                            "; lower the time step (time_step_rayleigh_fraction) or the speed");
}

/// A wall that jumped over the centre of a sphere would push it on.
void Simulation::State::check_wall_speed() const {
  const Walls::LargestStep moved = walls.largest_step();
  const double allowed = kLargestWallStep * least_radius;
  if (moved.distance <= allowed) return;
  throw SimulationError("wall \"" + scene.walls[moved.wall].name + "\" moved by " +
                        shortest(moved.distance) + " m in the time step before " +
                        shortest(time_s()) + " s; at most a quarter of the smallest radius, " +
                        shortest(allowed) +
                        " m, is allowed: move it more slowly or lower "
                        "time_step_rayleigh_fraction");
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
  Vec3 x = spheres.motion[i].x;
  std::string name = name_of(i);
  for (const Clump& clump : clumps.all)
    if (spheres.member[i] >= 0 && clump.body == spheres.body[i]) {
      x = clump.x;  // a clump is where its centre is
      name = "clump " + std::to_string(clump.body);
    }
  if (!x.allFinite())
    throw SimulationError(name + " has the position " + place_text(x) + " at time " +
                          shortest(static_cast<double>(steps) * dt) +
                          " s; lower the time step (time_step_rayleigh_fraction)");
  throw SimulationError(name + " left the domain at " + place_text(x) + ", " + speed_and_time(i) +
                        "; close the gap in the walls, widen [domain] or lower the time step");
}

}  // namespace repose::dem

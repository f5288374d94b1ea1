// One time step.
#include <algorithm>
#include <cmath>

#include "neighbor/sphere_order.hpp"
#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "simulation_state.hpp"

namespace repose::dem {
namespace {

constexpr double kLargestWallStep = 0.25;  // of the smallest radius, in one time step
constexpr std::int64_t kStepsBetweenRain = 50;
constexpr std::int64_t kStepsBetweenSorts = 1000;
constexpr std::int64_t kStepsBetweenLooks = 64;  // at speeds
constexpr double kWorstImbalance = 1.05;         // of costs, at a sorting

}  // namespace

std::string place_text(const Vec3& x) {
  const auto mm = [](double v) {
    return shortest(std::isfinite(v) ? std::round(v * 1e6) / 1e6 : v);
  };
  return "(" + mm(x.x()) + ", " + mm(x.y()) + ", " + mm(x.z()) + ") m";
}

void Simulation::State::rebuild_lists(Order order) {
  std::vector<std::int32_t> new_index;
  std::vector<ArrivedContact> arrived;
  if (order == Order::sorted) order_by_place(box, spheres);
  if (!domain.is_alone()) {
    if (order == Order::sorted && options.balance == Balance::by_cost)
      domain.balance(box, population(), dt > 0.0 ? kWorstImbalance : 1.0);
    Domain::Exchanged exchanged = domain.exchange(box, skin.width(), population());
    new_index = std::move(exchanged.new_index);
    arrived = std::move(exchanged.arrived);
  } else if (order == Order::sorted) {
    new_index = sort_spheres(spheres, clumps, wall_contacts);
  }
  rebuild(box, skin.width(), walls, new_index, spheres, lists, pool);
  begin_contacts(arrived, lists.pairs, pool);
  walls.mark_listed();
  listed_step = steps;
  ++rebuilds;
}

/// Whether the lists were built anew, and ghosts with them.
bool Simulation::State::keep_lists_valid(double moved) {
  const double worn = std::max(moved, 0.5 * (moved + walls.displacement()));
  const bool sorts = steps % kStepsBetweenSorts == 0;
  if (!sorts && worn <= 0.5 * skin.width()) return false;
  skin.adapt(worn, steps - listed_step);
  rebuild_lists(sorts ? Order::sorted : Order::kept);
  return true;
}

void Simulation::State::compute_forces(double history_dt) {
  DeepestOverlap now;
  ExactEnergies sum;
  ExactEnergies* const asked = scene.output.energy ? &sum : nullptr;
  add_pair_forces(box, laws, history_dt, spheres, lists.pairs, pool, now, asked);
  add_wall_forces(laws, history_dt, lists.walls, walls, spheres, wall_contacts, now, asked);
  if (scene.output.energy) count_dissipation(sum, history_dt);
  ++wall_load_steps;
  gather_loads(spheres, clumps);
  attempt([&] { watch_overlap(now); });
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

/// Enters the spheres of all processes that may be in the way of a rain.
void Simulation::State::occupy(const scene::Rain& rain, double largest, OccupiedSpace& occupied) {
  struct Ball {
    double x, y, z, radius;
  };
  const Vec3 middle = 0.5 * (rain.lower + rain.upper);
  Vec3 reach = 0.5 * (rain.upper - rain.lower) + Vec3::Constant(4.0 * largest);
  for (int k = 0; k < 3; ++k)  // a clump may reach out of the box through a periodic side
    if (box.periodic[k]) reach[k] = box.length[k];
  std::vector<Ball> near;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Vec3& x = spheres.motion[i].x;
    if (spheres.is_ghost(i) ||
        (box.nearest_image(x - middle).cwiseAbs().array() > reach.array()).any())
      continue;
    near.push_back({x.x(), x.y(), x.z(), spheres.motion[i].radius});
  }
  Packer mine;
  mine.put_all(near);
  for (const Bytes& bytes : domain.communicator().gather_to_all(mine.take()))
    for (const Ball& ball : Unpacker(bytes).get_all<Ball>())
      occupied.add({ball.x, ball.y, ball.z}, ball.radius);
}

/// Velocities of new particles are meant at the present time and are put half a step back.
void Simulation::State::let_rain_fall() {
  for (RainSource& source : rains) {
    const double since = rain_time_s(source.rain());
    if (since < 0.0 || !source.is_due(since)) continue;
    double largest[1] = {source.largest_radius()};
    for (const Motion& sphere : spheres.motion) largest[0] = std::max(largest[0], sphere.radius);
    domain.communicator().maximize(largest);
    OccupiedSpace occupied(box, source.rain().lower, source.rain().upper, 2.0 * largest[0],
                           static_cast<std::size_t>(spheres_present));
    occupy(source.rain(), largest[0], occupied);
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
    if (spheres.is_alone(i) && is_removed(spheres.motion[i].x)) bodies.push_back(spheres.body[i]);
  for (const Clump& clump : clumps.all)
    if (is_removed(clump.x)) bodies.push_back(clump.body);
  std::sort(bodies.begin(), bodies.end());
  return bodies;
}

/// Takes these bodies of this process, and those of the others, out of all processes.
void Simulation::State::remove_from_all(const std::vector<std::int32_t>& here) {
  struct Removed {
    std::int32_t body;
    double mass_kg, mechanical_j;
    bool operator<(const Removed& other) const { return body < other.body; }
  };
  const auto is_here = [&](std::int32_t body) {
    return std::binary_search(here.begin(), here.end(), body);
  };
  std::vector<Removed> mine;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    if (spheres.is_alone(i) && is_here(spheres.body[i]))
      mine.push_back({spheres.body[i], spheres.mass[i], 0.0});
  for (const Clump& clump : clumps.all)
    if (is_here(clump.body)) mine.push_back({clump.body, clump.mass, 0.0});
  std::sort(mine.begin(), mine.end());
  if (scene.output.energy)
    for (const Body& body : bodies_of(spheres, clumps, scene.gravity_m_s2, 0.5 * dt))
      if (is_here(body.id))
        std::lower_bound(mine.begin(), mine.end(), Removed{body.id, 0.0, 0.0})->mechanical_j =
            mechanical_j(body);
  Packer packer;
  packer.put_all(mine);
  std::vector<Removed> all;
  for (const Bytes& bytes : domain.communicator().gather_to_all(packer.take()))
    for (const Removed& removed : Unpacker(bytes).get_all<Removed>()) all.push_back(removed);
  std::sort(all.begin(), all.end());
  std::vector<std::int32_t> bodies;
  for (const Removed& removed : all) {
    bodies.push_back(removed.body);
    ledger.removed_kg += removed.mass_kg;
    counted.removed_j += removed.mechanical_j;
  }
  ledger.removed += static_cast<std::int64_t>(all.size());
  remove(bodies);
}

/// Takes these bodies out, ghosts too.
void Simulation::State::remove(const std::vector<std::int32_t>& bodies) {
  std::vector<std::int32_t> kept;
  std::vector<std::int32_t> new_index(spheres.size(), -1);
  std::int64_t removed[1] = {0};
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    if (std::binary_search(bodies.begin(), bodies.end(), spheres.body[i])) {
      removed[0] += spheres.is_ghost(i) ? 0 : 1;
      continue;
    }
    new_index[i] = static_cast<std::int32_t>(kept.size());
    kept.push_back(static_cast<std::int32_t>(i));
  }
  domain.communicator().add_up(removed);
  spheres_present -= removed[0];
  remove_spheres(new_index, lists, pool, spheres, wall_contacts);
  spheres.select(kept);
  remove_clumps(new_index, spheres, clumps);
  domain.follow_order(new_index);
}

void Simulation::State::check_places(const DriftResult& of_spheres,
                                     const DriftResult& of_clumps) const {
  if (of_spheres.out >= 0) lost(static_cast<std::size_t>(of_spheres.out));
  if (of_clumps.out >= 0) lost(static_cast<std::size_t>(of_clumps.out));
}

Simulation::State::Agreed Simulation::State::agree(double moved, bool removes) {
  double of_all[3] = {moved, removes ? 1.0 : 0.0, pending ? 1.0 : 0.0};
  domain.communicator().maximize(of_all);
  if (of_all[2] > 0.0) domain.communicator().rethrow(std::exchange(pending, nullptr));
  return {of_all[0], of_all[1] > 0.0};
}

void Simulation::State::one_step() {
  kick(scene.gravity_m_s2, dt, clumps);
  const DriftResult of_spheres = kick_and_drift(box, scene.gravity_m_s2, dt, spheres);
  const DriftResult of_clumps = drift(box, dt, clumps, spheres);
  ++steps;
  const double moved_here = std::sqrt(std::max(of_spheres.moved2, of_clumps.moved2));
  attempt([&] {
    check_places(of_spheres, of_clumps);
    check_displacement(moved_here);
  });
  const std::vector<std::int32_t> sunk =
      sinks.empty() ? std::vector<std::int32_t>{} : bodies_in_sinks();
  const Agreed agreed = agree(moved_here, !sunk.empty());
  if (agreed.removes) remove_from_all(sunk);
  wrapped_kg_m.add(of_spheres.moved_kg_m);
  wrapped_kg_m.add(of_clumps.moved_kg_m);
  walls.advance(time_s(), dt);
  check_wall_speed();
  const bool was_listed = keep_lists_valid(agreed.moved);
  if (!was_listed) domain.update_ghosts(spheres);
  if (!rains.empty() && steps % kStepsBetweenRain == 0) let_rain_fall();
  compute_forces(dt);
  if (steps % kStepsBetweenLooks == 0) watch_speed();
}

/// Lists are rebuilt before a sphere has moved by half the skin, so that more than that and a
/// radius can only come from one step in which it jumped.
void Simulation::State::check_displacement(double moved) const {
  if (moved <= 0.5 * skin.width() + least_radius) return;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    if (!spheres.is_ghost(i) &&
        box.nearest_image(spheres.motion[i].x - spheres.x_listed[i]).norm() >= moved)
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
  if (!spheres.is_of_clump(i)) return sphere;
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

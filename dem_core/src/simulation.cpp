#include "repose/dem/simulation.hpp"

#include <algorithm>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/dem/cross.hpp"
#include "simulation_state.hpp"

namespace repose::dem {

Simulation::Simulation(const scene::Case& scene, const SimulationOptions& options)
    : state_(std::make_unique<State>(scene, options)) {
  state_->place_all();
}

Simulation::Simulation(const scene::Case& scene, const Checkpoint& checkpoint, Balance balance) {
  require_same_beginning(checkpoint, scene);
  state_ =
      std::make_unique<State>(scene, SimulationOptions{checkpoint.number("time_step_option_s"),
                                                       checkpoint.number("skin_radii"), balance});
  state_->restore(checkpoint);
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
  state_->agree(0.0, false);  // on what the last forces may have shown
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
  state_->laws = LawTable(state_->scene, &*stage);
  state_->stage_start_s[name] = time_s();
}

std::vector<WallLoad> Simulation::take_wall_loads() {
  std::vector<WallLoad> loads;
  const double steps = static_cast<double>(std::max<std::int64_t>(state_->wall_load_steps, 1));
  std::vector<ExactSum> sums;
  for (const WallLoadSum& sum : state_->walls.loads()) {
    for (const ExactVectorSum* const v : {&sum.force, &sum.torque})
      sums.insert(sums.end(), {v->x, v->y, v->z});
    sums.push_back(sum.work);
    state_->wall_work_j.add(sum.work);
  }
  state_->domain.communicator().add_up(sums);
  for (std::size_t s = 0; s < sums.size(); s += 7) {
    const auto vector = [&](std::size_t at) {
      return Vec3(sums[at].value(), sums[at + 1].value(), sums[at + 2].value());
    };
    loads.push_back({vector(s) / steps, vector(s + 3) / steps, sums[s + 6].value()});
  }
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

std::vector<std::optional<scene::MeshReport>> Simulation::mesh_reports() const {
  std::vector<std::optional<scene::MeshReport>> reports;
  for (std::size_t w = 0; w < state_->walls.size(); ++w)
    reports.push_back(state_->walls.at(w).report);
  return reports;
}

std::int64_t Simulation::steps() const {
  return state_->steps;
}
double Simulation::time_s() const {
  return state_->time_s();
}
std::size_t Simulation::size() const {
  return static_cast<std::size_t>(state_->spheres_present);
}
std::int64_t Simulation::cuts() const {
  return state_->domain.cuts();
}
std::int64_t Simulation::rebuilds() const {
  return state_->rebuilds;
}

double Simulation::time_step_s() {
  state_->prepare();
  return state_->dt;
}

double Simulation::mass_kg() const {
  ExactSum sum[1];
  for (std::size_t i = 0; i < state_->spheres.size(); ++i)
    if (!state_->spheres.is_ghost(i)) sum[0].add(state_->spheres.mass[i]);
  state_->sum_up(sum);
  return sum[0].value();
}

scene::Ledger Simulation::ledger() const {
  scene::Ledger ledger = state_->ledger;
  std::int64_t alive[1] = {static_cast<std::int64_t>(state_->clumps.size())};
  for (std::size_t i = 0; i < state_->spheres.size(); ++i)
    alive[0] += state_->spheres.is_alone(i) ? 1 : 0;
  state_->sum_up(alive);
  ledger.alive = alive[0];
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
  return state_->bodies();
}

std::vector<Sphere> Simulation::spheres() {
  state_->prepare();
  if (state_->domain.is_alone()) return state_->seen_spheres(state_->spheres, state_->clumps);
  const State::Whole whole = state_->gathered();
  return state_->seen_spheres(whole.spheres, whole.clumps);
}

std::vector<Sphere> Simulation::State::seen_spheres(const Spheres& all,
                                                    const Clumps& of_them) const {
  const std::vector<Body> bodies = bodies_of(all, of_them, scene.gravity_m_s2, 0.5 * dt);
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
                               of_them.members[static_cast<std::size_t>(all.member[i])].arm);
    sphere.angular_velocity = body.angular_velocity;
    out.push_back(sphere);
  }
  std::sort(out.begin(), out.end(), [](const Sphere& a, const Sphere& b) { return a.id < b.id; });
  return out;
}

double Simulation::kinetic_energy_j() {
  return sum_over_bodies(1, [](const Body& body, std::span<double> numbers) {
    numbers[0] = body.kinetic_energy_j();
  })[0];
}

std::size_t Simulation::contacts() {
  state_->prepare();
  const State& s = *state_;
  std::int64_t count[1] = {static_cast<std::int64_t>(s.wall_contacts.all.size())};
  for (const Neighbor& neighbor : s.lists.pairs.entries)
    if (neighbor.contact != kNoContact &&
        !s.spheres.is_ghost(static_cast<std::size_t>(neighbor.row)))
      ++count[0];
  s.sum_up(count);
  return static_cast<std::size_t>(count[0]);
}

LargestOverlap Simulation::take_largest_overlap() {
  state_->prepare();
  const LargestOverlap largest = state_->largest_overlap_of_all();
  state_->largest_overlap = {};
  return largest;
}

LargestOverlap Simulation::State::largest_overlap_of_all() const {
  Packer mine;
  mine.put(largest_overlap);
  LargestOverlap largest;
  for (const Bytes& bytes : domain.communicator().gather_to_all(mine.take())) {
    const auto one = Unpacker(bytes).get<LargestOverlap>();
    if (one.ratio() > largest.ratio()) largest = one;
  }
  return largest;
}

Checkpoint Simulation::checkpoint() {
  state_->prepare();
  return state_->checkpoint();
}

std::uint64_t Simulation::state_hash() {
  state_->prepare();
  return state_->hash();
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

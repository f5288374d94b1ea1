// What a simulation looks like at one time: bodies, energy, contacts. Nothing changes here.
#include <algorithm>
#include <utility>

#include "particles/rotation.hpp"
#include "repose/base/error.hpp"
#include "simulation_state.hpp"

namespace repose::dem {

double Body::kinetic_energy_j() const {
  return 0.5 * mass_kg * velocity.squaredNorm() + 0.5 * angular_velocity.dot(angular_momentum());
}

Vec3 Body::angular_momentum() const {
  const Eigen::Matrix3d turn = rotation_matrix(quaternion_of(orientation_wxyz));
  return turn * inertia_kg_m2.cwiseProduct(turn.transpose() * angular_velocity);
}

std::vector<Body> Simulation::State::bodies() const {
  const Spheres& all = spheres;
  const Vec3& gravity = scene.gravity_m_s2;
  const double half = 0.5 * dt;
  std::vector<Body> out;
  out.reserve(all.size() - clumps.members.size() + clumps.all.size());
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
  for (const Clump& clump : clumps.all) {
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

/// Kinetic and potential, from the origin of the coordinates.
double Simulation::State::mechanical_j(const Body& body) const {
  return body.kinetic_energy_j() - body.mass_kg * scene.gravity_m_s2.dot(body.position);
}

void Simulation::State::count_dissipation(const ContactEnergies& now, double span) {
  stored = now;
  counted.dissipated_normal_j += now.normal_damping_w * span;
  counted.dissipated_tangential_j += now.tangential_damping_w * span;
  counted.dissipated_sliding_j += now.sliding_w * span;
  counted.dissipated_rolling_j += now.rolling_w * span;
  counted.stiffness_change_j += now.stiffness_change_w * span;
  counted.released_j += pool.take_released_j() + std::exchange(wall_contacts.released_j, 0.0);
}

scene::EnergyRow Simulation::energy() {
  state_->prepare();
  if (!state_->scene.output.energy)
    throw InputError("the ledger of energy is not kept; set output.energy = true in the case");
  scene::EnergyRow row = state_->counted;
  row.time_s = time_s();
  for (const Body& body : state_->bodies()) {
    const double translational = 0.5 * body.mass_kg * body.velocity.squaredNorm();
    row.kinetic_translational_j += translational;
    row.kinetic_rotational_j += body.kinetic_energy_j() - translational;
    row.gravitational_j -= body.mass_kg * state_->scene.gravity_m_s2.dot(body.position);
  }
  row.gravitational_j += state_->scene.gravity_m_s2.dot(state_->wrapped_kg_m);
  row.elastic_normal_j = state_->stored.normal_j;
  row.elastic_tangential_j = state_->stored.tangential_j;
  row.elastic_rolling_j = state_->stored.rolling_j;
  row.wall_work_j = state_->wall_work_j;
  for (const WallLoadSum& sum : state_->walls.loads()) row.wall_work_j += sum.work;
  const double there = row.kinetic_translational_j + row.kinetic_rotational_j +
                       row.gravitational_j + state_->stored.stored_j();
  const double lost = row.dissipated_normal_j + row.dissipated_tangential_j +
                      row.dissipated_sliding_j + row.dissipated_rolling_j + row.stiffness_change_j +
                      row.released_j + row.removed_j;
  row.error_j = there + lost - state_->initial_j - row.inserted_j - row.wall_work_j;
  return row;
}

namespace {

/// Adds contacts of one pair of materials up.
struct PairSum {
  scene::PairContacts sum;
  double sliding = 0.0;

  void add(const ContactState& state, double smaller_radius) {
    ++sum.contacts;
    sum.mean_normal_force_n += state.normal_force_n;
    sum.largest_normal_force_n = std::max(sum.largest_normal_force_n, state.normal_force_n);
    sum.mean_overlap_ratio += state.overlap_m / smaller_radius;
    sliding += state.sliding ? 1.0 : 0.0;
  }
  scene::PairContacts mean() const {
    scene::PairContacts mean = sum;
    if (sum.contacts == 0) return mean;
    const auto n = static_cast<double>(sum.contacts);
    mean.mean_normal_force_n /= n;
    mean.mean_overlap_ratio /= n;
    mean.sliding_fraction = sliding / n;
    return mean;
  }
};

}  // namespace

std::vector<scene::PairContacts> Simulation::contact_statistics() {
  state_->prepare();
  const State& s = *state_;
  std::vector<PairSum> sums(s.scene.pairs.size());
  const auto materials = static_cast<std::int32_t>(s.scene.materials.size());
  std::vector<int> index_of;
  for (std::int32_t a = 0; a < materials; ++a)
    for (std::int32_t b = 0; b < materials; ++b)
      index_of.push_back(scene::pair_index(s.scene, a, b));
  const auto of_pair = [&](std::int32_t a, std::int32_t b) -> PairSum& {
    const int pair = index_of[static_cast<std::size_t>(a * materials + b)];
    return sums[static_cast<std::size_t>(pair)];
  };
  for (const PairState& pair : pair_states(s.box, s.laws, s.dt, s.spheres, s.lists.pairs, s.pool)) {
    const auto i = static_cast<std::size_t>(pair.i);
    const auto j = static_cast<std::size_t>(pair.j);
    of_pair(s.spheres.material[i], s.spheres.material[j])
        .add(pair.state, std::min(s.spheres.motion[i].radius, s.spheres.motion[j].radius));
  }
  const std::vector<ContactState> walls =
      wall_states(s.laws, s.dt, s.walls, s.spheres, s.wall_contacts);
  for (std::size_t c = 0; c < walls.size(); ++c) {
    const WallContact& contact = s.wall_contacts.all[c];
    const auto i = static_cast<std::size_t>(contact.sphere);
    of_pair(s.spheres.material[i], s.walls.at(static_cast<std::size_t>(contact.wall)).material)
        .add(walls[c], s.spheres.motion[i].radius);
  }
  std::vector<scene::PairContacts> means;
  for (const PairSum& sum : sums) means.push_back(sum.mean());
  return means;
}

}  // namespace repose::dem

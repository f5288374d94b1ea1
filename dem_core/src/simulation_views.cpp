// What a simulation looks like at one time: bodies, energy, contacts. Nothing changes here.
#include <algorithm>
#include <utility>

#include "checkpoint/contact_records.hpp"
#include "neighbor/sphere_order.hpp"
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

Simulation::State::Whole Simulation::State::gathered() {
  Whole whole;
  for (const Bytes& bytes :
       domain.communicator().gather(Domain::parcel_of(population()).packed())) {
    const Parcel parcel = unpacked(bytes);
    append_bodies(parcel, whole.spheres, whole.clumps, whole.wall_contacts);
    for (const PairContactRecord& contact : parcel.contacts)
      whole.contacts.push_back(contact_of(contact));
  }
  sort_spheres(whole.spheres, whole.clumps, whole.wall_contacts);
  sort(whole.contacts);
  return whole;
}

std::vector<Body> Simulation::State::bodies() {
  if (domain.is_alone()) return bodies_of(spheres, clumps, scene.gravity_m_s2, 0.5 * dt);
  const Whole whole = gathered();
  return bodies_of(whole.spheres, whole.clumps, scene.gravity_m_s2, 0.5 * dt);
}

namespace {

/// Calls visit(body) for the bodies of this process, velocities at the present time.
template <class Visit>
void visit_bodies(const Spheres& all, const Clumps& clumps, const Vec3& gravity, double half,
                  Visit visit) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all.is_alone(i)) continue;
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
    visit(body);
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
    visit(body);
  }
}

}  // namespace

std::vector<Body> bodies_of(const Spheres& spheres, const Clumps& clumps, const Vec3& gravity,
                            double half_step_s) {
  std::vector<Body> out;
  out.reserve(spheres.size() - clumps.members.size() + clumps.all.size());
  visit_bodies(spheres, clumps, gravity, half_step_s,
               [&out](const Body& body) { out.push_back(body); });
  std::sort(out.begin(), out.end(), [](const Body& a, const Body& b) { return a.id < b.id; });
  return out;
}

std::vector<double> Simulation::sum_over_bodies(std::size_t count,
                                                const NumbersOfBody& numbers_of) {
  state_->prepare();
  return state_->sum_over_bodies(count, numbers_of);
}

std::vector<double> Simulation::State::sum_over_bodies(std::size_t count,
                                                       const NumbersOfBody& numbers_of) const {
  std::vector<ExactSum> sums(count);
  std::vector<double> numbers(count);
  visit_bodies(spheres, clumps, scene.gravity_m_s2, 0.5 * dt, [&](const Body& body) {
    std::fill(numbers.begin(), numbers.end(), 0.0);
    numbers_of(body, numbers);
    for (std::size_t k = 0; k < count; ++k) sums[k].add(numbers[k]);
  });
  sum_up(sums);
  std::vector<double> totals;
  for (const ExactSum& sum : sums) totals.push_back(sum.value());
  return totals;
}

/// Kinetic and potential, from the origin of the coordinates.
double Simulation::State::mechanical_j(const Body& body) const {
  return body.kinetic_energy_j() - body.mass_kg * scene.gravity_m_s2.dot(body.position);
}

/// What is lost is summed as power: all steps are equally long, but for the first forces, which
/// belong to none.
void Simulation::State::count_dissipation(const ExactEnergies& now, double span) {
  energies.normal_j = now.normal_j;
  energies.tangential_j = now.tangential_j;
  energies.rolling_j = now.rolling_j;
  if (span == 0.0) return;
  energies.normal_damping_w.add(now.normal_damping_w);
  energies.tangential_damping_w.add(now.tangential_damping_w);
  energies.sliding_w.add(now.sliding_w);
  energies.rolling_w.add(now.rolling_w);
  energies.stiffness_change_w.add(now.stiffness_change_w);
}

std::vector<std::pair<std::string, ExactSum*>> Simulation::State::exact_sums() {
  std::vector<std::pair<std::string, ExactSum*>> sums{
      {"normal_j", &energies.normal_j},
      {"tangential_j", &energies.tangential_j},
      {"rolling_j", &energies.rolling_j},
      {"normal_damping_w", &energies.normal_damping_w},
      {"tangential_damping_w", &energies.tangential_damping_w},
      {"sliding_w", &energies.sliding_w},
      {"rolling_w", &energies.rolling_w},
      {"stiffness_change_w", &energies.stiffness_change_w},
      {"pairs_released_j", &pool.released_j()},
      {"walls_released_j", &wall_contacts.released_j},
      {"wrapped_x_kg_m", &wrapped_kg_m.x},
      {"wrapped_y_kg_m", &wrapped_kg_m.y},
      {"wrapped_z_kg_m", &wrapped_kg_m.z},
      {"wall_work_j", &wall_work_j},
  };
  for (std::size_t w = 0; w < walls.size(); ++w) {
    WallLoadSum& load = walls.load(w);
    const std::string of_wall = "_of_wall_" + std::to_string(w);
    sums.emplace_back("force_x_n" + of_wall, &load.force.x);
    sums.emplace_back("force_y_n" + of_wall, &load.force.y);
    sums.emplace_back("force_z_n" + of_wall, &load.force.z);
    sums.emplace_back("torque_x_n_m" + of_wall, &load.torque.x);
    sums.emplace_back("torque_y_n_m" + of_wall, &load.torque.y);
    sums.emplace_back("torque_z_n_m" + of_wall, &load.torque.z);
    sums.emplace_back("work_j" + of_wall, &load.work);
  }
  return sums;
}

Simulation::State::Totals Simulation::State::totals() {
  std::vector<ExactSum> sums;
  const auto named = exact_sums();
  for (const auto& [name, sum] : named) sums.push_back(*sum);
  domain.communicator().add_up(sums);
  Totals totals;
  for (std::size_t s = 0; s < sums.size(); ++s) totals[named[s].first] = sums[s];
  return totals;
}

double Simulation::State::stored_j() {
  ExactSum sums[3] = {energies.normal_j, energies.tangential_j, energies.rolling_j};
  domain.communicator().add_up(sums);
  return sums[0].value() + sums[1].value() + sums[2].value();
}

scene::EnergyRow Simulation::energy() {
  state_->prepare();
  if (!state_->scene.output.energy)
    throw InputError("the ledger of energy is not kept; set output.energy = true in the case");
  State& s = *state_;
  scene::EnergyRow row = s.counted;
  row.time_s = time_s();
  const std::vector<double> of_bodies =
      s.sum_over_bodies(3, [&s](const Body& body, std::span<double> numbers) {
        numbers[0] = 0.5 * body.mass_kg * body.velocity.squaredNorm();
        numbers[1] = body.kinetic_energy_j() - numbers[0];
        numbers[2] = -body.mass_kg * s.scene.gravity_m_s2.dot(body.position);
      });
  row.kinetic_translational_j = of_bodies[0];
  row.kinetic_rotational_j = of_bodies[1];
  row.gravitational_j = of_bodies[2];
  State::Totals totals = s.totals();
  const auto of = [&](const char* name) { return totals.at(name).value(); };
  row.gravitational_j += s.scene.gravity_m_s2.dot(
      Vec3(of("wrapped_x_kg_m"), of("wrapped_y_kg_m"), of("wrapped_z_kg_m")));
  row.elastic_normal_j = of("normal_j");
  row.elastic_tangential_j = of("tangential_j");
  row.elastic_rolling_j = of("rolling_j");
  row.dissipated_normal_j = of("normal_damping_w") * s.dt;
  row.dissipated_tangential_j = of("tangential_damping_w") * s.dt;
  row.dissipated_sliding_j = of("sliding_w") * s.dt;
  row.dissipated_rolling_j = of("rolling_w") * s.dt;
  row.stiffness_change_j = of("stiffness_change_w") * s.dt;
  row.released_j = of("pairs_released_j") + of("walls_released_j");
  ExactSum wall_work = totals.at("wall_work_j");
  for (std::size_t w = 0; w < s.walls.size(); ++w)
    wall_work.add(totals.at("work_j_of_wall_" + std::to_string(w)));
  row.wall_work_j = wall_work.value();
  const double there = row.kinetic_translational_j + row.kinetic_rotational_j +
                       row.gravitational_j + row.elastic_normal_j + row.elastic_tangential_j +
                       row.elastic_rolling_j;
  const double lost = row.dissipated_normal_j + row.dissipated_tangential_j +
                      row.dissipated_sliding_j + row.dissipated_rolling_j + row.stiffness_change_j +
                      row.released_j + row.removed_j;
  row.error_j = there + lost - s.initial_j - row.inserted_j - row.wall_work_j;
  return row;
}

namespace {

/// Adds contacts of one pair of materials up, then those of all processes.
struct PairSum {
  std::int64_t counts[2] = {0, 0};  // contacts, those that slide
  ExactSum sums[2];                 // normal forces, overlaps over the smaller radius
  double largest[1] = {0.0};        // normal force

  void add(const ContactState& state, double smaller_radius) {
    ++counts[0];
    counts[1] += state.sliding ? 1 : 0;
    sums[0].add(state.normal_force_n);
    sums[1].add(state.overlap_m / smaller_radius);
    largest[0] = std::max(largest[0], state.normal_force_n);
  }
  scene::PairContacts mean(const Communicator& communicator) {
    communicator.add_up(counts);
    communicator.add_up(sums);
    communicator.maximize(largest);
    scene::PairContacts mean;
    mean.contacts = counts[0];
    mean.largest_normal_force_n = largest[0];
    if (counts[0] == 0) return mean;
    const auto n = static_cast<double>(counts[0]);
    mean.mean_normal_force_n = sums[0].value() / n;
    mean.mean_overlap_ratio = sums[1].value() / n;
    mean.sliding_fraction = static_cast<double>(counts[1]) / n;
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
  for (PairSum& sum : sums) means.push_back(sum.mean(s.domain.communicator()));
  return means;
}

}  // namespace repose::dem

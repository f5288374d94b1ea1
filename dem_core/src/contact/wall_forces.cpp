#include <algorithm>
#include <array>

#include "contact/contact_evaluation.hpp"
#include "contact/contact_forces.hpp"
#include "contact/pair_kernel.hpp"
#include "contact/wall_touches.hpp"

namespace repose::dem {
namespace {

constexpr double kSameContact = 0.9;  // least cosine between the normals of two steps
constexpr std::int32_t kTaken = -1;   // stands for the patch of a contact that goes on

/// The contacts of one sphere in the step before: a run of all of them.
std::span<WallContact> contacts_of(std::int32_t sphere, std::vector<WallContact>& all,
                                   std::size_t& next) {
  while (next < all.size() && all[next].sphere < sphere) ++next;
  const std::size_t first = next;
  while (next < all.size() && all[next].sphere == sphere) ++next;
  return {all.data() + first, next - first};
}

/// The contact that `push` goes on with, which is then taken; or a new one.
Contact continued(const WallPush& push, std::span<WallContact> before) {
  WallContact* best = nullptr;
  double best_cosine = kSameContact;
  for (WallContact& candidate : before) {
    if (candidate.patch != push.patch) continue;
    const double cosine = candidate.normal.dot(push.normal);
    if (cosine <= best_cosine) continue;
    best = &candidate;
    best_cosine = cosine;
  }
  if (best == nullptr) return {};
  best->patch = kTaken;
  return best->contact;
}

/// What the sphere does to the wall at a point, by a force and a torque on the sphere.
void add_to_wall(const Vec3& force, const Vec3& rolling_torque, const Vec3& point,
                 const WallBody& wall, double dt, WallLoadSum& sum) {
  sum.force.add(-force);
  sum.torque.add(-(cross(point - wall.now.reference, force) + rolling_torque));
  if (wall.motion.empty()) return;
  const Twist& twist = wall.now.twist;
  sum.work.add((force.dot(twist.at(point)) + rolling_torque.dot(twist.spin)) * dt);
}

/// Who touches which wall now, by ascending sphere, with the histories of the step before.
void find_wall_contacts(const WallList& list, const Walls& walls, const Spheres& spheres,
                        WallContacts& contacts, DeepestOverlap& deepest) {
  contacts.before.swap(contacts.all);
  contacts.all.clear();
  WallTouches touches;
  const double walls_moved = walls.displacement();
  std::size_t next = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const std::span<const NearFacet> facets = list.row(i);
    if (facets.empty()) continue;
    const auto id = static_cast<std::int32_t>(i);
    const Motion& sphere = spheres.motion[i];
    const double moved = (sphere.x - spheres.x_listed[i]).norm() + walls_moved;
    const std::span<WallContact> before = contacts_of(id, contacts.before, next);
    for (const WallPush& push : touches.find(walls, sphere.x, sphere.radius, facets, moved)) {
      deepest.see(push.overlap, sphere.radius, id, push.wall, true);
      contacts.all.push_back(
          {push.normal, push.overlap, id, push.patch, push.wall, continued(push, before)});
    }
  }
  for (const WallContact& ended : contacts.before)
    if (ended.patch != kTaken) contacts.released_j.add(ended.contact.stored_j);
}

struct alignas(32) FourNumbers {
  double a = 0.0, b = 0.0, c = 0.0, d = 0.0;
};
FourNumbers row_of(const Vec3& v) {
  return {v.x(), v.y(), v.z(), 0.0};
}
Vec3 vector_of(const FourNumbers& row) {
  return {row.a, row.b, row.c};
}

/// Velocity and spin of each wall at the time of the velocities.
std::vector<FourNumbers> twists_of(const Walls& walls) {
  std::vector<FourNumbers> rows;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    rows.push_back(row_of(walls.at(w).half_twist.velocity));
    rows.push_back(row_of(walls.at(w).half_twist.spin));
  }
  return rows;
}

constexpr std::size_t kBatch = 64;

}  // namespace

void add_wall_forces(const LawTable& laws, double dt, const WallList& list, Walls& walls,
                     Spheres& spheres, WallContacts& contacts, DeepestOverlap& deepest,
                     ExactEnergies* energies) {
  find_wall_contacts(list, walls, spheres, contacts, deepest);
  const PairKernel& kernel = pair_kernel();
  const std::vector<FourNumbers> twists = twists_of(walls);
  std::array<FourNumbers, 3 * kBatch> forces;
  std::array<std::int32_t, kBatch> sphere_of, wall_of;
  std::array<const PairLaw*, kBatch> law_of;
  for (std::size_t first = 0; first < contacts.all.size(); first += kBatch) {
    WallContact* const batch = contacts.all.data() + first;
    const std::size_t count = std::min(kBatch, contacts.all.size() - first);
    for (std::size_t c = 0; c < count; ++c) {
      sphere_of[c] = batch[c].sphere;
      wall_of[c] = batch[c].wall;
      law_of[c] = &laws.at(spheres.material[static_cast<std::size_t>(batch[c].sphere)],
                           walls.at(static_cast<std::size_t>(batch[c].wall)).material);
    }
    const WallBatch now{.motion = spheres.motion.data()->x.data(),
                        .spin = spheres.spin.data()->w.data(),
                        .contacts = batch->normal.data(),
                        .twists = &twists.data()->a,
                        .forces = &forces.data()->a,
                        .spheres = sphere_of.data(),
                        .walls = wall_of.data(),
                        .laws = law_of.data(),
                        .model = laws.model(),
                        .dt = dt,
                        .count = count};
    if (energies != nullptr)
      find_forces_with_energies(now, *energies);
    else
      kernel.find_forces(now);
    for (std::size_t c = 0; c < count; ++c) {
      const auto i = static_cast<std::size_t>(batch[c].sphere);
      const auto w = static_cast<std::size_t>(batch[c].wall);
      const Vec3 force = vector_of(forces[3 * c]);
      spheres.load[i].force += force;
      spheres.load[i].torque += vector_of(forces[3 * c + 1]);
      const double arm = spheres.motion[i].radius - 0.5 * batch[c].overlap;
      add_to_wall(force, vector_of(forces[3 * c + 2]), spheres.motion[i].x + arm * batch[c].normal,
                  walls.at(w), dt, walls.load(w));
    }
  }
}

std::vector<ContactState> wall_states(const LawTable& laws, double dt, const Walls& walls,
                                      const Spheres& spheres, const WallContacts& contacts) {
  std::vector<ContactState> states;
  states.reserve(contacts.all.size());
  for (const WallContact& contact : contacts.all) {
    const auto i = static_cast<std::size_t>(contact.sphere);
    const WallBody& wall = walls.at(static_cast<std::size_t>(contact.wall));
    states.push_back(
        contact_state(laws.model(), laws.at(spheres.material[i], wall.material),
                      sphere_wall(spheres.motion[i].radius, 1.0 / spheres.motion[i].inv_mass),
                      wall_kinematics(dt, contact.normal, contact.overlap, spheres.motion[i],
                                      spheres.spin[i].w, wall.half_twist),
                      contact.contact.history));
  }
  return states;
}

}  // namespace repose::dem

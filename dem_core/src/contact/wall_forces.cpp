#include "contact/contact_evaluation.hpp"
#include "contact/contact_forces.hpp"
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

/// The force of a contact, and what it stores and loses.
ContactForce force_of(const scene::ContactModel& model, const PairLaw& law, const Motion& sphere,
                      const ContactKinematics& now, double dt, Contact& contact,
                      ContactEnergies* sum) {
  const ContactBodies bodies = sphere_wall(sphere.radius, 1.0 / sphere.inv_mass);
  if (sum == nullptr) return hertz_mindlin(model, law, bodies, now, dt, contact.history);
  ContactEnergies energies;
  const ContactForce force = hertz_mindlin(model, law, bodies, now, dt, contact.history, energies);
  contact.stored_j = energies.stored_j();
  *sum += energies;
  return force;
}

/// What the sphere does to the wall at the point x + arm n; `f` acts on the sphere.
void add_to_wall(const ContactForce& f, const Vec3& point, const WallBody& wall, double dt,
                 WallLoadSum& sum) {
  sum.force -= f.force;
  sum.torque -= cross(point - wall.now.reference, f.force) + f.rolling_torque;
  if (wall.motion.empty()) return;
  const Twist& twist = wall.now.twist;
  sum.work += (f.force.dot(twist.at(point)) + f.rolling_torque.dot(twist.spin)) * dt;
}

}  // namespace

void add_wall_forces(const LawTable& laws, double dt, const WallList& list, Walls& walls,
                     Spheres& spheres, WallContacts& contacts, DeepestOverlap& deepest,
                     ContactEnergies* energies) {
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
    Load& load = spheres.load[i];
    for (const WallPush& push : touches.find(walls, sphere.x, sphere.radius, facets, moved)) {
      const WallBody& wall = walls.at(static_cast<std::size_t>(push.wall));
      deepest.see(push.overlap, sphere.radius, id, push.wall, true);
      contacts.all.push_back(
          {id, push.patch, push.wall, push.normal, push.overlap, continued(push, before)});
      Contact& contact = contacts.all.back().contact;
      const ContactKinematics now = wall_kinematics(dt, push.normal, push.overlap, sphere,
                                                    spheres.spin[i].w, wall.half_twist);
      const PairLaw& law = laws.at(spheres.material[i], wall.material);
      const ContactForce f = force_of(laws.model(), law, sphere, now, dt, contact, energies);
      const double arm = sphere.radius - 0.5 * push.overlap;
      load.force += f.force;
      load.torque += arm * cross(now.normal, f.tangential) + f.rolling_torque;
      add_to_wall(f, sphere.x + arm * push.normal, wall, dt,
                  walls.load(static_cast<std::size_t>(push.wall)));
    }
  }
  for (const WallContact& ended : contacts.before)
    if (ended.patch != kTaken) contacts.released_j += ended.contact.stored_j;
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

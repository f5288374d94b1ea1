#include <algorithm>

#include "contact/contact_forces.hpp"
#include "geometry/cross.hpp"

namespace repose::dem {
namespace {

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

template <int kMask>
void find_touching_in(const Box& box, const Spheres& spheres, NeighborList& pairs,
                      ContactPool& pool, std::vector<TouchingPair>& touching) {
  const Motion* const motion = spheres.motion.data();
  const std::int32_t* const first = pairs.first.data();
  Neighbor* const entries = pairs.entries.data();
  const auto n = static_cast<std::int32_t>(spheres.size());
  touching.resize(pairs.entries.size());
  std::size_t count = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    const Motion& a = motion[i];
    const std::int32_t last = first[i + 1];
    for (std::int32_t p = first[i]; p < last; ++p) {
      Neighbor& neighbor = entries[p];
      const Motion& b = motion[neighbor.other];
      const Vec3 offset = box.nearest_image_in<kMask>(b.x - a.x);
      const double reach = a.radius + b.radius;
      const double distance2 = offset.squaredNorm();
      if (distance2 < reach * reach) {
        if (neighbor.contact == kNoContact)
          neighbor.contact = pool.begin_contact(
              sphere_sphere(a.radius, 1.0 / a.inv_mass, b.radius, 1.0 / b.inv_mass));
        touching[count++] = {offset, distance2, i, neighbor.other, neighbor.contact};
      } else if (neighbor.contact != kNoContact) {
        pool.end_contact(neighbor.contact);
        neighbor.contact = kNoContact;
      }
    }
  }
  touching.resize(count);
}

}  // namespace

void find_touching(const Box& box, const Spheres& spheres, NeighborList& pairs, ContactPool& pool,
                   std::vector<TouchingPair>& touching) {
  with_periodic_mask(
      box, [&]<int kMask>() { find_touching_in<kMask>(box, spheres, pairs, pool, touching); });
}

void add_pair_forces(const LawTable& laws, double dt, const std::vector<TouchingPair>& touching,
                     Spheres& spheres, ContactPool& pool, DeepestOverlap& deepest) {
  for (const TouchingPair& pair : touching) {
    const std::size_t i = index(pair.i);
    const std::size_t j = index(pair.j);
    const Motion& a = spheres.motion[i];
    const Motion& b = spheres.motion[j];
    const Vec3& wa = spheres.spin[i].w;
    const Vec3& wb = spheres.spin[j].w;
    const double distance = std::sqrt(pair.distance2);
    ContactKinematics now;
    now.normal = pair.offset * (1.0 / distance);
    now.overlap = a.radius + b.radius - distance;
    deepest.see(now.overlap, std::min(a.radius, b.radius), pair.i, pair.j, false);
    const double arm_a = a.radius - 0.5 * now.overlap;
    const double arm_b = b.radius - 0.5 * now.overlap;
    now.velocity = a.v - b.v + cross(arm_a * wa + arm_b * wb, now.normal);
    now.spin = wa - wb;

    Contact& contact = pool.at(pair.contact);
    const PairLaw& law = laws.at(spheres.material[i], spheres.material[j]);
    const ContactForce f = hertz_mindlin(law, contact.bodies, now, dt, contact.history);
    const Vec3 turning = cross(now.normal, f.tangential);
    Load& on_a = spheres.load[i];
    Load& on_b = spheres.load[j];
    on_a.force += f.force;
    on_b.force -= f.force;
    on_a.torque += arm_a * turning + f.rolling_torque;
    on_b.torque += arm_b * turning - f.rolling_torque;
  }
}

}  // namespace repose::dem

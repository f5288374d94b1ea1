#include <algorithm>
#include <array>

#include "contact/contact_evaluation.hpp"
#include "contact/contact_forces.hpp"

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
  touching.clear();
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
        touching.push_back({offset, distance2, i, neighbor.other, neighbor.contact});
      } else if (neighbor.contact != kNoContact) {
        pool.end_contact(neighbor.contact);
        neighbor.contact = kNoContact;
      }
    }
  }
}

/// Pairs are taken in blocks, and a block step by step: the steps of one contact wait for each
/// other, those of different contacts do not.
constexpr std::size_t kBlock = 32;

template <class Energies>
void add_forces(const LawTable& laws, double dt, const std::vector<TouchingPair>& touching,
                Spheres& spheres, ContactPool& pool, DeepestOverlap& deepest, Energies& energies) {
  const scene::ContactModel model = laws.model();
  std::array<ContactKinematics, kBlock> kinematics;
  std::array<ContactForce, kBlock> forces;
  for (std::size_t first = 0; first < touching.size(); first += kBlock) {
    const std::size_t count = std::min(kBlock, touching.size() - first);
    for (std::size_t k = 0; k < count; ++k) {
      const TouchingPair& pair = touching[first + k];
      __builtin_prefetch(&pool.at(pair.contact), 1);
      const Motion& a = spheres.motion[index(pair.i)];
      const Motion& b = spheres.motion[index(pair.j)];
      kinematics[k] = pair_kinematics(model, dt, pair.offset, std::sqrt(pair.distance2), a, b,
                                      spheres.spin[index(pair.i)].w, spheres.spin[index(pair.j)].w);
      deepest.see(kinematics[k].overlap, std::min(a.radius, b.radius), pair.i, pair.j, false);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const TouchingPair& pair = touching[first + k];
      __builtin_prefetch(&spheres.load[index(pair.j)], 1);
      const PairLaw& law =
          laws.at(spheres.material[index(pair.i)], spheres.material[index(pair.j)]);
      forces[k] = contact_force(model, law, kinematics[k], dt, pool.at(pair.contact), energies);
    }
    for (std::size_t k = 0; k < count; ++k) {
      const TouchingPair& pair = touching[first + k];
      const ContactForce& f = forces[k];
      const double half = 0.5 * kinematics[k].overlap;
      const Vec3 turning = cross(kinematics[k].normal, f.tangential);
      Load& on_a = spheres.load[index(pair.i)];
      Load& on_b = spheres.load[index(pair.j)];
      on_a.force += f.force;
      on_b.force -= f.force;
      on_a.torque += (spheres.motion[index(pair.i)].radius - half) * turning + f.rolling_torque;
      on_b.torque += (spheres.motion[index(pair.j)].radius - half) * turning - f.rolling_torque;
    }
  }
}

}  // namespace

void find_touching(const Box& box, const Spheres& spheres, NeighborList& pairs, ContactPool& pool,
                   std::vector<TouchingPair>& touching) {
  with_periodic_mask(
      box, [&]<int kMask>() { find_touching_in<kMask>(box, spheres, pairs, pool, touching); });
}

void add_pair_forces(const LawTable& laws, double dt, const std::vector<TouchingPair>& touching,
                     Spheres& spheres, ContactPool& pool, DeepestOverlap& deepest,
                     ContactEnergies* energies) {
  if (energies != nullptr) {
    add_forces(laws, dt, touching, spheres, pool, deepest, *energies);
  } else {
    NoEnergies none;
    add_forces(laws, dt, touching, spheres, pool, deepest, none);
  }
}

std::vector<ContactState> pair_states(const LawTable& laws, double dt,
                                      const std::vector<TouchingPair>& touching,
                                      const Spheres& spheres, const ContactPool& pool) {
  std::vector<ContactState> states;
  states.reserve(touching.size());
  for (const TouchingPair& pair : touching) {
    const std::size_t i = index(pair.i);
    const std::size_t j = index(pair.j);
    const Contact& contact = pool.at(pair.contact);
    states.push_back(contact_state(
        laws.model(), laws.at(spheres.material[i], spheres.material[j]), contact.bodies,
        pair_kinematics(laws.model(), dt, pair.offset, std::sqrt(pair.distance2), spheres.motion[i],
                        spheres.motion[j], spheres.spin[i].w, spheres.spin[j].w),
        contact.history));
  }
  return states;
}

}  // namespace repose::dem

// The contact part of a time step: who touches whom, and the forces that follow.
#pragma once

#include <vector>

#include "contact/law_table.hpp"
#include "neighbor/neighbor_lists.hpp"

namespace repose::dem {

/// The deepest overlap, as a fraction of the smaller radius, with who has it.
struct DeepestOverlap {
  double overlap = 0.0;
  double radius = 1.0;
  std::int32_t sphere = -1;
  std::int32_t other = -1;  ///< sphere or wall
  bool is_wall = false;

  double ratio() const { return overlap / radius; }
  void see(double new_overlap, double new_radius, std::int32_t i, std::int32_t j, bool wall) {
    if (new_overlap * radius <= overlap * new_radius) return;
    *this = {new_overlap, new_radius, i, j, wall};
  }
};

/// Finds the pairs that touch, in list order; begins contacts and ends those that separated; adds
/// the forces of all that touch to the loads, in list order, and what they store and lose to
/// `energies` unless it is null: that of a pair in the process that simulates its first sphere.
void add_pair_forces(const Box& box, const LawTable& laws, double dt, Spheres& spheres,
                     NeighborList& pairs, ContactPool& pool, DeepestOverlap& deepest,
                     ExactEnergies* energies = nullptr);

/// A contact of two spheres as statistics see it.
struct PairState {
  std::int32_t i, j;  ///< indices of the spheres
  ContactState state;
};
/// The pairs that touch, in list order, as they are now, those whose first sphere is simulated
/// here; nothing changes.
std::vector<PairState> pair_states(const Box& box, const LawTable& laws, double dt,
                                   const Spheres& spheres, const NeighborList& pairs,
                                   const ContactPool& pool);

/// Finds the contacts with walls, adds their forces to the loads and to the loads of the walls, in
/// list order, and what they store and lose to `energies` unless it is null.
void add_wall_forces(const LawTable& laws, double dt, const WallList& list, Walls& walls,
                     Spheres& spheres, WallContacts& contacts, DeepestOverlap& deepest,
                     ExactEnergies* energies = nullptr);

/// The contacts with walls, in order, as they are now; nothing changes.
std::vector<ContactState> wall_states(const LawTable& laws, double dt, const Walls& walls,
                                      const Spheres& spheres, const WallContacts& contacts);

}  // namespace repose::dem

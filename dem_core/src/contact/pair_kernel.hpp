// The inner loop over touching pairs, for one processor or another: raw memory, no Eigen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "repose/dem/pair_law.hpp"

namespace repose::dem {

struct ExactEnergies;

/// A pair that touches at this step: indices of the spheres, slot of the contact.
struct TouchingPair {
  std::int32_t i, j, contact;
};

/// What a kernel works on. Rows of doubles, each row aligned to 32 bytes:
///   motion    8 a sphere: x, R, v, 1/m
///   spin      4 a sphere: w, 1/I
///   load      8 a sphere: force, 0, torque, 0; added to
///   contacts  8 a slot: slip, rolling torque, stored energy, 0; changed
struct PairBatch {
  const double* motion;
  const double* spin;
  double* load;
  const std::int32_t* material;  ///< a sphere
  double* contacts;
  const PairLaw* laws;  ///< materials by materials
  std::int32_t materials;
  scene::ContactModel model;
  double dt;
  bool periodic;
  double length[3];  ///< of the period; 0 where there is none
  double half[3];    ///< of the period; infinite where there is none
  const TouchingPair* pairs;
  std::size_t count;
};

/// The deepest of a batch; `pair` is an index into it, -1 if none is deeper than `ratio` was.
struct DeepestPair {
  double ratio;  ///< overlap over the smaller radius
  std::ptrdiff_t pair;
};

/// Contacts with walls: rows of doubles as above, and
///   contacts  16 a contact: normal and overlap; what stands in between; then as a slot of pairs
///   twists    8 a wall: velocity, 0, spin, 0 at the time of the velocities
///   forces    12 a contact: force on the sphere and F_n, its torque on the sphere, rolling torque;
///             written
struct WallBatch {
  const double* motion;
  const double* spin;
  double* contacts;
  const double* twists;
  double* forces;
  const std::int32_t* spheres;  ///< index, of each contact
  const std::int32_t* walls;    ///< of each contact
  const PairLaw* const* laws;   ///< of each contact
  scene::ContactModel model;
  double dt;
  std::size_t count;
};

/// add_forces() adds the forces of the pairs to the loads, in their order; find_forces() leaves
/// adding to the caller. All kernels give the same bits: each lane does the operations of one
/// contact, IEEE's and in one order.
struct PairKernel {
  const char* name;
  void (*add_forces)(const PairBatch& batch, DeepestPair& deepest);
  void (*find_forces)(const WallBatch& batch);
};

/// Four at a time for x86-64-v3 and eight for v4; null if not built. Their processors only.
const PairKernel* pair_kernel_v3();
const PairKernel* pair_kernel_v4();

/// What this processor can run, narrowest first: one contact at a time, which is the slow twin of
/// the others, two at a time for any x86-64, and those of the newer processors.
std::vector<const PairKernel*> usable_pair_kernels();
/// The widest of them.
const PairKernel& pair_kernel();

/// One at a time, with what the contacts store and lose added to `sum`; same forces.
void add_forces_with_energies(const PairBatch& batch, DeepestPair& deepest, ExactEnergies& sum);
void find_forces_with_energies(const WallBatch& batch, ExactEnergies& sum);

}  // namespace repose::dem

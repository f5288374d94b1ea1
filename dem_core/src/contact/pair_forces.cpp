#include <algorithm>
#include <array>

#include "contact/contact_evaluation.hpp"
#include "contact/contact_forces.hpp"
#include "contact/pair_kernel.hpp"
#include "parallel/exact_sum.hpp"

namespace repose::dem {
namespace {

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// So many pairs are tested, then those of them that touch go through the law: what the test has
/// asked for has come from memory by then and is not gone again.
constexpr std::size_t kBatch = 128;
constexpr std::size_t kPart = 32;   // pairs between two looks at whether a batch is full
constexpr std::size_t kAhead = 12;  // pairs between asking for a sphere and testing it

static_assert(sizeof(Motion) == 64 && sizeof(Spin) == 32 && sizeof(Load) == 64);

/// What does not change from batch to batch.
PairBatch batch_of(const Box& box, const LawTable& laws, double dt, Spheres& spheres) {
  PairBatch batch{};
  batch.motion = spheres.motion.data()->x.data();
  batch.spin = spheres.spin.data()->w.data();
  batch.load = spheres.load.data()->force.data();
  batch.material = spheres.material.data();
  batch.laws = laws.data();
  batch.materials = laws.materials();
  batch.model = laws.model();
  batch.dt = dt;
  batch.periodic = box.periodic_mask() != 0;
  for (int k = 0; k < 3; ++k) {
    batch.length[k] = box.length[k];
    batch.half[k] = box.half[k];
  }
  return batch;
}

/// Takes touching pairs in list order and puts them through the law, a batch at a time.
class PairForces {
 public:
  PairForces(const PairBatch& batch, ContactPool& pool, const Spheres& spheres,
             DeepestOverlap& deepest, ExactEnergies* energies)
      : batch_(batch), pool_(pool), spheres_(spheres), deepest_(deepest), energies_(energies) {
    batch_.pairs = pairs_.data();
  }

  /// Room for kPart pairs.
  TouchingPair* room() {
    if (batch_.count + kPart > pairs_.size()) compute();
    return pairs_.data() + batch_.count;
  }
  void taken(std::size_t count) { batch_.count += count; }

  void compute() {
    batch_.contacts = pool_.size() == 0 ? nullptr : pool_.data()->history.slip.data();
    DeepestPair deepest{deepest_.ratio(), -1};
    if (energies_ != nullptr)
      compute_with_energies(deepest);
    else
      kernel_.add_forces(batch_, deepest);
    if (deepest.pair >= 0) {
      const TouchingPair& pair = pairs_[static_cast<std::size_t>(deepest.pair)];
      const double radius =
          std::min(spheres_.motion[index(pair.i)].radius, spheres_.motion[index(pair.j)].radius);
      deepest_ = {deepest.ratio * radius, radius, pair.i, pair.j, false};
    }
    batch_.count = 0;
  }

 private:
  void compute_with_energies(DeepestPair& deepest) {
    ExactEnergies of_others;
    PairBatch one = batch_;
    one.count = 1;
    for (std::size_t p = 0; p < batch_.count; ++p) {
      one.pairs = pairs_.data() + p;
      DeepestPair here{deepest.ratio, -1};
      const bool counts = !spheres_.is_ghost(index(pairs_[p].i));
      add_forces_with_energies(one, here, counts ? *energies_ : of_others);
      if (here.pair == 0) deepest = {here.ratio, static_cast<std::ptrdiff_t>(p)};
    }
  }

  const PairKernel& kernel_ = pair_kernel();
  PairBatch batch_;
  ContactPool& pool_;
  const Spheres& spheres_;
  DeepestOverlap& deepest_;
  ExactEnergies* energies_;
  std::array<TouchingPair, kBatch> pairs_;
};

template <int kMask>
void add_forces_in(const Box& box, const Spheres& spheres, NeighborList& pairs, ContactPool& pool,
                   PairForces& forces) {
  const Motion* const motion = spheres.motion.data();
  Neighbor* const entries = pairs.entries.data();
  const std::size_t end = pairs.entries.size();
  for (std::size_t p = 0; p < end;) {
    const std::size_t last = std::min(p + kPart, end);
    TouchingPair* const room = forces.room();
    std::size_t count = 0;
    for (; p < last; ++p) {
      __builtin_prefetch(motion + entries[std::min(p + kAhead, end - 1)].other);
      Neighbor& neighbor = entries[p];
      const Motion& a = motion[neighbor.row];
      const Motion& b = motion[neighbor.other];
      const Vec3 offset = box.nearest_image_in<kMask>(b.x - a.x);
      const double reach = a.radius + b.radius;
      const bool touches = offset.squaredNorm() < reach * reach;
      if (touches != (neighbor.contact != kNoContact)) {
        if (touches) {
          neighbor.contact = pool.begin_contact();
        } else {
          if (!spheres.is_ghost(index(neighbor.row))) pool.count_released(neighbor.contact);
          pool.end_contact(neighbor.contact);
          neighbor.contact = kNoContact;
        }
      }
      // Written for each pair and kept if it touches: a branch would often be guessed wrong.
      room[count] = {neighbor.row, neighbor.other, neighbor.contact};
      count += touches ? 1 : 0;
      const std::size_t needed = index(touches ? neighbor.other : neighbor.row);
      __builtin_prefetch(&spheres.spin[needed]);
      __builtin_prefetch(&spheres.load[needed], 1);
      __builtin_prefetch(pool.data() + (touches ? neighbor.contact : 0), 1);
    }
    forces.taken(count);
  }
  forces.compute();
}

}  // namespace

void add_pair_forces(const Box& box, const LawTable& laws, double dt, Spheres& spheres,
                     NeighborList& pairs, ContactPool& pool, DeepestOverlap& deepest,
                     ExactEnergies* energies) {
  if (pairs.entries.empty()) return;
  PairForces forces(batch_of(box, laws, dt, spheres), pool, spheres, deepest, energies);
  with_periodic_mask(box,
                     [&]<int kMask>() { add_forces_in<kMask>(box, spheres, pairs, pool, forces); });
}

std::vector<PairState> pair_states(const Box& box, const LawTable& laws, double dt,
                                   const Spheres& spheres, const NeighborList& pairs,
                                   const ContactPool& pool) {
  std::vector<PairState> states;
  states.reserve(pool.size());
  for (const Neighbor& neighbor : pairs.entries) {
    if (neighbor.contact == kNoContact || spheres.is_ghost(index(neighbor.row))) continue;
    const std::size_t i = index(neighbor.row);
    const std::size_t j = index(neighbor.other);
    const Motion& a = spheres.motion[i];
    const Motion& b = spheres.motion[j];
    const Vec3 offset = box.nearest_image(b.x - a.x);
    const ContactState state =
        contact_state(laws.model(), laws.at(spheres.material[i], spheres.material[j]),
                      sphere_sphere(a.radius, 1.0 / a.inv_mass, b.radius, 1.0 / b.inv_mass),
                      pair_kinematics(laws.model(), dt, offset, offset.norm(), a, b,
                                      spheres.spin[i].w, spheres.spin[j].w),
                      pool.at(neighbor.contact).history);
    states.push_back({neighbor.row, neighbor.other, state});
  }
  return states;
}

}  // namespace repose::dem

// A number that stands for all bits of a state.
#include <bit>

#include "checkpoint/contact_records.hpp"
#include "simulation_state.hpp"

namespace repose::dem {
namespace {

/// The finalizer of SplitMix64 [Steele2014], as one link of a chain of words.
std::uint64_t mixed(std::uint64_t chain, std::uint64_t word) {
  std::uint64_t z = (chain ^ word) + 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

std::uint64_t mixed(std::uint64_t chain, std::int32_t id) {
  return mixed(chain, static_cast<std::uint64_t>(id));
}

std::uint64_t mixed(std::uint64_t chain, const Vec3& v) {
  for (int k = 0; k < 3; ++k) chain = mixed(chain, std::bit_cast<std::uint64_t>(v[k]));
  return chain;
}

std::uint64_t mixed(std::uint64_t chain, const Quaternion& q) {
  for (const double c : {q.w, q.x, q.y, q.z}) chain = mixed(chain, std::bit_cast<std::uint64_t>(c));
  return chain;
}

std::uint64_t mixed(std::uint64_t chain, const ContactHistory& history) {
  return mixed(mixed(chain, history.slip), history.rolling);
}

// Beginnings of the chains of different records.
constexpr std::uint64_t kSphere = 1, kClump = 2, kContact = 3, kWallContact = 4;

}  // namespace

/// The sum over all records of hashes, each of the ids and the bits of one record: who holds which
/// record, and in which order, does not matter.
std::uint64_t Simulation::State::hash() {
  std::uint64_t sum =
      domain.communicator().is_root() ? mixed(0, static_cast<std::uint64_t>(steps)) : 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    if (spheres.is_ghost(i)) continue;
    const Motion& motion = spheres.motion[i];
    const std::uint64_t chain = mixed(mixed(kSphere, spheres.id[i]), spheres.body[i]);
    sum += mixed(mixed(mixed(chain, motion.x), motion.v), spheres.spin[i].w);
  }
  for (const Clump& clump : clumps.all) {
    const std::uint64_t chain = mixed(mixed(mixed(kClump, clump.body), clump.x), clump.v);
    sum += mixed(mixed(chain, clump.l), clump.q);
  }
  for (const ContactRecord& contact : contact_records(spheres, lists.pairs, pool))
    sum += mixed(mixed(mixed(kContact, contact.first), contact.second), contact.history);
  for (const WallContact& contact : wall_contacts.all) {
    const std::int32_t id = spheres.id[static_cast<std::size_t>(contact.sphere)];
    const std::uint64_t chain = mixed(mixed(mixed(kWallContact, id), contact.wall), contact.normal);
    sum += mixed(chain, contact.contact.history);
  }
  std::int64_t of_all[1] = {static_cast<std::int64_t>(sum)};
  domain.communicator().add_up(of_all);
  return static_cast<std::uint64_t>(of_all[0]);
}

}  // namespace repose::dem

// Bodies with their contacts on their way from one process to another.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "checkpoint/contact_records.hpp"
#include "contact/wall_contacts.hpp"
#include "parallel/bytes.hpp"
#include "particles/clumps.hpp"

namespace repose::dem {

/// A sphere with all that Spheres holds of it, but for what depends on the place in memory.
struct SphereRecord {
  std::array<double, 3> x, v, w, force, torque;
  double radius, inv_mass, inv_inertia, mass;
  std::uint64_t key;
  std::int32_t id, body, material;
  std::int32_t is_of_clump;
};

struct ClumpRecord {
  std::array<double, 3> x, v, l, inertia, force, torque;
  std::array<double, 4> q;
  double mass, radius;
  std::int32_t body, material, count;
};

struct MemberRecord {
  std::array<double, 3> local, arm;
  std::int32_t sphere;  ///< id
};

struct PairContactRecord {
  std::array<double, 3> slip, rolling;  ///< as the sphere of the smaller id sees them
  double stored_j;
  std::int32_t first, second;  ///< ids, first < second
};

struct WallContactRecord {
  std::array<double, 3> normal, slip, rolling;
  double overlap, stored_j;
  std::int32_t sphere;  ///< id
  std::int32_t patch, wall;
};

/// Bodies with their spheres, and contacts; clumps with their members in this order.
struct Parcel {
  std::vector<SphereRecord> spheres;
  std::vector<ClumpRecord> clumps;
  std::vector<MemberRecord> members;
  std::vector<PairContactRecord> contacts;
  std::vector<WallContactRecord> wall_contacts;

  Bytes packed() const;
};
Parcel unpacked(const Bytes& bytes);

SphereRecord record_of(const Spheres& spheres, std::size_t i);
PairContactRecord record_of(const ContactRecord& contact);
ContactRecord contact_of(const PairContactRecord& record);
WallContactRecord record_of(const WallContact& contact, std::int32_t sphere_id);

/// Puts a clump with its members into the parcel.
void add_clump(const Clump& clump, const Clumps& clumps, const Spheres& spheres, Parcel& parcel);

/// Appends a sphere; `member` as in Spheres.
void append(const SphereRecord& record, std::int32_t member, Spheres& spheres);

/// Appends the bodies of a parcel and their contacts with walls. Spheres and clumps come last; the
/// contacts with walls must be sorted afterwards.
void append_bodies(const Parcel& parcel, Spheres& spheres, Clumps& clumps,
                   WallContacts& wall_contacts);

}  // namespace repose::dem

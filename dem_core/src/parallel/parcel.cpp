#include "parallel/parcel.hpp"

#include <unordered_map>

namespace repose::dem {
namespace {

using Three = std::array<double, 3>;

Three three(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Vec3 vector(const Three& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

Bytes Parcel::packed() const {
  Packer out;
  out.put_all(spheres);
  out.put_all(clumps);
  out.put_all(members);
  out.put_all(contacts);
  out.put_all(wall_contacts);
  return out.take();
}

Parcel unpacked(const Bytes& bytes) {
  Unpacker in(bytes);
  Parcel parcel;
  parcel.spheres = in.get_all<SphereRecord>();
  parcel.clumps = in.get_all<ClumpRecord>();
  parcel.members = in.get_all<MemberRecord>();
  parcel.contacts = in.get_all<PairContactRecord>();
  parcel.wall_contacts = in.get_all<WallContactRecord>();
  return parcel;
}

SphereRecord record_of(const Spheres& s, std::size_t i) {
  return {.x = three(s.motion[i].x),
          .v = three(s.motion[i].v),
          .w = three(s.spin[i].w),
          .force = three(s.load[i].force),
          .torque = three(s.load[i].torque),
          .radius = s.motion[i].radius,
          .inv_mass = s.motion[i].inv_mass,
          .inv_inertia = s.spin[i].inv_inertia,
          .mass = s.mass[i],
          .key = s.key[i],
          .id = s.id[i],
          .body = s.body[i],
          .material = s.material[i],
          .is_of_clump = s.is_of_clump(i) ? 1 : 0};
}

PairContactRecord record_of(const ContactRecord& contact) {
  return {.slip = three(contact.history.slip),
          .rolling = three(contact.history.rolling),
          .stored_j = contact.stored_j,
          .first = contact.first,
          .second = contact.second};
}

ContactRecord contact_of(const PairContactRecord& record) {
  return {
      record.first, record.second, {vector(record.slip), vector(record.rolling)}, record.stored_j};
}

WallContactRecord record_of(const WallContact& contact, std::int32_t sphere_id) {
  return {.normal = three(contact.normal),
          .slip = three(contact.contact.history.slip),
          .rolling = three(contact.contact.history.rolling),
          .overlap = contact.overlap,
          .stored_j = contact.contact.stored_j,
          .sphere = sphere_id,
          .patch = contact.patch,
          .wall = contact.wall};
}

void add_clump(const Clump& clump, const Clumps& clumps, const Spheres& spheres, Parcel& parcel) {
  parcel.clumps.push_back({.x = three(clump.x),
                           .v = three(clump.v),
                           .l = three(clump.l),
                           .inertia = three(clump.inertia),
                           .force = three(clump.force),
                           .torque = three(clump.torque),
                           .q = {clump.q.w, clump.q.x, clump.q.y, clump.q.z},
                           .mass = clump.mass,
                           .radius = clump.radius,
                           .body = clump.body,
                           .material = clump.material,
                           .count = clump.count});
  for (std::int32_t m = clump.first; m < clump.first + clump.count; ++m) {
    const Member& member = clumps.members[static_cast<std::size_t>(m)];
    const auto sphere = static_cast<std::size_t>(member.sphere);
    parcel.spheres.push_back(record_of(spheres, sphere));
    parcel.members.push_back({three(member.local), three(member.arm), spheres.id[sphere]});
  }
}

void append(const SphereRecord& record, std::int32_t member, Spheres& spheres) {
  spheres.add({.motion = {vector(record.x), record.radius, vector(record.v), record.inv_mass},
               .spin = {vector(record.w), record.inv_inertia},
               .material = record.material,
               .id = record.id,
               .body = record.body,
               .member = member,
               .key = record.key,
               .mass = record.mass});
  spheres.load.back().force = vector(record.force);
  spheres.load.back().torque = vector(record.torque);
}

void append_bodies(const Parcel& parcel, Spheres& spheres, Clumps& clumps,
                   WallContacts& wall_contacts) {
  std::unordered_map<std::int32_t, std::int32_t> index_of;
  for (const SphereRecord& record : parcel.spheres) {
    index_of[record.id] = static_cast<std::int32_t>(spheres.size());
    append(record, kAlone, spheres);
  }
  std::size_t next = 0;
  for (const ClumpRecord& record : parcel.clumps) {
    clumps.all.push_back({.x = vector(record.x),
                          .v = vector(record.v),
                          .l = vector(record.l),
                          .q = {record.q[0], record.q[1], record.q[2], record.q[3]},
                          .inertia = vector(record.inertia),
                          .mass = record.mass,
                          .radius = record.radius,
                          .force = vector(record.force),
                          .torque = vector(record.torque),
                          .body = record.body,
                          .material = record.material,
                          .first = static_cast<std::int32_t>(clumps.members.size()),
                          .count = record.count});
    for (std::int32_t m = 0; m < record.count; ++m, ++next) {
      const MemberRecord& member = parcel.members[next];
      const std::int32_t sphere = index_of.at(member.sphere);
      spheres.member[static_cast<std::size_t>(sphere)] =
          static_cast<std::int32_t>(clumps.members.size());
      clumps.members.push_back({sphere, vector(member.local), vector(member.arm)});
    }
  }
  for (const WallContactRecord& record : parcel.wall_contacts)
    wall_contacts.all.push_back({vector(record.normal),
                                 record.overlap,
                                 index_of.at(record.sphere),
                                 record.patch,
                                 record.wall,
                                 {{vector(record.slip), vector(record.rolling)}, record.stored_j}});
}

}  // namespace repose::dem

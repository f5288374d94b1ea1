#include "particles/clumps.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "repose/dem/cross.hpp"

namespace repose::dem {
namespace {

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// Gives the spheres of a clump their places of now and their velocities of half a step before, and
/// takes their loads. Returns the largest squared displacement since the lists were built.
double place(const Box& box, const Clump& clump, const Quaternion& half, const Vec3& spin,
             std::vector<Member>& members, Spheres& spheres) {
  const Eigen::Matrix3d turn = rotation_matrix(clump.q);
  const Eigen::Matrix3d turn_half = rotation_matrix(half);
  double moved2 = 0.0;
  for (std::int32_t m = clump.first; m < clump.first + clump.count; ++m) {
    Member& member = members[index(m)];
    const std::size_t s = index(member.sphere);
    const Vec3 arm = turn * member.local;
    const Vec3 arm_half = turn_half * member.local;
    const Vec3 x = box.wrapped(clump.x + arm);  // not read back: the store would have to end first
    const Vec3 moved = box.nearest_image(x - spheres.x_listed[s]);
    moved2 = std::max(moved2, moved.squaredNorm());
    member.arm = arm;
    spheres.motion[s].x = x;
    spheres.motion[s].v = clump.v + cross(spin, arm_half);
    spheres.spin[s].w = spin;
    spheres.load[s] = {};
  }
  return moved2;
}

/// Appends a clump with its members, and tells the spheres where they now stand.
void append(Clump clump, const std::vector<Member>& members, Clumps& to, Spheres& spheres) {
  const std::int32_t from = clump.first;
  clump.first = static_cast<std::int32_t>(to.members.size());
  for (std::int32_t m = from; m < from + clump.count; ++m) {
    const Member& member = members[index(m)];
    spheres.member[index(member.sphere)] = static_cast<std::int32_t>(to.members.size());
    to.members.push_back(member);
  }
  to.all.push_back(clump);
}

/// The spheres of a clump lie scattered: asks for the places of those some members ahead.
class Ahead {
 public:
  Ahead(const Clumps& clumps, std::size_t distance)
      : members_(clumps.members), distance_(distance) {}
  /// Calls use(sphere) for what follows the members of `clump` at a distance.
  template <class Use>
  void operator()(const Clump& clump, const Use& use) const {
    const std::size_t from = index(clump.first) + distance_;
    const std::size_t to = std::min(from + index(clump.count), members_.size());
    for (std::size_t m = from; m < to; ++m) use(index(members_[m].sphere));
  }

 private:
  const std::vector<Member>& members_;
  std::size_t distance_;
};

}  // namespace

void add_clump(const scene::ClumpForm& form, const scene::Particle& particle, std::int32_t material,
               double density, std::int32_t body, std::int32_t first_sphere_id, const Box& box,
               Clumps& clumps, Spheres& spheres) {
  const double radius = particle.radius_m;
  Clump clump;
  clump.x = particle.position;
  clump.v = particle.velocity;
  clump.q = quaternion_of(particle.orientation_wxyz);
  clump.mass = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius * density;
  clump.inertia = form.inertia * (clump.mass * radius * radius);
  clump.radius = radius;
  const Eigen::Matrix3d turn = rotation_matrix(clump.q);
  clump.l = turn * clump.inertia.cwiseProduct(turn.transpose() * particle.angular_velocity);
  clump.body = body;
  clump.material = material;
  clump.first = static_cast<std::int32_t>(clumps.members.size());
  clump.count = static_cast<std::int32_t>(form.spheres.size());
  double cubes = 0.0;
  for (const auto& sphere : form.spheres) cubes += std::pow(sphere.radius, 3);
  for (std::int32_t k = 0; k < clump.count; ++k) {
    const auto& sphere = form.spheres[index(k)];
    const auto s = static_cast<std::int32_t>(spheres.size());
    // Contacts see the mass of the whole body; the share is for adding up masses of spheres.
    const double share = clump.mass * std::pow(sphere.radius, 3) / cubes;
    spheres.add({.motion = {Vec3::Zero(), radius * sphere.radius, Vec3::Zero(), 1.0 / clump.mass},
                 .material = material,
                 .id = first_sphere_id + k,
                 .body = body,
                 .member = static_cast<std::int32_t>(clumps.members.size()),
                 .mass = share});
    clumps.members.push_back({s, radius * sphere.position, Vec3::Zero()});
  }
  clumps.all.push_back(clump);
  place(box, clump, clump.q, clump.angular_velocity(clump.l), clumps.members, spheres);
}

void gather_loads(const Spheres& spheres, Clumps& clumps) {
  const Ahead ahead(clumps, 64);
  for (Clump& clump : clumps.all) {
    ahead(clump, [&](std::size_t s) { __builtin_prefetch(&spheres.load[s]); });
    Vec3 force(0, 0, 0), torque(0, 0, 0);
    for (std::int32_t m = clump.first; m < clump.first + clump.count; ++m) {
      const Member& member = clumps.members[index(m)];
      const Load& load = spheres.load[index(member.sphere)];
      force += load.force;
      torque += load.torque + cross(member.arm, load.force);
    }
    clump.force = force;
    clump.torque = torque;
  }
}

void kick(const Vec3& gravity, double dt, Clumps& clumps) {
  for (Clump& clump : clumps.all) {
    clump.v += (clump.force * (1.0 / clump.mass) + gravity) * dt;
    clump.l += clump.torque * dt;
  }
}

DriftResult drift(const Box& box, double dt, Clumps& clumps, Spheres& spheres) {
  DriftResult result;
  const Ahead ahead(clumps, 24);
  RotationEnd ends[kRotatingTogether];
  for (std::size_t c = 0; c < clumps.size(); ++c) {
    if (c % kRotatingTogether == 0) {
      RotatingBody bodies[kRotatingTogether];
      for (std::size_t k = 0; k < kRotatingTogether; ++k) {
        const Clump& next = clumps.all[std::min(c + k, clumps.size() - 1)];
        bodies[k] = {next.q, next.l, next.inertia};
      }
      free_rotation(bodies, dt, ends);
    }
    Clump& clump = clumps.all[c];
    ahead(clump, [&](std::size_t s) {
      __builtin_prefetch(&spheres.motion[s], 1);
      __builtin_prefetch(&spheres.spin[s], 1);
      __builtin_prefetch(&spheres.load[s], 1);
      __builtin_prefetch(&spheres.x_listed[s]);
    });
    clump.x += clump.v * dt;
    if (!box.contains(clump.x)) {
      const Vec3 drifted = clump.x;
      clump.x = box.wrapped(drifted);
      result.moved_kg_m.add(clump.mass * (clump.x - drifted));
      if (!box.contains(clump.x) && result.out < 0)
        result.out = clumps.members[index(clump.first)].sphere;
    }
    const RotationEnd& end = ends[c % kRotatingTogether];
    clump.q = end.q;
    result.moved2 =
        std::max(result.moved2, place(box, clump, end.half, end.spin, clumps.members, spheres));
  }
  return result;
}

void follow_order(Spheres& spheres, Clumps& clumps) {
  if (clumps.size() == 0) return;
  for (std::size_t s = 0; s < spheres.size(); ++s)
    if (spheres.member[s] >= 0)
      clumps.members[index(spheres.member[s])].sphere = static_cast<std::int32_t>(s);
  // Clumps in the order of their first sphere, so that neighbors in space are so in memory.
  std::vector<std::pair<std::int32_t, std::size_t>> order;
  order.reserve(clumps.size());
  for (std::size_t c = 0; c < clumps.size(); ++c) {
    std::int32_t first = clumps.members[index(clumps.all[c].first)].sphere;
    for (std::int32_t m = clumps.all[c].first; m < clumps.all[c].first + clumps.all[c].count; ++m)
      first = std::min(first, clumps.members[index(m)].sphere);
    order.emplace_back(first, c);
  }
  std::sort(order.begin(), order.end());
  Clumps sorted;
  sorted.all.reserve(clumps.size());
  sorted.members.reserve(clumps.members.size());
  for (const auto& [first, c] : order) append(clumps.all[c], clumps.members, sorted, spheres);
  clumps = std::move(sorted);
}

void remove_clumps(const std::vector<std::int32_t>& new_index, Spheres& spheres, Clumps& clumps) {
  Clumps kept;
  for (const Clump& clump : clumps.all) {
    if (new_index[index(clumps.members[index(clump.first)].sphere)] < 0) continue;
    for (std::int32_t m = clump.first; m < clump.first + clump.count; ++m) {
      std::int32_t& sphere = clumps.members[index(m)].sphere;
      sphere = new_index[index(sphere)];
    }
    append(clump, clumps.members, kept, spheres);
  }
  clumps = std::move(kept);
}

}  // namespace repose::dem

// The spheres of a simulation: hot records in the order of the last neighbor search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "repose/dem/contact_law.hpp"

namespace repose::dem {

/// What finding contacts and most of a contact needs; one cache line.
struct alignas(64) Motion {
  Vec3 x;           ///< centre at t, inside the domain
  double radius;    ///< m
  Vec3 v;           ///< at t - dt/2 between steps, at t + dt/2 while forces are computed
  double inv_mass;  ///< of the whole body
};

struct alignas(32) Spin {
  Vec3 w;  ///< rad/s, at the times of Motion::v
  double inv_inertia;
};

/// Sum of contact forces and torques at t; gravity is not in it.
struct alignas(64) Load {
  Vec3 force = Vec3::Zero();
  double unused_a = 0.0;  ///< so that rows of four are aligned
  Vec3 torque = Vec3::Zero();
  double unused_b = 0.0;
};

/// What stands in Spheres::member of a sphere that no clump here holds.
inline constexpr std::int32_t kAlone = -1;         ///< a body of one sphere
inline constexpr std::int32_t kGhost = -2;         ///< such a body, of another process
inline constexpr std::int32_t kGhostOfClump = -3;  ///< a sphere of a clump of another process

/// A sphere to be added.
struct NewSphere {
  Motion motion;
  Spin spin{Vec3::Zero(), 0.0};
  std::int32_t material = 0;
  std::int32_t id = 0;
  std::int32_t body = 0;
  std::int32_t member = kAlone;
  std::uint64_t key = 0;
  double mass = 0.0;
};

struct Spheres {
  std::vector<Motion> motion;
  std::vector<Spin> spin;
  std::vector<Load> load;
  std::vector<Vec3> x_listed;  ///< centres when the neighbor lists were built
  std::vector<std::int32_t> material;
  std::vector<std::int32_t> id;
  std::vector<std::int32_t> body;    ///< id of the rigid body that it belongs to
  std::vector<std::int32_t> member;  ///< index into Clumps::members, or kAlone and the like
  std::vector<double> mass;          ///< share of its body's
  std::vector<std::uint64_t> key;    ///< orders spheres, ties by id; see order_by_place()

  std::size_t size() const { return motion.size(); }
  bool is_alone(std::size_t i) const { return member[i] == kAlone; }
  bool is_ghost(std::size_t i) const { return member[i] <= kGhost; }
  bool is_of_clump(std::size_t i) const { return member[i] >= 0 || member[i] == kGhostOfClump; }

  void add(const NewSphere& sphere) {
    motion.push_back(sphere.motion);
    spin.push_back(sphere.spin);
    load.push_back({});
    x_listed.push_back(sphere.motion.x);
    material.push_back(sphere.material);
    id.push_back(sphere.id);
    body.push_back(sphere.body);
    member.push_back(sphere.member);
    mass.push_back(sphere.mass);
    key.push_back(sphere.key);
  }

  /// Keeps the spheres order[0], order[1], ... in this order.
  void select(const std::vector<std::int32_t>& order);
};

}  // namespace repose::dem

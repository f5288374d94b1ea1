// Rigid bodies of several spheres: their state, and how it moves the spheres.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "particles/integration.hpp"
#include "particles/rotation.hpp"
#include "repose/scene/clump_form.hpp"

namespace repose::dem {

struct Clump {
  Vec3 x;        ///< centre of mass at t
  Vec3 v;        ///< at t - dt/2 between steps, as that of spheres
  Vec3 l;        ///< angular momentum about the centre, world axes, at the time of v
  Quaternion q;  ///< principal axes at t
  Vec3 inertia;  ///< principal moments, kg m^2
  double mass;
  double radius;         ///< of the sphere of its volume, m
  Vec3 force{0, 0, 0};   ///< sum over its spheres at t
  Vec3 torque{0, 0, 0};  ///< about the centre
  std::int32_t body;     ///< id
  std::int32_t material;
  std::int32_t first = 0;  ///< members [first, first + count)
  std::int32_t count = 0;

  /// World axes, of an angular momentum at the present orientation.
  Vec3 angular_velocity(const Vec3& angular_momentum) const {
    const Eigen::Matrix3d r = rotation_matrix(q);
    return r * (r.transpose() * angular_momentum).cwiseQuotient(inertia);
  }
};

/// A sphere of a clump.
struct Member {
  std::int32_t sphere;  ///< its index now
  Vec3 local;           ///< from the centre, principal axes, m
  Vec3 arm;             ///< the same in world axes at t
};

struct Clumps {
  std::vector<Clump> all;
  std::vector<Member> members;

  std::size_t size() const { return all.size(); }
};

/// Adds a clump with its spheres, at rest relative to its centre's motion; spheres get the ids that
/// follow those present.
void add_clump(const scene::ClumpForm& form, const scene::Particle& particle, std::int32_t material,
               double density, std::int32_t body, std::int32_t first_sphere_id, const Box& box,
               Clumps& clumps, Spheres& spheres);

/// Sums the loads of the spheres on their clumps.
void gather_loads(const Spheres& spheres, Clumps& clumps);

/// v += (F/m + g) dt, l += T dt with the gathered loads.
void kick(const Vec3& gravity, double dt, Clumps& clumps);

/// x += v dt, the orientation follows the angular momentum; then the spheres take their places from
/// their clump, and velocities that belong to the orientation of the half step. A clump is out if
/// its centre is.
DriftResult drift(const Box& box, double dt, Clumps& clumps, Spheres& spheres);

/// After the spheres were sorted: finds the members again and puts the clumps into their order.
void follow_order(Spheres& spheres, Clumps& clumps);

/// After spheres were taken out: leaves their clumps out too and finds the members of the others.
/// new_index gives the index of a sphere now, or -1.
void remove_clumps(const std::vector<std::int32_t>& new_index, Spheres& spheres, Clumps& clumps);

}  // namespace repose::dem

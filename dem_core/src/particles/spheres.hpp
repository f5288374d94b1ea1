// The spheres of a simulation: hot records in the order of the last neighbor search.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "repose/dem/contact_law.hpp"

namespace repose::dem {

/// What finding contacts and most of a contact needs; one cache line.
struct alignas(64) Motion {
  Vec3 x;         ///< centre at t, inside the domain
  double radius;  ///< m
  Vec3 v;         ///< at t - dt/2 between steps, at t + dt/2 while forces are computed
  double inv_mass;
};

struct Spin {
  Vec3 w;  ///< rad/s, at the times of Motion::v
  double inv_inertia;
};

/// Sum of contact forces and torques at t; gravity is not in it.
struct Load {
  Vec3 force;
  Vec3 torque;
};

struct Spheres {
  std::vector<Motion> motion;
  std::vector<Spin> spin;
  std::vector<Load> load;
  std::vector<Vec3> x_listed;  ///< centres when the neighbor lists were built
  std::vector<std::int32_t> material;
  std::vector<std::int32_t> id;
  std::vector<double> mass;

  std::size_t size() const { return motion.size(); }
};

}  // namespace repose::dem

// Kick and drift: leapfrog with positions at t and velocities at t + dt/2.
#pragma once

#include "geometry/box.hpp"
#include "parallel/exact_sum.hpp"
#include "particles/spheres.hpp"

namespace repose::dem {

/// v += (F/m + g) dt, w += T/I dt with the loads at t, for bodies of one sphere of this process.
void kick(const Vec3& gravity, double dt, Spheres& spheres);

/// What became of the spheres in a drift.
struct DriftResult {
  /// Sum over those that crossed a periodic side of mass times the way they were moved back.
  ExactVectorSum moved_kg_m;
  double moved2 = 0.0;      ///< largest squared displacement since the lists were built
  std::ptrdiff_t out = -1;  ///< first sphere that left the domain or has no finite position, or -1
};

/// kick(), then x += v dt with images wrapped into the domain, for bodies of one sphere; sets their
/// loads to zero. One pass over memory instead of two.
DriftResult kick_and_drift(const Box& box, const Vec3& gravity, double dt, Spheres& spheres);

}  // namespace repose::dem

#include "particles/rotation.hpp"

namespace repose::dem {
namespace {

/// Turns the body about its axis k for a time dt; p is the angular momentum in body axes.
template <int k>
[[gnu::always_inline]] inline void turn_about(double dt, const Vec3& inertia, Vec3& p,
                                              Quaternion& q) {
  const double t = 0.25 * dt * p[k] / inertia[k];
  const double scale = 1.0 / (1.0 + t * t);
  const double c = (1.0 - t * t) * scale;  // of half the angle
  const double s = 2.0 * t * scale;
  const double cos_all = c * c - s * s;
  const double sin_all = 2.0 * c * s;
  constexpr int a = (k + 1) % 3;
  constexpr int b = (k + 2) % 3;
  const double pa = p[a];
  p[a] = cos_all * pa + sin_all * p[b];
  p[b] = cos_all * p[b] - sin_all * pa;
  Quaternion turn{c, 0.0, 0.0, 0.0};
  (k == 0 ? turn.x : k == 1 ? turn.y : turn.z) = s;
  q = q * turn;
}

}  // namespace

Quaternion free_rotation(const Quaternion& q, const Vec3& angular_momentum, const Vec3& inertia,
                         double dt) {
  Vec3 p = rotation_matrix(q).transpose() * angular_momentum;
  Quaternion turned = q;
  turn_about<2>(0.5 * dt, inertia, p, turned);
  turn_about<1>(0.5 * dt, inertia, p, turned);
  turn_about<0>(dt, inertia, p, turned);
  turn_about<1>(0.5 * dt, inertia, p, turned);
  turn_about<2>(0.5 * dt, inertia, p, turned);
  return normalised(turned);
}

}  // namespace repose::dem

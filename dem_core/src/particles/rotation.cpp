#include "particles/rotation.hpp"

#include "contact/pack.hpp"
#include "particles/rotation_lanes.hpp"

namespace repose::dem {
namespace {

using detail::Lanes3;
using detail::QuaternionLanes;

QuaternionLanes<double> lanes_of(const Quaternion& q) {
  return {q.w, q.x, q.y, q.z};
}
Quaternion quaternion_of(const QuaternionLanes<double>& q) {
  return {q.w, q.x, q.y, q.z};
}
Lanes3<double> lanes_of(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

constexpr std::size_t kPack = 2;
using Two = detail::Pack<kPack>;

Two both(double a, double b) {
  Two two(a);
  two.lanes[1] = b;
  return two;
}
Lanes3<Two> both(const Vec3& a, const Vec3& b) {
  return {both(a.x(), b.x()), both(a.y(), b.y()), both(a.z(), b.z())};
}
QuaternionLanes<Two> both(const Quaternion& a, const Quaternion& b) {
  return {both(a.w, b.w), both(a.x, b.x), both(a.y, b.y), both(a.z, b.z)};
}
Quaternion lane_of(const QuaternionLanes<Two>& q, std::size_t k) {
  return {lane(q.w, k), lane(q.x, k), lane(q.y, k), lane(q.z, k)};
}
Vec3 lane_of(const Lanes3<Two>& v, std::size_t k) {
  return {lane(v.x, k), lane(v.y, k), lane(v.z, k)};
}

}  // namespace

Quaternion free_rotation(const Quaternion& q, const Vec3& angular_momentum, const Vec3& inertia,
                         double dt) {
  return quaternion_of(
      detail::RotationStep<double>(lanes_of(q), lanes_of(angular_momentum), lanes_of(inertia), dt)
          .end);
}

void free_rotation(const RotatingBody (&bodies)[kRotatingTogether], double dt,
                   RotationEnd (&ends)[kRotatingTogether]) {
  static_assert(kRotatingTogether == 2 * kPack);
  for (std::size_t first = 0; first < kRotatingTogether; first += kPack) {
    const RotatingBody &a = bodies[first], &b = bodies[first + 1];
    const detail::RotationStep<Two> step(both(a.q, b.q), both(a.l, b.l), both(a.inertia, b.inertia),
                                         dt);
    for (std::size_t k = 0; k < kPack; ++k)
      ends[first + k] = {lane_of(step.end, k), lane_of(step.half, k), lane_of(step.spin, k)};
  }
}

}  // namespace repose::dem

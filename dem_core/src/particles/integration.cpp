#include "particles/integration.hpp"

#include <algorithm>

namespace repose::dem {
namespace {

/// Brings a sphere that crossed a periodic side back in; its listed position moves with it. False
/// if it is outside all the same.
bool wrap(const Box& box, Vec3& x, Vec3& listed) {
  const Vec3 inside = box.wrapped(x);
  listed += inside - x;
  x = inside;
  return box.contains(x);
}

}  // namespace

void kick(const Vec3& gravity, double dt, Spheres& spheres) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    if (spheres.member[i] >= 0) continue;
    Motion& sphere = spheres.motion[i];
    sphere.v += (spheres.load[i].force * sphere.inv_mass + gravity) * dt;
    spheres.spin[i].w += spheres.load[i].torque * (spheres.spin[i].inv_inertia * dt);
  }
}

DriftResult drift(const Box& box, double dt, Spheres& spheres) {
  DriftResult result;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    if (spheres.member[i] >= 0) continue;
    Motion& sphere = spheres.motion[i];
    sphere.x += sphere.v * dt;
    if (!box.contains(sphere.x) && !wrap(box, sphere.x, spheres.x_listed[i]) && result.out < 0)
      result.out = static_cast<std::ptrdiff_t>(i);
    result.moved2 = std::max(result.moved2, (sphere.x - spheres.x_listed[i]).squaredNorm());
    spheres.load[i] = {Vec3::Zero(), Vec3::Zero()};
  }
  return result;
}

}  // namespace repose::dem

#include "particles/integration.hpp"

#include <algorithm>

namespace repose::dem {
namespace {

/// Brings a sphere that crossed a periodic side back in; its listed position moves with it. False
/// if it is outside all the same.
bool wrap(const Box& box, double mass, Vec3& x, Vec3& listed, ExactVectorSum& moved_kg_m) {
  const Vec3 inside = box.wrapped(x);
  const Vec3 shift = inside - x;
  listed += shift;
  moved_kg_m.add(mass * shift);
  x = inside;
  return box.contains(x);
}

[[gnu::always_inline]] inline void kick(const Vec3& gravity, double dt, const Load& load,
                                        Motion& sphere, Spin& spin) {
  sphere.v += (load.force * sphere.inv_mass + gravity) * dt;
  spin.w += load.torque * (spin.inv_inertia * dt);
}

}  // namespace

void kick(const Vec3& gravity, double dt, Spheres& spheres) {
  for (std::size_t i = 0; i < spheres.size(); ++i)
    if (spheres.is_alone(i)) kick(gravity, dt, spheres.load[i], spheres.motion[i], spheres.spin[i]);
}

DriftResult kick_and_drift(const Box& box, const Vec3& gravity, double dt, Spheres& spheres) {
  DriftResult result;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    if (!spheres.is_alone(i)) continue;
    Motion& sphere = spheres.motion[i];
    kick(gravity, dt, spheres.load[i], sphere, spheres.spin[i]);
    sphere.x += sphere.v * dt;
    if (!box.contains(sphere.x) &&
        !wrap(box, spheres.mass[i], sphere.x, spheres.x_listed[i], result.moved_kg_m) &&
        result.out < 0)
      result.out = static_cast<std::ptrdiff_t>(i);
    result.moved2 = std::max(result.moved2, (sphere.x - spheres.x_listed[i]).squaredNorm());
    spheres.load[i] = {};
  }
  return result;
}

}  // namespace repose::dem

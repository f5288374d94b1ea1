// Cases of one or two spheres, built in code, for tests of the engine.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "repose/dem/simulation.hpp"

namespace repose::dem {

/// Properties of "grain" and of "wall", which differ only in stiffness.
struct OneMaterial {
  double density = 2500.0;
  double youngs_modulus = 1e8;
  double poissons_ratio = 0.25;
  double restitution = 0.5;
  double mu_s = 0.0;
  double mu_r = 0.0;
  double rolling_damping = 0.3;
  double wall_stiffness = 1.0;  ///< of the grain's Young's modulus
};

/// An empty domain of 20 m without gravity.
inline scene::Case empty_case(const OneMaterial& m) {
  scene::Case c;
  c.gravity_m_s2.setZero();
  c.lower_m.setConstant(-10.0);
  c.upper_m.setConstant(10.0);
  c.materials = {{"grain", m.density, m.youngs_modulus, m.poissons_ratio},
                 {"wall", m.density, m.youngs_modulus * m.wall_stiffness, m.poissons_ratio}};
  c.pairs = {{"grain", "grain", m.restitution, m.mu_s, m.mu_r, m.rolling_damping},
             {"grain", "wall", m.restitution, m.mu_s, m.mu_r, m.rolling_damping}};
  return c;
}

/// The plane z = 0.
inline scene::Wall floor_plane() {
  scene::Wall wall;
  wall.name = "floor";
  wall.material = "wall";
  wall.shape = scene::Plane{.normal = {0.0, 0.0, 1.0}};
  return wall;
}

inline scene::Wall rectangle(const std::string& name, const Vec3& origin, const Vec3& u,
                             const Vec3& v) {
  scene::Wall wall;
  wall.name = name;
  wall.material = "wall";
  wall.shape = scene::Rectangle{origin, u, v};
  return wall;
}

/// Spheres of "material" as one layer.
inline scene::Layer layer_of(const std::string& material, double mass_kg,
                             const std::vector<scene::SizeClass>& sizes) {
  return {mass_kg, {{.material = material, .sizes = sizes}}};
}

inline scene::Particle grain(double radius, const Vec3& position,
                             const Vec3& velocity = Vec3::Zero(),
                             const Vec3& angular_velocity = Vec3::Zero()) {
  return {"grain", position, velocity, angular_velocity, radius};
}

inline double sphere_mass(double radius, double density) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius * density;
}

/// Closed forms of an elastic Hertz impact [Johnson1985, section 11.4].
struct HertzImpact {
  double largest_overlap, largest_force, duration;
};
inline HertzImpact hertz_impact(double e_eff, double r_eff, double m_eff, double speed) {
  const double d = std::pow(15.0 * m_eff * speed * speed / (16.0 * std::sqrt(r_eff) * e_eff), 0.4);
  return {d, 4.0 / 3.0 * e_eff * std::sqrt(r_eff) * std::pow(d, 1.5), 2.943275 * d / speed};
}

/// Static overlap of a sphere that carries `force`.
inline double hertz_overlap(double e_eff, double r_eff, double force) {
  return std::pow(0.75 * force / (e_eff * std::sqrt(r_eff)), 2.0 / 3.0);
}

}  // namespace repose::dem

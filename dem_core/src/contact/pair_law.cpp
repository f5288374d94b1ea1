#include "repose/dem/pair_law.hpp"

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>

#include "repose/dem/detail/law_lanes.hpp"

namespace repose::dem {
namespace {

double shear_modulus(const scene::Material& m) {
  return m.youngs_modulus_pa / (2.0 * (1.0 + m.poissons_ratio));
}

/// The root of a monotonic function with a change of sign in [lower, upper].
template <class Function>
double root(Function function, double lower, double upper) {
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      function, lower, upper, boost::math::tools::eps_tolerance<double>(50), iterations);
  return 0.5 * (bracket.first + bracket.second);
}

}  // namespace

double damping_ratio(double restitution) {
  const double log_e = std::log(restitution);
  return -log_e / std::hypot(log_e, std::numbers::pi);
}

double clipped_damping_ratio(double restitution) {
  const double half_log = -0.5 * std::log(restitution);  // theta cot theta, or a coth a
  if (!(half_log > 0.0)) return 0.0;
  if (std::abs(half_log - 1.0) < 1e-12) return 1.0;
  if (half_log < 1.0) {
    // With theta = pi/2 - x, whose cosine is exact for small x: (pi/2 - x) tan x rises from 0 to 1.
    const auto residual = [&](double x) {
      const double theta = 0.5 * std::numbers::pi - x;
      return (theta < 1e-9 ? 1.0 : theta * std::tan(x)) - half_log;
    };
    return std::sin(root(residual, 0.0, 0.5 * std::numbers::pi));
  }
  // a coth a > a, and a coth a <= 1 + a.
  const auto residual = [&](double a) { return a / std::tanh(a) - half_log; };
  return std::cosh(root(residual, half_log - 1.0, half_log));
}

PairLaw make_pair_law(const scene::Material& first, const scene::Material& second,
                      const scene::PairCoefficients& pair, const scene::ContactModel& model) {
  const auto normal_compliance = [](const scene::Material& m) {
    return (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus_pa;
  };
  const auto shear_compliance = [](const scene::Material& m) {
    return (2.0 - m.poissons_ratio) / shear_modulus(m);
  };
  PairLaw law;
  law.e_eff = 1.0 / (normal_compliance(first) + normal_compliance(second));
  law.g_eff = 1.0 / (shear_compliance(first) + shear_compliance(second));
  law.beta = model.tail == scene::Tail::clip ? clipped_damping_ratio(pair.restitution)
                                             : damping_ratio(pair.restitution);
  law.mu_s = pair.mu_s;
  law.mu_r = pair.mu_r;
  const double factor = 2.0 * std::sqrt(5.0 / 6.0) * law.beta;
  law.gamma_n = factor * std::sqrt(2.0 * law.e_eff);
  law.gamma_t = factor * std::sqrt(8.0 * law.g_eff);
  law.rolling_k = model.rolling_stiffness == scene::RollingStiffness::kt
                      ? 8.0 * law.g_eff
                      : 3.0 * law.e_eff * pair.mu_r * pair.mu_r;
  law.rolling_c = 2.0 * pair.rolling_damping * std::sqrt(law.rolling_k);
  law.cohesion = pair.cohesion_energy_density_j_m3;
  return law;
}

double rayleigh_time_s(const scene::Material& material, double radius_m) {
  return std::numbers::pi * radius_m * std::sqrt(material.density_kg_m3 / shear_modulus(material)) /
         (0.1631 * material.poissons_ratio + 0.8766);
}

ContactBodies sphere_sphere(double r_i, double m_i, double r_j, double m_j) {
  const auto bodies = detail::bodies_of_pair(r_i, 1.0 / m_i, r_j, 1.0 / m_j);
  return {bodies.r_eff, bodies.m_eff, bodies.i_roll};
}

ContactBodies sphere_wall(double r_i, double m_i) {
  return {r_i, m_i, 1.4 * m_i * r_i * r_i};
}

}  // namespace repose::dem

#include <cmath>
#include <numbers>

#include "repose/dem/contact_law.hpp"

namespace repose::dem {
namespace {

double shear_modulus(const scene::Material& m) {
  return m.youngs_modulus_pa / (2.0 * (1.0 + m.poissons_ratio));
}

}  // namespace

PairLaw make_pair_law(const scene::Material& first, const scene::Material& second,
                      const scene::PairCoefficients& pair) {
  const auto normal_compliance = [](const scene::Material& m) {
    return (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus_pa;
  };
  const auto shear_compliance = [](const scene::Material& m) {
    return (2.0 - m.poissons_ratio) / shear_modulus(m);
  };
  PairLaw law;
  law.e_eff = 1.0 / (normal_compliance(first) + normal_compliance(second));
  law.g_eff = 1.0 / (shear_compliance(first) + shear_compliance(second));
  const double log_e = std::log(pair.restitution);
  law.beta = -log_e / std::sqrt(log_e * log_e + std::numbers::pi * std::numbers::pi);
  law.mu_s = pair.mu_s;
  law.mu_r = pair.mu_r;
  const double factor = 2.0 * std::sqrt(5.0 / 6.0) * law.beta;
  law.gamma_n = factor * std::sqrt(2.0 * law.e_eff);
  law.gamma_t = factor * std::sqrt(8.0 * law.g_eff);
  law.rolling_k = 3.0 * law.e_eff * pair.mu_r * pair.mu_r;
  law.rolling_c = 2.0 * pair.rolling_damping * std::sqrt(3.0 * law.e_eff) * pair.mu_r;
  return law;
}

double rayleigh_time_s(const scene::Material& material, double radius_m) {
  return std::numbers::pi * radius_m * std::sqrt(material.density_kg_m3 / shear_modulus(material)) /
         (0.1631 * material.poissons_ratio + 0.8766);
}

ContactBodies sphere_sphere(double r_i, double m_i, double r_j, double m_j) {
  const double rolling_i = 1.4 * m_i * r_i * r_i;
  const double rolling_j = 1.4 * m_j * r_j * r_j;
  return {r_i * r_j / (r_i + r_j), m_i * m_j / (m_i + m_j),
          rolling_i * rolling_j / (rolling_i + rolling_j)};
}

ContactBodies sphere_wall(double r_i, double m_i) {
  return {r_i, m_i, 1.4 * m_i * r_i * r_i};
}

}  // namespace repose::dem

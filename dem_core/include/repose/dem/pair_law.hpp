// What a contact needs to know of its materials and bodies, computed once.
#pragma once

#include "repose/scene/contact_model.hpp"

namespace repose::dem {

/// What the law needs of a pair of materials under one contact model. Units SI.
struct alignas(32) PairLaw {
  double e_eff = 0.0;      ///< 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j
  double g_eff = 0.0;      ///< 1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j
  double beta = 0.0;       ///< damping ratio: damping_ratio(e), or clipped_damping_ratio(e)
  double mu_s = 0.0;       ///< sliding friction
  double mu_r = 0.0;       ///< rolling friction
  double gamma_n = 0.0;    ///< 2 sqrt(5/6) beta sqrt(2 E*): damping is gamma_n sqrt(a m*)
  double gamma_t = 0.0;    ///< 2 sqrt(5/6) beta sqrt(8 G*)
  double rolling_k = 0.0;  ///< k_r is rolling_k a R*^2: 3 E* mu_r^2 (Ai), or 8 G* (kt)
  double rolling_c = 0.0;  ///< 2 eta_r sqrt(rolling_k): C_r is rolling_c R* sqrt(a I_r)
  double cohesion = 0.0;   ///< J/m^3: attraction per area of intersection
};

PairLaw make_pair_law(const scene::Material& first, const scene::Material& second,
                      const scene::PairCoefficients& pair, const scene::ContactModel& model = {});

/// Damping ratio beta of a Hertz contact whose restitution is e in (0, 1], the attraction before
/// separation kept: -ln e / sqrt(ln^2 e + pi^2) [Tsuji1992], [Antypov2011].
double damping_ratio(double restitution);
/// The same with the force clipped at F_n >= 0. In u = d^(5/4), ds = d^(1/4) dt the contact is the
/// linear oscillator u'' + sqrt5 beta u' + (5/4) u = 0 [Antypov2011] of damping ratio beta, whose
/// force vanishes first where u'' = 0; hence e = exp(-2 theta cot theta) with beta = cos theta, and
/// e = exp(-2 a coth a) with beta = cosh a below e = exp(-2). Relative error below 1e-12.
double clipped_damping_ratio(double restitution);

/// Rayleigh time of a sphere, pi R sqrt(rho/G) / (0.1631 nu + 0.8766); a stable time
/// step is 0.1 to 0.3 of it.
double rayleigh_time_s(const scene::Material& material, double radius_m);

/// What does not change while two bodies touch.
struct ContactBodies {
  double r_eff = 0.0;   ///< R_i R_j / (R_i + R_j), R_i at a wall
  double m_eff = 0.0;   ///< m_i m_j / (m_i + m_j), m_i at a wall
  double i_roll = 0.0;  ///< 1 / (1/(1.4 m_i R_i^2) + 1/(1.4 m_j R_j^2)), 1.4 m_i R_i^2 at a wall
};
ContactBodies sphere_sphere(double r_i, double m_i, double r_j, double m_j);
ContactBodies sphere_wall(double r_i, double m_i);

}  // namespace repose::dem

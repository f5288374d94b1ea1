// The contact law "hm1": Hertz-Mindlin with displacement history and rolling friction of type C.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "repose/scene/case.hpp"

namespace repose::dem {

using Vec3 = Eigen::Vector3d;

/// What the law needs of a pair of materials, computed once. Units SI.
struct PairLaw {
  double e_eff = 0.0;      ///< 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j
  double g_eff = 0.0;      ///< 1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j
  double beta = 0.0;       ///< -ln e / sqrt(ln^2 e + pi^2), [Tsuji1992], [Antypov2011]
  double mu_s = 0.0;       ///< sliding friction
  double mu_r = 0.0;       ///< rolling friction
  double gamma_n = 0.0;    ///< 2 sqrt(5/6) beta sqrt(2 E*): damping is gamma_n sqrt(a m*)
  double gamma_t = 0.0;    ///< 2 sqrt(5/6) beta sqrt(8 G*)
  double rolling_k = 0.0;  ///< 3 E* mu_r^2: k_r is rolling_k a R*^2
  double rolling_c = 0.0;  ///< 2 eta_r sqrt(3 E*) mu_r: C_r is rolling_c R* sqrt(a I_r)
};

PairLaw make_pair_law(const scene::Material& first, const scene::Material& second,
                      const scene::PairCoefficients& pair);

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

/// What a contact remembers from step to step; both are tangential, of i relative to j.
struct ContactHistory {
  Vec3 slip = Vec3::Zero();     ///< displacement xi of the tangential spring, m
  Vec3 rolling = Vec3::Zero();  ///< torque of the rolling spring, N m
};

/// The contact at this instant. The normal points from i to j.
struct ContactKinematics {
  Vec3 normal;
  double overlap;  ///< > 0
  Vec3 velocity;   ///< of i's surface relative to j's at the contact point, m/s
  Vec3 spin;       ///< angular velocity of i relative to j (of i at a wall), rad/s
};

struct ContactForce {
  Vec3 force;           ///< on i, all parts; on j its opposite
  Vec3 tangential;      ///< the tangential part of `force`
  Vec3 rolling_torque;  ///< on i; on j its opposite
};

namespace detail {

/// Projects `v` into the plane normal to `n` and restores its length.
[[gnu::always_inline]] inline void turn_into_plane(Vec3& v, const Vec3& n) {
  const double before = v.squaredNorm();
  if (before == 0.0) return;
  v -= v.dot(n) * n;
  const double after = v.squaredNorm();
  if (after > 0.0) v *= std::sqrt(before / after);
}

/// Rolling friction of type C [Ai2011, model C]: a spring-dashpot on the relative rolling, with
/// k_r = 2.25 k_n (mu_r R*)^2; limited to mu_r R* |F_n|, without damping once it is mobilised.
[[gnu::always_inline]] inline Vec3 rolling_torque(const PairLaw& law, const ContactBodies& bodies,
                                                  double a, double normal_force,
                                                  const ContactKinematics& now, double dt,
                                                  Vec3& torque) {
  const Vec3 rolling = now.spin - now.spin.dot(now.normal) * now.normal;
  turn_into_plane(torque, now.normal);
  torque += (law.rolling_k * a * bodies.r_eff * bodies.r_eff * dt) * rolling;
  const double limit = law.mu_r * bodies.r_eff * std::abs(normal_force);
  const double size2 = torque.squaredNorm();
  if (size2 > limit * limit) {
    torque *= limit / std::sqrt(size2);
    return -torque;
  }
  const double damping = law.rolling_c * bodies.r_eff * std::sqrt(a * bodies.i_roll);
  return -torque - damping * rolling;
}

}  // namespace detail

/// One contact over one step dt; `history` goes in as of the last step and comes out as of now
/// (with dt = 0 it only turns). With contact radius a = sqrt(R* d), S_n = 2 E* a and S_t = 8 G* a:
///   F_n = (4/3) E* a d + 2 sqrt(5/6) beta sqrt(S_n m*) v_n,  v_n > 0 approaching; the attraction
///         that damping causes just before separation is kept, so that e is exact [Antypov2011]
///   xi += v_t dt after xi was turned into the new tangent plane with its length kept
///   F_t = -S_t xi - 2 sqrt(5/6) beta sqrt(S_t m*) v_t     while S_t |xi| <= mu |F_n|, else
///   F_t = -mu |F_n| xi/|xi|, and xi is shortened to |F_t|/S_t.
[[gnu::always_inline]] inline ContactForce hertz_mindlin(const PairLaw& law,
                                                         const ContactBodies& bodies,
                                                         const ContactKinematics& now, double dt,
                                                         ContactHistory& history) {
  const Vec3& n = now.normal;
  const double a = std::sqrt(bodies.r_eff * now.overlap);
  const double damping_scale = std::sqrt(a * bodies.m_eff);
  const double approach = now.velocity.dot(n);
  const double normal_force =
      (4.0 / 3.0) * law.e_eff * a * now.overlap + law.gamma_n * damping_scale * approach;
  const double limit = law.mu_s * std::abs(normal_force);

  const Vec3 sliding = now.velocity - approach * n;
  Vec3& xi = history.slip;
  detail::turn_into_plane(xi, n);
  xi += sliding * dt;
  const double stiffness = 8.0 * law.g_eff * a;
  const double xi2 = xi.squaredNorm();
  ContactForce result;
  if (stiffness * stiffness * xi2 > limit * limit) {
    xi *= limit / (stiffness * std::sqrt(xi2));
    result.tangential = -stiffness * xi;
  } else {
    result.tangential = -stiffness * xi - (law.gamma_t * damping_scale) * sliding;
  }
  result.force = result.tangential - normal_force * n;
  result.rolling_torque = law.mu_r > 0.0 ? detail::rolling_torque(law, bodies, a, normal_force, now,
                                                                  dt, history.rolling)
                                         : Vec3(Vec3::Zero());
  return result;
}

}  // namespace repose::dem

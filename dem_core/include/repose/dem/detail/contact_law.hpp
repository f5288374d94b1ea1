// The bodies of contact_law.hpp: between Eigen's vectors and the law in lanes.
#pragma once

#include "repose/dem/contact_law.hpp"
#include "repose/dem/detail/law_lanes.hpp"

namespace repose::dem {
namespace detail {

[[gnu::always_inline]] inline Lanes3<double> lanes(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
[[gnu::always_inline]] inline Vec3 vec3(const Lanes3<double>& v) {
  return {v.x, v.y, v.z};
}
[[gnu::always_inline]] inline LawLanes<double> lanes(const PairLaw& law) {
  return {law.e_eff,   law.g_eff,     law.mu_s,      law.mu_r,    law.gamma_n,
          law.gamma_t, law.rolling_k, law.rolling_c, law.cohesion};
}

}  // namespace detail

inline double cohesion_area(double r_eff, double overlap, double inv_distance) {
  return detail::intersection_area(r_eff, overlap, inv_distance);
}

template <class Energies>
inline ContactForce hertz_mindlin(const scene::ContactModel& model, const PairLaw& law,
                                  const ContactBodies& bodies, const ContactKinematics& now,
                                  double dt, ContactHistory& history, Energies&& energies) {
  using detail::lanes;
  using detail::vec3;
  detail::HistoryLanes<double> in_lanes{lanes(history.slip), lanes(history.rolling)};
  const detail::ForceLanes<double> force =
      detail::contact_law(model, lanes(law), {bodies.r_eff, bodies.m_eff, bodies.i_roll},
                          {lanes(now.normal), lanes(now.normal_half), now.overlap, now.inv_distance,
                           lanes(now.velocity), lanes(now.spin), now.turning},
                          dt, in_lanes, energies);
  history = {vec3(in_lanes.slip), vec3(in_lanes.rolling)};
  return {vec3(force.force), vec3(force.tangential), vec3(force.rolling_torque), force.normal};
}

inline ContactState contact_state(const scene::ContactModel& model, const PairLaw& law,
                                  const ContactBodies& bodies, const ContactKinematics& now,
                                  const ContactHistory& history) {
  ContactHistory turned = history;
  const ContactForce f = hertz_mindlin(model, law, bodies, now, 0.0, turned);
  const double spring =
      8.0 * law.g_eff * std::sqrt(bodies.r_eff * now.overlap) * turned.slip.norm();
  constexpr double kRounding = 1.0 - 1e-9;
  const double limit = law.mu_s * std::abs(f.normal);
  return {now.overlap, f.normal, f.tangential.norm(), limit > 0.0 && spring >= kRounding * limit};
}

}  // namespace repose::dem

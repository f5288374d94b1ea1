// The contact law "hm1" in lanes: see contact_law.hpp for the formulas and their sources.
#pragma once

#include <type_traits>

#include "repose/dem/contact_energies.hpp"
#include "repose/dem/detail/lanes.hpp"
#include "repose/scene/contact_model.hpp"

namespace repose::dem::detail {

/// PairLaw, ContactBodies, ContactHistory, ContactKinematics and ContactForce in lanes.
template <class R>
struct LawLanes {
  R e_eff, g_eff, mu_s, mu_r, gamma_n, gamma_t, rolling_k, rolling_c, cohesion;
};
template <class R>
struct BodiesLanes {
  R r_eff, m_eff, i_roll;
};
template <class R>
struct HistoryLanes {
  Lanes3<R> slip, rolling;
};
template <class R>
struct KinematicsLanes {
  Lanes3<R> normal, normal_half;
  R overlap, inv_distance;
  Lanes3<R> velocity, spin;
  R turning;
};
template <class R>
struct ForceLanes {
  Lanes3<R> force, tangential, rolling_torque;
  R normal;
};

/// One sphere of each pair.
template <class R>
struct SphereLanes {
  Lanes3<R> v;
  Lanes3<R> w;
  R radius, inv_mass;
};

template <class R>
[[gnu::always_inline]] inline BodiesLanes<R> bodies_of_pair(const R& r_i, const R& inv_m_i,
                                                            const R& r_j, const R& inv_m_j) {
  const R i2 = r_i * r_i;
  const R j2 = r_j * r_j;
  return {r_i * r_j / (r_i + r_j), 1.0 / (inv_m_i + inv_m_j),
          1.4 * (i2 * j2) / (inv_m_i * j2 + inv_m_j * i2)};
}

/// Kinematics of two spheres, see pair_kinematics().
template <class R>
[[gnu::always_inline]] inline KinematicsLanes<R> kinematics_of_pair(
    const scene::ContactModel& model, double dt, const Lanes3<R>& offset, const R& distance,
    const SphereLanes<R>& i, const SphereLanes<R>& j) {
  KinematicsLanes<R> now;
  const R both = i.radius + j.radius;
  now.inv_distance = 1.0 / distance;
  now.normal = now.inv_distance * offset;
  now.overlap = both - distance;
  now.velocity = i.v - j.v;
  now.spin = i.w - j.w;
  R overlap_half = now.overlap;
  now.normal_half = now.normal;
  if (model.compatibility == scene::Compatibility::none) {
    const Lanes3<R> offset_half = offset + R(0.5 * dt) * now.velocity;
    const R distance_half = root(squared(offset_half));
    now.normal_half = R(1.0 / distance_half) * offset_half;
    overlap_half = both - distance_half;
  }
  const Lanes3<R> surface =
      R(i.radius - 0.5 * overlap_half) * i.w + R(j.radius - 0.5 * overlap_half) * j.w;
  now.velocity = now.velocity + cross3(surface, now.normal_half);
  now.turning = 0.5 * dot(i.w + j.w, now.normal_half);
  return now;
}

/// Kinematics of a sphere at x and a wall that moves with the twist (velocity, spin), see
/// wall_kinematics().
template <class R>
[[gnu::always_inline]] inline KinematicsLanes<R> kinematics_at_wall(
    double dt, const Lanes3<R>& normal, const R& overlap, const Lanes3<R>& x,
    const SphereLanes<R>& sphere, const Lanes3<R>& velocity, const Lanes3<R>& spin) {
  const R arm = sphere.radius - 0.5 * overlap;
  const Lanes3<R> point = x - R(0.5 * dt) * sphere.v + arm * normal;
  KinematicsLanes<R> now;
  now.normal = normal;
  now.normal_half = normal;
  now.overlap = overlap;
  now.inv_distance = R(0.0);
  now.velocity = sphere.v - (velocity + cross3(spin, point)) + arm * cross3(sphere.w, normal);
  now.spin = sphere.w - spin;
  now.turning = dot(spin, normal);
  return now;
}

template <class R>
[[gnu::always_inline]] inline BodiesLanes<R> bodies_at_wall(const R& radius, const R& inv_mass) {
  const R mass = 1.0 / inv_mass;
  return {radius, mass, 1.4 * mass * radius * radius};
}

/// Projects `v` into the plane normal to `n` and restores its length.
template <class R>
[[gnu::always_inline]] inline void turn_into_plane(Lanes3<R>& v, const Lanes3<R>& n) {
  const R before = squared(v);
  const R out = dot(v, n);
  v = v - out * n;
  const R lost = out * out / before;  // not a number where there is no v: all comparisons fail
  const R little = 1.0 + lost * (0.5 + 0.375 * lost);  // (1 - x)^(-1/2) to x^3 = 1e-15
  R scale = chosen(lost < 1e-5, little, R(1.0));
  const auto much = (lost >= 1e-5) & (lost < 1.0);
  if (any(much)) scale = chosen(much, root(before / squared(v)), scale);
  v = scale * v;
}

/// How tangential vectors follow the contact through a step.
template <class R>
class TurningLanes {
 public:
  [[gnu::always_inline]] TurningLanes(const scene::ContactModel& model,
                                      const KinematicsLanes<R>& now, double dt)
      : project_(model.compatibility == scene::Compatibility::liggghts),
        angle_(now.turning * dt),
        half_(now.normal_half),
        end_(now.normal),
        axis_(R(1.0 / (1.0 + dot(now.normal, now.normal_half))) * (now.normal + now.normal_half)) {}

  /// `v`, tangential at half step, at the end: turned by the smallest rotation between the normals.
  [[gnu::always_inline]] Lanes3<R> at_end(const Lanes3<R>& v) const {
    return v - dot(v, end_) * axis_;
  }
  /// Adds an `increment`, tangential at half step, to a history and takes that to the end.
  [[gnu::always_inline]] void add(const Lanes3<R>& increment, Lanes3<R>& history) const {
    if (project_) {
      history = history + increment;
      history = history - dot(history, end_) * end_;
    } else {
      turn_into_plane(history, half_);
      const R across = angle_ * (1.0 - angle_ * angle_ / 6.0);  // the length is kept to angle^4
      history = history + (across * cross3(half_, history) - (0.5 * angle_ * angle_) * history);
      history = at_end(history + increment);
    }
  }

 private:
  bool project_;
  R angle_;  // about the normal within the step
  Lanes3<R> half_, end_, axis_;
};

/// What a spring k x^2 / 2 gives away in a step beyond its work, when x went from `before` to `now`
/// and k from `ratio` k to k: k (x - x_0)^2 / 2 by the step's length, x_0^2 (k_0 - k) / 2 by k.
inline double spring_loss(double k, double ratio, const Lanes3<double>& before,
                          const Lanes3<double>& now) {
  return 0.5 * k * (squared(now - before) + squared(before) * (ratio - 1.0));
}

template <class R>
[[gnu::always_inline]] inline R intersection_area(const R& r_eff, const R& overlap,
                                                  const R& inv_distance) {
  // (pi/4) (s^2 - D^2)(D^2 - q^2)/D^2 with s, q = R_i +- R_j, s = D + d and s^2 - q^2 = 4 R* s.
  constexpr double kQuarterPi = 0.78539816339744830962;
  const R height = overlap * (2.0 + overlap * inv_distance);
  return kQuarterPi * height * (4.0 * r_eff * (1.0 + overlap * inv_distance) - height);
}

/// The circle's area integrated over the overlap from 0, by Gauss-Legendre with three points.
inline double cohesion_volume(double r_eff, double overlap, double inv_distance) {
  double sum = 0.0;
  for (const double x : {-root(0.6), 0.0, root(0.6)}) {
    const double d = 0.5 * overlap * (1.0 + x);
    const double inverse = inv_distance / (1.0 + (overlap - d) * inv_distance);
    sum += (x == 0.0 ? 8.0 : 5.0) / 18.0 * intersection_area(r_eff, d, inverse);
  }
  return sum * overlap;
}

/// Rolling friction of type C [Ai2011, model C]: a spring-dashpot on the relative rolling, limited
/// to mu_r R* |F_n|, without damping once it yields. The spring is k_r = 2.25 k_n (mu_r R*)^2, or
/// k_t R*^2. Under Compatibility::liggghts its torque is added to without being turned.
template <class R, class Energies>
[[gnu::always_inline]] inline Lanes3<R> rolling_spring(const scene::ContactModel& model,
                                                       const R& limit, const R& stiffness,
                                                       const R& damping,
                                                       const TurningLanes<R>& turning,
                                                       const Lanes3<R>& rolling, double dt,
                                                       Lanes3<R>& torque, Energies& energies) {
  const Lanes3<R> increment = R(stiffness * dt) * rolling;
  if (model.compatibility == scene::Compatibility::liggghts)
    torque = torque + increment;
  else
    turning.add(increment, torque);
  const R size2 = squared(torque);
  const auto yields = size2 > limit * limit;
  const R size = root(size2);
  if constexpr (std::is_same_v<Energies, ContactEnergies>) {
    const double held = yields ? limit : size;
    if (stiffness > 0.0) energies.rolling_j = 0.5 * (held * held) / stiffness;
    energies.rolling_w =
        yields ? (dt * stiffness > 0.0 ? limit * (size - limit) / (stiffness * dt) : 0.0)
               : damping * squared(rolling);
  }
  torque = chosen(yields, R(limit / size) * torque, torque);
  return chosen(yields, -torque, -torque - damping * turning.at_end(rolling));
}

/// Rolling friction of type A [Ai2011, model A]: mu_r R* |F_n| against the relative rolling, but
/// no more than stops it within the step, were the bodies free: (2/7) I_r |w|/dt.
template <class R, class Energies>
[[gnu::always_inline]] inline Lanes3<R> rolling_resistance(const scene::ContactModel& model,
                                                           const R& limit, const R& i_roll,
                                                           const TurningLanes<R>& turning,
                                                           const Lanes3<R>& rolling, double dt,
                                                           Energies& energies) {
  const R rate = root(squared(rolling));
  R size = limit;
  if (model.compatibility == scene::Compatibility::none && dt > 0.0) {
    const R stopping = (2.0 / 7.0) * i_roll * rate / dt;
    size = chosen(stopping < size, stopping, size);
  }
  if constexpr (std::is_same_v<Energies, ContactEnergies>) energies.rolling_w = size * rate;
  const R factor = chosen(rate > 0.0, -size / rate, R(0.0));
  return factor * turning.at_end(rolling);
}

/// What only energies need: stored in the springs, lost in dampers and by stiffnesses that changed.
template <class R>
[[gnu::always_inline]] inline void count_springs(
    const scene::ContactModel& model, const LawLanes<R>& law, const BodiesLanes<R>& bodies,
    const KinematicsLanes<R>& now, double dt, const TurningLanes<R>& turning, double elastic,
    double normal, double approach, double stiffness, HistoryLanes<R> before,
    const HistoryLanes<R>& history, ContactEnergies& energies) {
  energies.normal_j = 0.4 * elastic * now.overlap;
  if (law.cohesion > 0.0)
    energies.normal_j -=
        law.cohesion * cohesion_volume(bodies.r_eff, now.overlap, now.inv_distance);
  energies.tangential_j = 0.5 * stiffness * squared(history.slip);
  energies.normal_damping_w = (normal - elastic) * approach;
  if (!(dt > 0.0)) return;
  const Lanes3<R> none{0.0, 0.0, 0.0};
  turning.add(none, before.slip);
  const double left = 1.0 - approach * dt / now.overlap;
  const double ratio = left > 0.0 ? root(left) : 0.0;  // a_0/a
  energies.stiffness_change_w = spring_loss(stiffness, ratio, before.slip, history.slip) / dt;
  if (energies.rolling_j > 0.0) {
    if (model.compatibility == scene::Compatibility::none) turning.add(none, before.rolling);
    energies.stiffness_change_w +=
        spring_loss(2.0 * energies.rolling_j / squared(history.rolling),
                    ratio > 0.0 ? 1.0 / ratio : 1.0, before.rolling, history.rolling) /
        dt;
  }
}

/// hertz_mindlin() in lanes. `Energies` may be ContactEnergies where R is double.
template <class R, class Energies>
[[gnu::always_inline]] inline ForceLanes<R> contact_law(
    const scene::ContactModel& model, const LawLanes<R>& law, const BodiesLanes<R>& bodies,
    const KinematicsLanes<R>& now, double dt, HistoryLanes<R>& history, Energies& energies) {
  constexpr bool kAsked = std::is_same_v<Energies, ContactEnergies>;
  [[maybe_unused]] HistoryLanes<R> before;
  if constexpr (kAsked) {
    energies = {};
    before = history;
  }
  const R zero(0.0);
  const R a = root(bodies.r_eff * now.overlap);
  const R damping_scale = root(a * bodies.m_eff);
  const R approach = dot(now.velocity, now.normal_half);
  const R elastic = (4.0 / 3.0) * law.e_eff * a * now.overlap;
  ForceLanes<R> result;
  result.normal = elastic + law.gamma_n * damping_scale * approach;
  if (model.tail == scene::Tail::clip)
    result.normal = chosen(result.normal > 0.0, result.normal, zero);
  const R pressing = magnitude(result.normal);
  const R limit = law.mu_s * pressing;

  const Lanes3<R> sliding = now.velocity - approach * now.normal_half;
  Lanes3<R>& xi = history.slip;
  const TurningLanes<R> turning(model, now, dt);
  turning.add(R(dt) * sliding, xi);
  const R stiffness = 8.0 * law.g_eff * a;
  const R xi2 = squared(xi);
  const auto slips = stiffness * stiffness * xi2 > limit * limit;
  const R length = root(xi2);
  const R kept = limit / (stiffness * length);
  Lanes3<R> sticking = -stiffness * xi - R(law.gamma_t * damping_scale) * turning.at_end(sliding);
  if (model.tail == scene::Tail::clip) {
    const R size2 = squared(sticking);
    const auto capped = size2 > limit * limit;
    sticking = chosen(capped, R(limit / root(size2)) * sticking, sticking);
  }
  xi = chosen(slips, kept * xi, xi);
  result.tangential = chosen(slips, -stiffness * xi, sticking);
  // Without friction no damping acts, even at the start, when nothing has slipped yet.
  const auto smooth = law.mu_s == zero;
  const Lanes3<R> none{zero, zero, zero};
  xi = chosen(smooth, none, xi);
  result.tangential = chosen(smooth, none, result.tangential);
  if constexpr (kAsked) {
    if (!smooth && !slips)
      energies.tangential_damping_w = -dot(result.tangential + stiffness * xi, sliding);
    else if (!smooth && dt > 0.0)
      energies.sliding_w = limit * (length - limit / stiffness) / dt;
  }
  result.force = result.tangential - result.normal * now.normal;
  const auto coheres = law.cohesion > 0.0;
  if (any(coheres)) {
    const R pull = law.cohesion * intersection_area(bodies.r_eff, now.overlap, now.inv_distance);
    result.force = chosen(coheres, result.force + pull * now.normal, result.force);
  }

  result.rolling_torque = none;
  const auto resists = law.mu_r > 0.0;
  if (any(resists)) {
    const R torque_limit = law.mu_r * bodies.r_eff * pressing;
    const Lanes3<R> rolling = now.spin - dot(now.spin, now.normal_half) * now.normal_half;
    Lanes3<R> torque = history.rolling;
    const Lanes3<R> resisting =
        model.rolling == scene::RollingModel::c
            ? rolling_spring(model, torque_limit,
                             R(law.rolling_k * a * bodies.r_eff * bodies.r_eff),
                             R(law.rolling_c * bodies.r_eff * root(a * bodies.i_roll)), turning,
                             rolling, dt, torque, energies)
            : rolling_resistance(model, torque_limit, bodies.i_roll, turning, rolling, dt,
                                 energies);
    history.rolling = chosen(resists, torque, history.rolling);
    result.rolling_torque = chosen(resists, resisting, none);
  }
  if constexpr (kAsked)
    count_springs(model, law, bodies, now, dt, turning, elastic, result.normal, approach, stiffness,
                  before, history, energies);
  return result;
}

}  // namespace repose::dem::detail

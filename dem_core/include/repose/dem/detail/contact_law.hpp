// The bodies of contact_law.hpp, inline for the loops over contacts.
#pragma once

#include "repose/dem/contact_law.hpp"
#include "repose/dem/cross.hpp"

namespace repose::dem {
namespace detail {

/// Projects `v` into the plane normal to `n` and restores its length.
[[gnu::always_inline]] inline void turn_into_plane(Vec3& v, const Vec3& n) {
  const double before = v.squaredNorm();
  if (before == 0.0) return;
  const double out = v.dot(n);
  v -= out * n;
  const double lost = out * out / before;
  if (lost < 1e-5)  // (1 - x)^(-1/2) to x^3 = 1e-15
    v *= 1.0 + lost * (0.5 + 0.375 * lost);
  else if (lost < 1.0)
    v *= std::sqrt(before / v.squaredNorm());
}

/// How tangential vectors follow the contact through a step.
class Turning {
 public:
  [[gnu::always_inline]] Turning(const scene::ContactModel& model, const ContactKinematics& now,
                                 double dt)
      : project_(model.compatibility == scene::Compatibility::liggghts),
        angle_(now.turning * dt),
        half_(now.normal_half),
        end_(now.normal),
        axis_((now.normal + now.normal_half) / (1.0 + now.normal.dot(now.normal_half))) {}

  /// `v`, tangential at half step, at the end: turned by the smallest rotation between the normals.
  [[gnu::always_inline]] Vec3 at_end(const Vec3& v) const { return v - v.dot(end_) * axis_; }
  /// Adds an `increment`, tangential at half step, to a history and takes that to the end.
  [[gnu::always_inline]] void add(const Vec3& increment, Vec3& history) const {
    if (project_) {
      history += increment;
      history -= history.dot(end_) * end_;
    } else {
      turn_into_plane(history, half_);
      const double across =
          angle_ * (1.0 - angle_ * angle_ / 6.0);  // the length is kept to angle^4
      history += across * cross(half_, history) - (0.5 * angle_ * angle_) * history;
      history = at_end(history + increment);
    }
  }

 private:
  bool project_;
  double angle_;  // about the normal within the step
  Vec3 half_, end_, axis_;
};

/// What a spring k x^2 / 2 gives away in a step beyond its work, when x went from `before` to `now`
/// and k from `ratio` k to k: k (x - x_0)^2 / 2 by the step's length, x_0^2 (k_0 - k) / 2 by k.
inline double spring_loss(double k, double ratio, const Vec3& before, const Vec3& now) {
  return 0.5 * k * ((now - before).squaredNorm() + before.squaredNorm() * (ratio - 1.0));
}

/// The circle's area integrated over the overlap from 0, by Gauss-Legendre with three points.
inline double cohesion_volume(double r_eff, double overlap, double inv_distance) {
  double sum = 0.0;
  for (const double x : {-std::sqrt(0.6), 0.0, std::sqrt(0.6)}) {
    const double d = 0.5 * overlap * (1.0 + x);
    const double inverse = inv_distance / (1.0 + (overlap - d) * inv_distance);
    sum += (x == 0.0 ? 8.0 : 5.0) / 18.0 * cohesion_area(r_eff, d, inverse);
  }
  return sum * overlap;
}

/// Rolling friction of type C [Ai2011, model C]: a spring-dashpot on the relative rolling, limited
/// to mu_r R* |F_n|, without damping once it yields. The spring is k_r = 2.25 k_n (mu_r R*)^2, or
/// k_t R*^2. Under Compatibility::liggghts its torque is added to without being turned.
template <class Energies>
[[gnu::always_inline]] inline Vec3 rolling_spring(const scene::ContactModel& model, double limit,
                                                  double stiffness, double damping,
                                                  const Turning& turning, const Vec3& rolling,
                                                  double dt, Vec3& torque, Energies& energies) {
  if (model.compatibility == scene::Compatibility::liggghts)
    torque += (stiffness * dt) * rolling;
  else
    turning.add((stiffness * dt) * rolling, torque);
  const double size2 = torque.squaredNorm();
  const bool yields = size2 > limit * limit;
  if constexpr (std::is_same_v<Energies, ContactEnergies>) {
    const double size = std::sqrt(size2);
    if (stiffness > 0.0) energies.rolling_j = 0.5 * std::pow(yields ? limit : size, 2) / stiffness;
    energies.rolling_w =
        yields ? (dt * stiffness > 0.0 ? limit * (size - limit) / (stiffness * dt) : 0.0)
               : damping * rolling.squaredNorm();
  }
  if (yields) {
    torque *= limit / std::sqrt(size2);
    return -torque;
  }
  return -torque - damping * turning.at_end(rolling);
}

/// Rolling friction of type A [Ai2011, model A]: mu_r R* |F_n| against the relative rolling, but
/// no more than stops it within the step, were the bodies free: (2/7) I_r |w|/dt.
template <class Energies>
[[gnu::always_inline]] inline Vec3 rolling_resistance(const scene::ContactModel& model,
                                                      double limit, double i_roll,
                                                      const Turning& turning, const Vec3& rolling,
                                                      double dt, Energies& energies) {
  const double rate = rolling.norm();
  if (rate == 0.0) return Vec3::Zero();
  double size = limit;
  if (model.compatibility == scene::Compatibility::none && dt > 0.0)
    size = std::min(size, (2.0 / 7.0) * i_roll * rate / dt);
  if constexpr (std::is_same_v<Energies, ContactEnergies>) energies.rolling_w = size * rate;
  return (-size / rate) * turning.at_end(rolling);
}

}  // namespace detail

inline ContactEnergies& ContactEnergies::operator+=(const ContactEnergies& other) {
  normal_j += other.normal_j;
  tangential_j += other.tangential_j;
  rolling_j += other.rolling_j;
  normal_damping_w += other.normal_damping_w;
  tangential_damping_w += other.tangential_damping_w;
  sliding_w += other.sliding_w;
  rolling_w += other.rolling_w;
  stiffness_change_w += other.stiffness_change_w;
  return *this;
}

inline double cohesion_area(double r_eff, double overlap, double inv_distance) {
  // (pi/4) (s^2 - D^2)(D^2 - q^2)/D^2 with s, q = R_i +- R_j, s = D + d and s^2 - q^2 = 4 R* s.
  const double height = overlap * (2.0 + overlap * inv_distance);
  return 0.25 * std::numbers::pi * height * (4.0 * r_eff * (1.0 + overlap * inv_distance) - height);
}

template <class Energies>
[[gnu::always_inline]] inline ContactForce hertz_mindlin(
    const scene::ContactModel& model, const PairLaw& law, const ContactBodies& bodies,
    const ContactKinematics& now, double dt, ContactHistory& history, Energies&& energies) {
  using Asked = std::remove_reference_t<Energies>;
  constexpr bool kAsked = std::is_same_v<Asked, ContactEnergies>;
  [[maybe_unused]] ContactHistory before;
  if constexpr (kAsked) {
    energies = {};
    before = history;
  }
  const Vec3& n = now.normal;
  const double a = std::sqrt(bodies.r_eff * now.overlap);
  const double damping_scale = std::sqrt(a * bodies.m_eff);
  const double approach = now.velocity.dot(now.normal_half);
  const double elastic = (4.0 / 3.0) * law.e_eff * a * now.overlap;
  ContactForce result;
  result.normal = elastic + law.gamma_n * damping_scale * approach;
  if (model.tail == scene::Tail::clip) result.normal = std::max(0.0, result.normal);
  const double limit = law.mu_s * std::abs(result.normal);

  const Vec3 sliding = now.velocity - approach * now.normal_half;
  Vec3& xi = history.slip;
  const detail::Turning turning(model, now, dt);
  turning.add(sliding * dt, xi);
  const double stiffness = 8.0 * law.g_eff * a;
  const double xi2 = xi.squaredNorm();
  if (law.mu_s == 0.0) {  // nor does damping act, even at the start, when nothing has slipped yet
    xi.setZero();
    result.tangential.setZero();
  } else if (stiffness * stiffness * xi2 > limit * limit) {
    const double length = std::sqrt(xi2);
    xi *= limit / (stiffness * length);
    result.tangential = -stiffness * xi;
    if constexpr (kAsked)
      if (dt > 0.0) energies.sliding_w = limit * (length - limit / stiffness) / dt;
  } else {
    result.tangential = -stiffness * xi - (law.gamma_t * damping_scale) * turning.at_end(sliding);
    if (model.tail == scene::Tail::clip) {
      const double size2 = result.tangential.squaredNorm();
      if (size2 > limit * limit) result.tangential *= limit / std::sqrt(size2);
    }
    if constexpr (kAsked)
      energies.tangential_damping_w = -(result.tangential + stiffness * xi).dot(sliding);
  }
  result.force = result.tangential - result.normal * n;
  if (law.cohesion > 0.0)
    result.force += law.cohesion * cohesion_area(bodies.r_eff, now.overlap, now.inv_distance) * n;

  result.rolling_torque.setZero();
  if (law.mu_r > 0.0) {
    const double torque_limit = law.mu_r * bodies.r_eff * std::abs(result.normal);
    const Vec3 rolling = now.spin - now.spin.dot(now.normal_half) * now.normal_half;
    result.rolling_torque =
        model.rolling == scene::RollingModel::c
            ? detail::rolling_spring(model, torque_limit,
                                     law.rolling_k * a * bodies.r_eff * bodies.r_eff,
                                     law.rolling_c * bodies.r_eff * std::sqrt(a * bodies.i_roll),
                                     turning, rolling, dt, history.rolling, energies)
            : detail::rolling_resistance(model, torque_limit, bodies.i_roll, turning, rolling, dt,
                                         energies);
  }
  if constexpr (kAsked) {
    energies.normal_j = 0.4 * elastic * now.overlap;
    if (law.cohesion > 0.0)
      energies.normal_j -=
          law.cohesion * detail::cohesion_volume(bodies.r_eff, now.overlap, now.inv_distance);
    energies.tangential_j = 0.5 * stiffness * xi.squaredNorm();
    energies.normal_damping_w = (result.normal - elastic) * approach;
    if (dt > 0.0) {
      turning.add(Vec3::Zero(), before.slip);
      const double ratio = std::sqrt(std::max(0.0, 1.0 - approach * dt / now.overlap));  // a_0/a
      energies.stiffness_change_w = detail::spring_loss(stiffness, ratio, before.slip, xi) / dt;
      if (energies.rolling_j > 0.0) {
        if (model.compatibility == scene::Compatibility::none)
          turning.add(Vec3::Zero(), before.rolling);
        const double size2 = history.rolling.squaredNorm();
        energies.stiffness_change_w +=
            detail::spring_loss(2.0 * energies.rolling_j / size2, ratio > 0.0 ? 1.0 / ratio : 1.0,
                                before.rolling, history.rolling) /
            dt;
      }
    }
  }
  return result;
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

// Free rotation of one body (R = double) or of several side by side (R a pack of doubles): a step
// is a chain of divisions, and one chain leaves a processor idle most of the time.
#pragma once

#include "repose/dem/detail/lanes.hpp"

namespace repose::dem::detail {

template <class R>
struct QuaternionLanes {
  R w, x, y, z;
};

template <class R>
[[gnu::always_inline]] inline QuaternionLanes<R> normalised(const QuaternionLanes<R>& q) {
  const R scale = R(1.0) / root(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w * scale, q.x * scale, q.y * scale, q.z * scale};
}

template <class R>
struct RotationLanes {
  Lanes3<R> x, y, z;  ///< rows

  [[gnu::always_inline]] explicit RotationLanes(const QuaternionLanes<R>& q)
      : x{R(1.0) - R(2.0) * (q.y * q.y + q.z * q.z), R(2.0) * (q.x * q.y - q.w * q.z),
          R(2.0) * (q.x * q.z + q.w * q.y)},
        y{R(2.0) * (q.x * q.y + q.w * q.z), R(1.0) - R(2.0) * (q.x * q.x + q.z * q.z),
          R(2.0) * (q.y * q.z - q.w * q.x)},
        z{R(2.0) * (q.x * q.z - q.w * q.y), R(2.0) * (q.y * q.z + q.w * q.x),
          R(1.0) - R(2.0) * (q.x * q.x + q.y * q.y)} {}
  [[gnu::always_inline]] Lanes3<R> to_world(const Lanes3<R>& v) const {
    return {dot(x, v), dot(y, v), dot(z, v)};
  }
  [[gnu::always_inline]] Lanes3<R> to_body(const Lanes3<R>& v) const {
    return v.x * x + v.y * y + v.z * z;
  }
};

template <class R>
[[gnu::always_inline]] inline Lanes3<R> times(const Lanes3<R>& a, const Lanes3<R>& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// Cosine and sine of half an angle, and of the angle 4 atan(t).
template <class R>
struct TurnLanes {
  R c, s, cos_all, sin_all;

  [[gnu::always_inline]] explicit TurnLanes(const R& t) {
    const R scale = R(1.0) / (R(1.0) + t * t);
    c = (R(1.0) - t * t) * scale;
    s = R(2.0) * t * scale;
    cos_all = c * c - s * s;
    sin_all = R(2.0) * c * s;
  }
  /// Of the angular momentum's components in the plane of the turn.
  [[gnu::always_inline]] void apply(R& a, R& b) const {
    const R before = a;
    a = cos_all * a + sin_all * b;
    b = cos_all * b - sin_all * before;
  }
};

/// A quarter of dt over the principal moments, momentum in body axes; see free_rotation() of
/// rotation.hpp.
template <class R>
class FreeRotation {
 public:
  [[gnu::always_inline]] FreeRotation(const QuaternionLanes<R>& q, const Lanes3<R>& momentum,
                                      const Lanes3<R>& rate)
      : q_(q), p_(RotationLanes<R>(q).to_body(momentum)), rate_(rate) {
    const R half(0.5);
    about_z(half);
    about_y(half);
    about_x(R(1.0));
    about_y(half);
    about_z(half);
    q_ = normalised(q_);
  }
  [[gnu::always_inline]] const QuaternionLanes<R>& orientation() const { return q_; }

 private:
  [[gnu::always_inline]] void about_x(const R& part) {
    const TurnLanes<R> t(part * rate_.x * p_.x);
    t.apply(p_.y, p_.z);
    q_ = {q_.w * t.c - q_.x * t.s, q_.x * t.c + q_.w * t.s, q_.y * t.c + q_.z * t.s,
          q_.z * t.c - q_.y * t.s};
  }
  [[gnu::always_inline]] void about_y(const R& part) {
    const TurnLanes<R> t(part * rate_.y * p_.y);
    t.apply(p_.z, p_.x);
    q_ = {q_.w * t.c - q_.y * t.s, q_.x * t.c - q_.z * t.s, q_.y * t.c + q_.w * t.s,
          q_.z * t.c + q_.x * t.s};
  }
  [[gnu::always_inline]] void about_z(const R& part) {
    const TurnLanes<R> t(part * rate_.z * p_.z);
    t.apply(p_.x, p_.y);
    q_ = {q_.w * t.c - q_.z * t.s, q_.x * t.c + q_.y * t.s, q_.y * t.c - q_.x * t.s,
          q_.z * t.c + q_.w * t.s};
  }

  QuaternionLanes<R> q_;
  Lanes3<R> p_;
  Lanes3<R> rate_;
};

/// Of a step of free rotation: where it ends, the orientation half way, and the angular velocity
/// there (world).
template <class R>
struct RotationStep {
  QuaternionLanes<R> end, half;
  Lanes3<R> spin;

  [[gnu::always_inline]] RotationStep(const QuaternionLanes<R>& q, const Lanes3<R>& momentum,
                                      const Lanes3<R>& inertia, double dt) {
    const R one(1.0);
    const Lanes3<R> inverse{one / inertia.x, one / inertia.y, one / inertia.z};
    end = FreeRotation<R>(q, momentum, R(0.25 * dt) * inverse).orientation();
    half = normalised(QuaternionLanes<R>{q.w + end.w, q.x + end.x, q.y + end.y, q.z + end.z});
    const RotationLanes<R> turn(half);
    spin = turn.to_world(times(turn.to_body(momentum), inverse));
  }
};

}  // namespace repose::dem::detail

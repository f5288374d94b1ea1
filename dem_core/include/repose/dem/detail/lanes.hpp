// Numbers and vectors that stand for one contact (R = double) or for several side by side (R a pack
// of doubles): the contact law is written once for both and gives each lane the same bits.
#pragma once

namespace repose::dem::detail {

// What a pack must offer besides + - * / and comparisons, here for one number.
[[gnu::always_inline]] inline double chosen(bool which, double yes, double no) {
  return which ? yes : no;
}
[[gnu::always_inline]] inline double root(double x) {
  return __builtin_sqrt(x);
}
[[gnu::always_inline]] inline double magnitude(double x) {
  return __builtin_fabs(x);
}
[[gnu::always_inline]] inline bool any(bool mask) {
  return mask;
}

/// Three components; Eigen's vectors know no packs.
template <class R>
struct Lanes3 {
  R x, y, z;
};

template <class R>
[[gnu::always_inline]] inline Lanes3<R> operator+(const Lanes3<R>& a, const Lanes3<R>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class R>
[[gnu::always_inline]] inline Lanes3<R> operator-(const Lanes3<R>& a, const Lanes3<R>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class R>
[[gnu::always_inline]] inline Lanes3<R> operator-(const Lanes3<R>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class R>
[[gnu::always_inline]] inline Lanes3<R> operator*(const R& s, const Lanes3<R>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class R>
[[gnu::always_inline]] inline R dot(const Lanes3<R>& a, const Lanes3<R>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class R>
[[gnu::always_inline]] inline R squared(const Lanes3<R>& a) {
  return dot(a, a);
}
template <class R>
[[gnu::always_inline]] inline Lanes3<R> cross3(const Lanes3<R>& a, const Lanes3<R>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Mask, class R>
[[gnu::always_inline]] inline Lanes3<R> chosen(const Mask& which, const Lanes3<R>& yes,
                                               const Lanes3<R>& no) {
  return {chosen(which, yes.x, no.x), chosen(which, yes.y, no.y), chosen(which, yes.z, no.z)};
}

}  // namespace repose::dem::detail

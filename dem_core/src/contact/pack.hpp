// N doubles side by side, in GCC's vector extensions; what detail/lanes.hpp asks of a number.
#pragma once

#include <cstddef>
#include <cstdint>
#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "repose/dem/detail/lanes.hpp"

namespace repose::dem::detail {

/// The compiler's vectors.
template <int N>
struct VectorTypes;
template <>
struct VectorTypes<2> {
  typedef double Lanes __attribute__((vector_size(16)));
  typedef double InMemory __attribute__((vector_size(16), may_alias));
  typedef long long Bits __attribute__((vector_size(16)));
};
template <>
struct VectorTypes<4> {
  typedef double Lanes __attribute__((vector_size(32)));
  typedef double InMemory __attribute__((vector_size(32), may_alias));
  typedef long long Bits __attribute__((vector_size(32)));
};

template <>
struct VectorTypes<8> {
  typedef double Lanes __attribute__((vector_size(64)));
  typedef long long Bits __attribute__((vector_size(64)));
};

template <int N>
struct PackMask {
  using Bits = typename VectorTypes<N>::Bits;
  Bits bits;

  [[gnu::always_inline]] friend PackMask operator&(PackMask a, PackMask b) {
    return {a.bits & b.bits};
  }
};

template <int N>
struct Pack {
  using Lanes = typename VectorTypes<N>::Lanes;
  using Mask = PackMask<N>;
  Lanes lanes;

  Pack() = default;
  [[gnu::always_inline]] Pack(double x) : lanes(x - Lanes{}) {}
  [[gnu::always_inline]] explicit Pack(Lanes x) : lanes(x) {}

  [[gnu::always_inline]] friend Pack operator+(Pack a, Pack b) { return Pack(a.lanes + b.lanes); }
  [[gnu::always_inline]] friend Pack operator-(Pack a, Pack b) { return Pack(a.lanes - b.lanes); }
  [[gnu::always_inline]] friend Pack operator*(Pack a, Pack b) { return Pack(a.lanes * b.lanes); }
  [[gnu::always_inline]] friend Pack operator/(Pack a, Pack b) { return Pack(a.lanes / b.lanes); }
  [[gnu::always_inline]] friend Pack operator-(Pack a) { return Pack(-a.lanes); }
  [[gnu::always_inline]] friend Mask operator<(Pack a, Pack b) { return {a.lanes < b.lanes}; }
  [[gnu::always_inline]] friend Mask operator>(Pack a, Pack b) { return {a.lanes > b.lanes}; }
  [[gnu::always_inline]] friend Mask operator>=(Pack a, Pack b) { return {a.lanes >= b.lanes}; }
  [[gnu::always_inline]] friend Mask operator==(Pack a, Pack b) { return {a.lanes == b.lanes}; }
};

template <int N>
[[gnu::always_inline]] inline Pack<N> chosen(PackMask<N> which, Pack<N> yes, Pack<N> no) {
  return Pack<N>(which.bits ? yes.lanes : no.lanes);
}
template <int N>
[[gnu::always_inline]] inline Pack<N> magnitude(Pack<N> x) {
  using Bits = typename PackMask<N>::Bits;
  const Bits no_sign = (Bits{} + 1) << 63;
  return Pack<N>(
      reinterpret_cast<typename Pack<N>::Lanes>(reinterpret_cast<Bits>(x.lanes) & ~no_sign));
}
template <int N>
[[gnu::always_inline]] inline Pack<N> root(Pack<N> x) {
  // Vector extensions have no square root; a loop would not reliably become one instruction.
#if defined(__x86_64__)
  if constexpr (N == 2)
    return Pack<N>(
        reinterpret_cast<typename Pack<N>::Lanes>(_mm_sqrt_pd(reinterpret_cast<__m128d>(x.lanes))));
#if defined(__AVX512F__)
  if constexpr (N == 8)
    return Pack<N>(reinterpret_cast<typename Pack<N>::Lanes>(
        _mm512_maskz_sqrt_pd(0xff, reinterpret_cast<__m512d>(x.lanes))));
#endif
#if defined(__AVX__)
  if constexpr (N == 4)
    return Pack<N>(reinterpret_cast<typename Pack<N>::Lanes>(
        _mm256_sqrt_pd(reinterpret_cast<__m256d>(x.lanes))));
#endif
#endif
  for (int k = 0; k < N; ++k) x.lanes[k] = __builtin_sqrt(x.lanes[k]);
  return x;
}
template <int N>
[[gnu::always_inline]] inline bool any(PackMask<N> mask) {
#if defined(__AVX512F__)
  if constexpr (N == 8)
    return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(mask.bits),
                                  reinterpret_cast<__m512i>(mask.bits)) != 0;
#endif
#if defined(__AVX__)
  if constexpr (N == 4) return _mm256_movemask_pd(reinterpret_cast<__m256d>(mask.bits)) != 0;
#endif
#if defined(__x86_64__)
  if constexpr (N == 2) return _mm_movemask_pd(reinterpret_cast<__m128d>(mask.bits)) != 0;
#endif
  bool found = false;
  for (int k = 0; k < N; ++k) found = found || mask.bits[k] != 0;
  return found;
}

/// How many contacts an R holds.
template <class R>
inline constexpr std::size_t kLanes = sizeof(R) / sizeof(double);

/// Lane k of x.
[[gnu::always_inline]] inline double lane(double x, std::size_t) {
  return x;
}
template <int N>
[[gnu::always_inline]] inline double lane(Pack<N> x, std::size_t k) {
  return x.lanes[k];
}

/// Four numbers of each lane, 32 bytes that stand together in memory.
template <class R>
struct Row {
  R a, b, c, d;
};

/// Reads lane k from from[k] to from[k] + 3, aligned to 32 bytes: loads and a transposition, which
/// is faster than gathering.
[[gnu::always_inline]] inline Row<double> read_rows(const double* const (&from)[1]) {
  return {from[0][0], from[0][1], from[0][2], from[0][3]};
}
[[gnu::always_inline]] inline void write_rows(const Row<double>& row, double* const (&to)[1]) {
  to[0][0] = row.a;
  to[0][1] = row.b;
  to[0][2] = row.c;
  to[0][3] = row.d;
}

template <int N>
requires(N == 2)
    [[gnu::always_inline]] inline Row<Pack<N>> read_rows(const double* const (&from)[N]) {
  using L = typename Pack<N>::Lanes;
  using M = typename VectorTypes<N>::InMemory;
  const L low0 = *reinterpret_cast<const M*>(from[0]);
  const L high0 = *reinterpret_cast<const M*>(from[0] + 2);
  const L low1 = *reinterpret_cast<const M*>(from[1]);
  const L high1 = *reinterpret_cast<const M*>(from[1] + 2);
  return {Pack<N>(__builtin_shufflevector(low0, low1, 0, 2)),
          Pack<N>(__builtin_shufflevector(low0, low1, 1, 3)),
          Pack<N>(__builtin_shufflevector(high0, high1, 0, 2)),
          Pack<N>(__builtin_shufflevector(high0, high1, 1, 3))};
}
template <int N>
requires(N == 2)
    [[gnu::always_inline]] inline void write_rows(const Row<Pack<N>>& row, double* const (&to)[N]) {
  using M = typename VectorTypes<N>::InMemory;
  *reinterpret_cast<M*>(to[0]) = __builtin_shufflevector(row.a.lanes, row.b.lanes, 0, 2);
  *reinterpret_cast<M*>(to[0] + 2) = __builtin_shufflevector(row.c.lanes, row.d.lanes, 0, 2);
  *reinterpret_cast<M*>(to[1]) = __builtin_shufflevector(row.a.lanes, row.b.lanes, 1, 3);
  *reinterpret_cast<M*>(to[1] + 2) = __builtin_shufflevector(row.c.lanes, row.d.lanes, 1, 3);
}

/// The transposition of four rows of four is its own inverse.
template <int N>
requires(N == 4) [[gnu::always_inline]] inline Row<Pack<N>> transposed(const Row<Pack<N>>& r) {
  using L = typename Pack<N>::Lanes;
  const L t0 = __builtin_shufflevector(r.a.lanes, r.b.lanes, 0, 4, 2, 6);
  const L t1 = __builtin_shufflevector(r.a.lanes, r.b.lanes, 1, 5, 3, 7);
  const L t2 = __builtin_shufflevector(r.c.lanes, r.d.lanes, 0, 4, 2, 6);
  const L t3 = __builtin_shufflevector(r.c.lanes, r.d.lanes, 1, 5, 3, 7);
  return {Pack<N>(__builtin_shufflevector(t0, t2, 0, 1, 4, 5)),
          Pack<N>(__builtin_shufflevector(t1, t3, 0, 1, 4, 5)),
          Pack<N>(__builtin_shufflevector(t0, t2, 2, 3, 6, 7)),
          Pack<N>(__builtin_shufflevector(t1, t3, 2, 3, 6, 7))};
}
template <int N>
requires(N == 4)
    [[gnu::always_inline]] inline Row<Pack<N>> read_rows(const double* const (&from)[N]) {
  using M = typename VectorTypes<N>::InMemory;
  return transposed<N>({Pack<N>(*reinterpret_cast<const M*>(from[0])),
                        Pack<N>(*reinterpret_cast<const M*>(from[1])),
                        Pack<N>(*reinterpret_cast<const M*>(from[2])),
                        Pack<N>(*reinterpret_cast<const M*>(from[3]))});
}
template <int N>
requires(N == 4)
    [[gnu::always_inline]] inline void write_rows(const Row<Pack<N>>& row, double* const (&to)[N]) {
  using M = typename VectorTypes<N>::InMemory;
  const Row<Pack<N>> t = transposed<N>(row);
  *reinterpret_cast<M*>(to[0]) = t.a.lanes;
  *reinterpret_cast<M*>(to[1]) = t.b.lanes;
  *reinterpret_cast<M*>(to[2]) = t.c.lanes;
  *reinterpret_cast<M*>(to[3]) = t.d.lanes;
}

/// Four rows of four in each half.
template <int N>
requires(N == 8) [[gnu::always_inline]] inline Row<Pack<N>> transposed(const Row<Pack<N>>& r) {
  using L = typename Pack<N>::Lanes;
  const L t0 = __builtin_shufflevector(r.a.lanes, r.b.lanes, 0, 8, 2, 10, 4, 12, 6, 14);
  const L t1 = __builtin_shufflevector(r.a.lanes, r.b.lanes, 1, 9, 3, 11, 5, 13, 7, 15);
  const L t2 = __builtin_shufflevector(r.c.lanes, r.d.lanes, 0, 8, 2, 10, 4, 12, 6, 14);
  const L t3 = __builtin_shufflevector(r.c.lanes, r.d.lanes, 1, 9, 3, 11, 5, 13, 7, 15);
  return {Pack<N>(__builtin_shufflevector(t0, t2, 0, 1, 8, 9, 4, 5, 12, 13)),
          Pack<N>(__builtin_shufflevector(t1, t3, 0, 1, 8, 9, 4, 5, 12, 13)),
          Pack<N>(__builtin_shufflevector(t0, t2, 2, 3, 10, 11, 6, 7, 14, 15)),
          Pack<N>(__builtin_shufflevector(t1, t3, 2, 3, 10, 11, 6, 7, 14, 15))};
}
template <int N>
requires(N == 8)
    [[gnu::always_inline]] inline Row<Pack<N>> read_rows(const double* const (&from)[N]) {
  using M = VectorTypes<4>::InMemory;
  const auto both = [&from](int k) __attribute__((always_inline)) {
    return Pack<N>(__builtin_shufflevector(*reinterpret_cast<const M*>(from[k]),
                                           *reinterpret_cast<const M*>(from[k + 4]), 0, 1, 2, 3, 4,
                                           5, 6, 7));
  };
  return transposed<N>({both(0), both(1), both(2), both(3)});
}
template <int N>
requires(N == 8)
    [[gnu::always_inline]] inline void write_rows(const Row<Pack<N>>& row, double* const (&to)[N]) {
  using M = VectorTypes<4>::InMemory;
  const Row<Pack<N>> t = transposed<N>(row);
  const auto part = [&to](Pack<N> rows, int k) __attribute__((always_inline)) {
    *reinterpret_cast<M*>(to[k]) = __builtin_shufflevector(rows.lanes, rows.lanes, 0, 1, 2, 3);
    *reinterpret_cast<M*>(to[k + 4]) = __builtin_shufflevector(rows.lanes, rows.lanes, 4, 5, 6, 7);
  };
  part(t.a, 0);
  part(t.b, 1);
  part(t.c, 2);
  part(t.d, 3);
}

}  // namespace repose::dem::detail

// Definitions behind dense.hpp, compiled once for each instruction set. The including file says in
// REPOSE_DENSE_NAME what it is; it may have renamed the namespace Eigen, so that no template
// instance is shared between instruction sets.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "dense.hpp"

namespace repose::surrogate {
namespace {

using Square = Eigen::Map<Eigen::MatrixXd>;
using ConstSquare = Eigen::Map<const Eigen::MatrixXd>;

/// Columns that are worked on together: as few as fill a matrix product's registers. In fits of
/// 1,000 points 24 and 48 came within 3 % of each other.
constexpr Index block_for(Index n) {
  return n < 400 ? 24 : 48;
}

// Whether a number is met by a vector instruction or not must not depend on where its array happens
// to lie, or the last bits of exponentials and sums would. So exponentials go by chunks that are
// always full, the last one padded, sums by lanes counted from the first number, and matrices are
// copied to aligned storage first.
constexpr Index kChunk = 16;
using Chunk = Eigen::Array<double, kChunk, 1>;

Chunk load(const double* from, Index n) {
  if (n >= kChunk) return Eigen::Map<const Chunk>(from);
  Chunk c = Chunk::Zero();
  for (Index i = 0; i < n; ++i) c[i] = from[i];
  return c;
}

void store(const Chunk& c, double* to, Index n) {
  if (n >= kChunk)
    Eigen::Map<Chunk>{to} = c;
  else
    for (Index i = 0; i < n; ++i) to[i] = c[i];
}

void squared_distances_(const double* x, Index n, Index stride, Index dimension, const double* q,
                        Index q_stride, const double* weight, double* out) {
  Index i = 0;
  for (; i + kChunk <= n; i += kChunk) {
    Chunk sum = Chunk::Zero();  // stays in registers
    for (Index k = 0; k < dimension; ++k)
      sum += weight[k] * (Eigen::Map<const Chunk>(x + i + k * stride) - q[k * q_stride]).square();
    Eigen::Map<Chunk>{out + i} = sum;
  }
  for (; i < n; ++i) {
    out[i] = 0.0;
    for (Index k = 0; k < dimension; ++k) {
      const double step = x[i + k * stride] - q[k * q_stride];
      out[i] += weight[k] * (step * step);
    }
  }
}

using Packet = Eigen::internal::packet_traits<double>::type;
using Bits = long long __attribute__((vector_size(sizeof(Packet))));

/// exp(x) for x <= 0, to 2 units in the last place; 0 below -708. x = n log 2 + r, |r| <= log(2)/2,
/// and Taylor's polynomial of degree 13 of r, by Estrin's scheme.
Packet exp_of_negative(const Packet& x) {
  using namespace Eigen::internal;
  const auto constant = [](double c) { return pset1<Packet>(c); };
  constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it leaves n in the last bits
  const Packet clamped = pmax(x, constant(-708.0));
  const Packet shifted = pmadd(clamped, constant(1.4426950408889634), constant(kRound));
  const Packet n = psub(shifted, constant(kRound));
  const Packet r = pmadd(n, constant(-1.9082149292705877e-10),
                         pmadd(n, constant(-6.93147180369123816490e-1), clamped));
  const Packet r2 = pmul(r, r);
  const Packet r4 = pmul(r2, r2);
  const Packet r8 = pmul(r4, r4);
  const auto pair = [&](double low, double high) {
    return pmadd(constant(high), r, constant(low));
  };
  const Packet p0 = pmadd(pair(1.0 / 2, 1.0 / 6), r2, pair(1.0, 1.0));
  const Packet p4 = pmadd(pair(1.0 / 720, 1.0 / 5040), r2, pair(1.0 / 24, 1.0 / 120));
  const Packet p8 = pmadd(pair(1.0 / 3628800, 1.0 / 39916800), r2, pair(1.0 / 40320, 1.0 / 362880));
  const Packet p12 = pair(1.0 / 479001600, 1.0 / 6227020800);
  const Packet p = pmadd(pmadd(p12, r4, p8), r8, pmadd(p4, r4, p0));
  const Packet scaled =
      reinterpret_cast<Packet>(reinterpret_cast<Bits>(p) + (reinterpret_cast<Bits>(shifted) << 52));
  return pand(scaled, pcmp_le(constant(-708.0), x));
}

Chunk exp_of_negative(const Chunk& x) {
  constexpr Index kSize = sizeof(Packet) / sizeof(double);
  Chunk result;
  for (Index i = 0; i < kChunk; i += kSize)
    Eigen::internal::pstore(result.data() + i,
                            exp_of_negative(Eigen::internal::pload<Packet>(x.data() + i)));
  return result;
}

/// R and G of a chunk of r^2.
struct Correlated {
  Chunk r;
  Chunk g;
};

Correlated correlate_chunk(Correlation correlation, const Chunk& r2) {
  switch (correlation) {
    case Correlation::exponential: {
      const Chunk s = r2.sqrt();
      const Chunk r = exp_of_negative(Chunk(-s));
      return {r, (s > 0.0).select(r / s, 0.0)};
    }
    case Correlation::matern32: {
      const Chunk s = (3.0 * r2).sqrt();
      const Chunk e = exp_of_negative(Chunk(-s));
      return {(1.0 + s) * e, 3.0 * e};
    }
    case Correlation::matern52: {
      const Chunk s = (5.0 * r2).sqrt();
      const Chunk e = exp_of_negative(Chunk(-s));
      return {(1.0 + s + s.square() / 3.0) * e, (5.0 / 3.0) * (1.0 + s) * e};
    }
    default: {  // squared exponential
      const Chunk r = exp_of_negative(Chunk(-0.5 * r2));
      return {r, r};
    }
  }
}

void rational_quadratic(double alpha, Index n, double* r2, Slopes slopes) {
  for (Index i = 0; i < n; ++i) {
    const double s = r2[i] / (2.0 * alpha);
    const double logarithm = std::log1p(s);
    r2[i] = std::exp(-alpha * logarithm);
    if (slopes.scale != nullptr) slopes.scale[i] = r2[i] / (1.0 + s);
    if (slopes.alpha != nullptr) slopes.alpha[i] = alpha * r2[i] * (s / (1.0 + s) - logarithm);
  }
}

void correlate_(Correlation correlation, double alpha, Index n, double* r2, Slopes slopes) {
  if (correlation == Correlation::rational_quadratic)
    return rational_quadratic(alpha, n, r2, slopes);
  for (Index i = 0; i < n; i += kChunk) {
    const Correlated c = correlate_chunk(correlation, load(r2 + i, n - i));
    store(c.r, r2 + i, n - i);
    if (slopes.scale != nullptr) store(c.g, slopes.scale + i, n - i);
  }
}

double weighted_square_sum_(const double* x, Index n, double q, const double* c) {
  constexpr Index kLanes = 8;
  using Lanes = Eigen::Array<double, kLanes, 1>;
  using Numbers = Eigen::Map<const Lanes>;
  Lanes sums = Lanes::Zero();
  Index i = 0;
  for (; i + kLanes <= n; i += kLanes) sums += Numbers(c + i) * (Numbers(x + i) - q).square();
  double rest = 0.0;
  for (; i < n; ++i) rest += c[i] * (x[i] - q) * (x[i] - q);
  return sums.sum() + rest;
}

/// Columns [k, k + size) of the factor, those to their left being done.
bool factor_panel(Eigen::MatrixXd& a, Index k, Index size) {
  const Index n = a.rows();
  if (k > 0)
    a.block(k, k, n - k, size).noalias() -=
        a.block(k, 0, n - k, k) * a.block(k, 0, size, k).transpose();
  for (Index j = k; j < k + size; ++j) {
    auto column = a.col(j).tail(n - j);
    for (Index i = k; i < j; ++i) column -= a(j, i) * a.col(i).tail(n - j);
    if (!(a(j, j) > 0.0)) return false;
    column /= std::sqrt(a(j, j));
  }
  return true;
}

bool cholesky_(double* a, Index n) {
  thread_local Eigen::MatrixXd m;
  m = ConstSquare(a, n, n);
  const Index block = block_for(n);
  for (Index k = 0; k < n; k += block)
    if (!factor_panel(m, k, std::min(block, n - k))) return false;
  Square(a, n, n).triangularView<Eigen::Lower>() = m;
  return true;
}

/// By blocks of rows, P_bb = L_bb^-1 and P_b = -P_bb L_b P of the rows above.
void lower_inverse_(const double* l_data, Index n, double* p_data) {
  thread_local Eigen::MatrixXd l;
  thread_local Eigen::MatrixXd p;
  thread_local Eigen::MatrixXd left;
  l = ConstSquare(l_data, n, n);
  p.setZero(n, n);
  const Index block = block_for(n);
  left.resize(block, n);
  for (Index b = 0; b < n; b += block) {
    const Index s = std::min(block, n - b);
    p.block(b, b, s, s) =
        l.block(b, b, s, s).triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(s, s));
    for (Index c = 0; c < b; c += 2 * block) {
      const Index t = std::min(2 * block, b - c);
      left.block(0, c, s, t).noalias() = l.block(b, c, s, b - c) * p.block(c, c, b - c, t);
    }
    if (b > 0) p.block(b, 0, s, b).noalias() = -p.block(b, b, s, s) * left.topLeftCorner(s, b);
  }
  Square(p_data, n, n) = p;
}

void inverse_from_(const double* p_data, Index n, double* c_data) {
  thread_local Eigen::MatrixXd p;
  thread_local Eigen::MatrixXd c;
  p = ConstSquare(p_data, n, n);
  c.resize(n, n);
  const Index block = block_for(n);
  for (Index b = 0; b < n; b += block) {
    const Index s = std::min(block, n - b);
    c.block(b, 0, s, b + s).noalias() =
        p.block(b, b, n - b, s).transpose() * p.block(b, 0, n - b, b + s);
  }
  Square(c_data, n, n).triangularView<Eigen::Lower>() = c;
}

void solve_lower_(const double* l, Index n, double* b, Index m) {
  Eigen::MatrixXd right = ConstSquare(b, n, m);
  ConstSquare(l, n, n).triangularView<Eigen::Lower>().solveInPlace(right);
  Square(b, n, m) = right;
}

void multiply_lower_(const double* p, Index n, double* b, Index m) {
  constexpr Index kRows = 48;
  thread_local Eigen::MatrixXd right;
  thread_local Eigen::MatrixXd product;
  right = ConstSquare(b, n, m);
  product.resize(n, m);
  for (Index r = 0; r < n; r += kRows) {
    const Index s = std::min(kRows, n - r);
    product.middleRows(r, s).noalias() =
        ConstSquare(p, n, n).block(r, 0, s, r + s) * right.topRows(r + s);
  }
  Square(b, n, m) = product;
}

constexpr Dense kDense{REPOSE_DENSE_NAME,    squared_distances_, correlate_,
                       weighted_square_sum_, cholesky_,          lower_inverse_,
                       inverse_from_,        solve_lower_,       multiply_lower_};

}  // namespace
}  // namespace repose::surrogate

// The loops in which a Gaussian process spends its time, for the processor at hand.
//
// Each exists twice, for any x86-64 and for x86-64-v3 (AVX2, FMA), which does twice as much a
// cycle; the second is taken where the processor has it. Results of the two differ by rounding.
// Matrices are stored by columns, n x n ones without gaps.
#pragma once

#include <cstddef>

#include "repose/surrogate/kernel.hpp"

namespace repose::surrogate {

using Index = std::ptrdiff_t;

/// Derivatives of a correlation R, arrays as long as R; null where not wanted.
struct Slopes {
  double* scale = nullptr;  ///< G with dR/dlog l_k = G (dx_k/l_k)^2
  double* alpha = nullptr;  ///< dR/dlog alpha
};

struct Dense {
  const char* name;  ///< "x86-64", "x86-64-v3"

  /// out[i] = sum_k weight[k] (x[i + k stride] - q[k q_stride])^2 for i in [0, n): squared
  /// distances of n points, stored by coordinate, from one.
  void (*squared_distances)(const double* x, Index n, Index stride, Index dimension,
                            const double* q, Index q_stride, const double* weight, double* out);
  /// Replaces r^2 by R.
  void (*correlate)(Correlation correlation, double alpha, Index n, double* r2, Slopes slopes);
  /// sum_i c[i] (x[i] - q)^2.
  double (*weighted_square_sum)(const double* x, Index n, double q, const double* c);
  /// Lower Cholesky factor in place, the upper triangle left alone; false where a pivot is not
  /// positive. n^3/3 flops.
  bool (*cholesky)(double* a, Index n);
  /// p = L^-1, zeros above. n^3/3 flops.
  void (*lower_inverse)(const double* l, Index n, double* p);
  /// Lower triangle of c = P^T P, P lower; the rest undefined. n^3/3 flops.
  void (*inverse_from)(const double* p, Index n, double* c);
  /// b (n x m) becomes L^-1 b. n^2 m flops.
  void (*solve_lower)(const double* l, Index n, double* b, Index m);
  /// b (n x m) becomes P b, P lower, zeros above. n^2 m flops, faster than solve_lower.
  void (*multiply_lower)(const double* p, Index n, double* b, Index m);
};

/// Chosen once, at the first call.
const Dense& dense();
const Dense& dense_baseline();
/// Null where it was not built (another processor architecture).
const Dense* dense_v3();

}  // namespace repose::surrogate

// Correlation functions of scaled distance, over plain arrays: the inner loops of every Gaussian
// process.
#pragma once

#include "repose/base/parameter_space.hpp"
#include "repose/surrogate/kernel.hpp"

namespace repose::surrogate {

/// A correlation function with its parameters; weight[k] = 1/l^2 of coordinate k.
struct Correlator {
  Correlation correlation = Correlation::matern52;
  double alpha = 1.0;
  Vector weight;
};

/// Derivatives of a correlation R, arrays as long as R; null where not wanted.
struct Slopes {
  double* scale = nullptr;  ///< G with dR/dlog l_k = G (dx_k/l_k)^2
  double* alpha = nullptr;  ///< dR/dlog alpha
};

/// out[i] = sum_k weight[k] (x[i + k stride] - q[k q_stride])^2 for i in [0, n): squared distances
/// of n points, stored by coordinate, from one.
void squared_distances(const double* x, Eigen::Index n, Eigen::Index stride, Eigen::Index dimension,
                       const double* q, Eigen::Index q_stride, const double* weight, double* out);

/// Replaces r^2 by R.
void correlate(Correlation correlation, double alpha, Eigen::Index n, double* r2,
               Slopes slopes = {});

/// sum_i c[i] (x[i] - q)^2.
double weighted_square_sum(const double* x, Eigen::Index n, double q, const double* c);

/// n x m correlations between the rows of x (n x d) and of q (m x d).
Matrix cross_correlation(const Correlator& correlator, const Matrix& x, const Matrix& q);

/// Lower triangle with unit diagonal; the rest is left alone. Of the slopes, n x n, only what lies
/// below the diagonal is filled; empty matrices are not wanted.
void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower, Matrix& slope,
                      Matrix& alpha_slope);
void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower);

}  // namespace repose::surrogate

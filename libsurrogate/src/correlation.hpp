// Correlation functions of scaled distance, over plain arrays: the inner loops of every Gaussian
// process.
#pragma once

#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

/// out[i] = sum_k weight[k] (x[i + k stride] - q[k q_stride])^2 for i in [0, n): squared distances
/// of n points, stored by coordinate, from one.
void squared_distances(const double* x, Eigen::Index n, Eigen::Index stride, Eigen::Index dimension,
                       const double* q, Eigen::Index q_stride, const double* weight, double* out);

/// Replaces r^2 by the correlation R. Where `slope` is not null it receives G with
/// dR/dlog l_k = G (dx_k/l_k)^2.
void correlate(Kernel kernel, Eigen::Index n, double* r2, double* slope);

/// sum_i c[i] (x[i] - q)^2.
double weighted_square_sum(const double* x, Eigen::Index n, double q, const double* c);

/// n x m correlations between the rows of x (n x d) and of q (m x d), coordinates divided by
/// `length_scales`.
Matrix cross_correlation(Kernel kernel, const Matrix& x, const Matrix& q,
                         const Vector& length_scales);

/// Lower triangle with unit diagonal; the rest is left alone. `slope` as above, or null.
void fill_correlation(Kernel kernel, const Matrix& x, const Vector& length_scales, Matrix& lower,
                      Matrix* slope);

}  // namespace repose::surrogate

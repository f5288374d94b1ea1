#include "correlation.hpp"

#include <cmath>

namespace repose::surrogate {

void squared_distances(const double* x, Eigen::Index n, Eigen::Index stride, Eigen::Index dimension,
                       const double* q, Eigen::Index q_stride, const double* weight, double* out) {
  for (Eigen::Index i = 0; i < n; ++i) out[i] = 0.0;
  for (Eigen::Index k = 0; k < dimension; ++k) {
    const double* xk = x + k * stride;
    const double qk = q[k * q_stride];
    const double w = weight[k];
    for (Eigen::Index i = 0; i < n; ++i) {
      const double dx = xk[i] - qk;
      out[i] += w * dx * dx;
    }
  }
}

void correlate(Kernel kernel, Eigen::Index n, double* r2, double* slope) {
  switch (kernel) {
    case Kernel::squared_exponential:
      for (Eigen::Index i = 0; i < n; ++i) r2[i] = std::exp(-0.5 * r2[i]);
      if (slope != nullptr)
        for (Eigen::Index i = 0; i < n; ++i) slope[i] = r2[i];
      return;
    case Kernel::matern52:
      for (Eigen::Index i = 0; i < n; ++i) {
        const double s = std::sqrt(5.0 * r2[i]);
        const double e = std::exp(-s);
        if (slope != nullptr) slope[i] = (5.0 / 3.0) * (1.0 + s) * e;
        r2[i] = (1.0 + s + s * s / 3.0) * e;
      }
      return;
  }
}

double weighted_square_sum(const double* x, Eigen::Index n, double q, const double* c) {
  double sum[4] = {0.0, 0.0, 0.0, 0.0};
  Eigen::Index i = 0;
  for (; i + 4 <= n; i += 4)
    for (int lane = 0; lane < 4; ++lane) {
      const double dx = x[i + lane] - q;
      sum[lane] += c[i + lane] * dx * dx;
    }
  for (; i < n; ++i) {
    const double dx = x[i] - q;
    sum[0] += c[i] * dx * dx;
  }
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

Matrix cross_correlation(Kernel kernel, const Matrix& x, const Matrix& q,
                         const Vector& length_scales) {
  const Vector weight = length_scales.array().square().inverse();
  Matrix r(x.rows(), q.rows());
  for (Eigen::Index j = 0; j < q.rows(); ++j) {
    double* column = r.col(j).data();
    squared_distances(x.data(), x.rows(), x.rows(), x.cols(), q.data() + j, q.rows(), weight.data(),
                      column);
    correlate(kernel, x.rows(), column, nullptr);
  }
  return r;
}

void fill_correlation(Kernel kernel, const Matrix& x, const Vector& length_scales, Matrix& lower,
                      Matrix* slope) {
  const Vector weight = length_scales.array().square().inverse();
  const Eigen::Index n = x.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    lower(j, j) = 1.0;
    const Eigen::Index below = n - 1 - j;
    double* column = lower.data() + j * n + j + 1;
    squared_distances(x.data() + j + 1, below, n, x.cols(), x.data() + j, n, weight.data(), column);
    correlate(kernel, below, column, slope != nullptr ? slope->data() + j * n + j + 1 : nullptr);
  }
}

}  // namespace repose::surrogate

#include "correlation.hpp"

#include <cmath>

namespace repose::surrogate {
namespace {

void exponential(Eigen::Index n, double* r2, double* slope) {
  for (Eigen::Index i = 0; i < n; ++i) {
    const double r = std::sqrt(r2[i]);
    r2[i] = std::exp(-r);
    if (slope != nullptr) slope[i] = r > 0.0 ? r2[i] / r : 0.0;
  }
}

void matern32(Eigen::Index n, double* r2, double* slope) {
  for (Eigen::Index i = 0; i < n; ++i) {
    const double s = std::sqrt(3.0 * r2[i]);
    const double e = std::exp(-s);
    if (slope != nullptr) slope[i] = 3.0 * e;
    r2[i] = (1.0 + s) * e;
  }
}

void matern52(Eigen::Index n, double* r2, double* slope) {
  for (Eigen::Index i = 0; i < n; ++i) {
    const double s = std::sqrt(5.0 * r2[i]);
    const double e = std::exp(-s);
    if (slope != nullptr) slope[i] = (5.0 / 3.0) * (1.0 + s) * e;
    r2[i] = (1.0 + s + s * s / 3.0) * e;
  }
}

void squared_exponential(Eigen::Index n, double* r2, double* slope) {
  for (Eigen::Index i = 0; i < n; ++i) {
    r2[i] = std::exp(-0.5 * r2[i]);
    if (slope != nullptr) slope[i] = r2[i];
  }
}

void rational_quadratic(double alpha, Eigen::Index n, double* r2, Slopes slopes) {
  for (Eigen::Index i = 0; i < n; ++i) {
    const double s = r2[i] / (2.0 * alpha);
    const double logarithm = std::log1p(s);
    r2[i] = std::exp(-alpha * logarithm);
    if (slopes.scale != nullptr) slopes.scale[i] = r2[i] / (1.0 + s);
    if (slopes.alpha != nullptr) slopes.alpha[i] = alpha * r2[i] * (s / (1.0 + s) - logarithm);
  }
}

}  // namespace

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

void correlate(Correlation correlation, double alpha, Eigen::Index n, double* r2, Slopes slopes) {
  switch (correlation) {
    case Correlation::exponential:
      return exponential(n, r2, slopes.scale);
    case Correlation::matern32:
      return matern32(n, r2, slopes.scale);
    case Correlation::matern52:
      return matern52(n, r2, slopes.scale);
    case Correlation::squared_exponential:
      return squared_exponential(n, r2, slopes.scale);
    case Correlation::rational_quadratic:
      return rational_quadratic(alpha, n, r2, slopes);
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

Matrix cross_correlation(const Correlator& correlator, const Matrix& x, const Matrix& q) {
  Matrix r(x.rows(), q.rows());
  for (Eigen::Index j = 0; j < q.rows(); ++j) {
    double* column = r.col(j).data();
    squared_distances(x.data(), x.rows(), x.rows(), x.cols(), q.data() + j, q.rows(),
                      correlator.weight.data(), column);
    correlate(correlator.correlation, correlator.alpha, x.rows(), column);
  }
  return r;
}

void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower, Matrix& slope,
                      Matrix& alpha_slope) {
  const Eigen::Index n = x.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    lower(j, j) = 1.0;
    const Eigen::Index below = n - 1 - j;
    const Eigen::Index first = j * n + j + 1;
    double* column = lower.data() + first;
    squared_distances(x.data() + j + 1, below, n, x.cols(), x.data() + j, n,
                      correlator.weight.data(), column);
    correlate(correlator.correlation, correlator.alpha, below, column,
              {slope.size() > 0 ? slope.data() + first : nullptr,
               alpha_slope.size() > 0 ? alpha_slope.data() + first : nullptr});
  }
}

void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower) {
  Matrix unwanted;
  fill_correlation(correlator, x, lower, unwanted, unwanted);
}

}  // namespace repose::surrogate

#include "correlation.hpp"

#include <cmath>

namespace repose::surrogate {

Matrix cross_correlation(const Correlator& correlator, const Matrix& x, const Matrix& q) {
  const Dense& loops = dense();
  Matrix r(x.rows(), q.rows());
  for (Eigen::Index j = 0; j < q.rows(); ++j) {
    double* column = r.col(j).data();
    loops.squared_distances(x.data(), x.rows(), x.rows(), x.cols(), q.data() + j, q.rows(),
                            correlator.weight.data(), column);
    loops.correlate(correlator.correlation, correlator.alpha, x.rows(), column, {});
  }
  return r;
}

CrossCorrelation::CrossCorrelation(const Correlator& correlator, const Matrix& x, const Matrix& q)
    : r(x.rows(), q.rows()), slope(x.rows(), q.rows()) {
  const Dense& loops = dense();
  const bool has_alpha = correlator.correlation == Correlation::rational_quadratic;
  if (has_alpha) alpha_slope.resize(x.rows(), q.rows());
  for (Eigen::Index j = 0; j < q.rows(); ++j) {
    loops.squared_distances(x.data(), x.rows(), x.rows(), x.cols(), q.data() + j, q.rows(),
                            correlator.weight.data(), r.col(j).data());
    loops.correlate(correlator.correlation, correlator.alpha, x.rows(), r.col(j).data(),
                    {slope.col(j).data(), has_alpha ? alpha_slope.col(j).data() : nullptr});
  }
}

SecondSlopes::SecondSlopes(const Correlator& correlator, const Matrix& x, const Matrix& q,
                           const CrossCorrelation& k) {
  Eigen::ArrayXd r2(x.rows());
  dense().squared_distances(x.data(), x.rows(), x.rows(), x.cols(), q.data(), q.rows(),
                            correlator.weight.data(), r2.data());
  const auto g = k.slope.col(0).array();
  const Eigen::ArrayXd distance = r2.sqrt();
  const auto unless_zero = [&r2](const Eigen::ArrayXd& values) -> Vector {
    return (r2 > 0.0).select(values, 0.0);
  };
  switch (correlator.correlation) {
    case Correlation::exponential:
      scale = unless_zero(-0.5 * g * (1.0 + distance) / r2);
      return;
    case Correlation::matern32:
      scale = unless_zero(-0.5 * std::sqrt(3.0) * g / distance);
      return;
    case Correlation::matern52:
      scale = -2.5 * g / (1.0 + std::sqrt(5.0) * distance);
      return;
    case Correlation::squared_exponential:
      scale = -0.5 * g;
      return;
    case Correlation::rational_quadratic:
      break;
  }
  const double a = correlator.alpha;
  const Eigen::ArrayXd s = r2 / (2.0 * a);
  scale = -(a + 1.0) / (2.0 * a) * g / (1.0 + s);
  // of alpha R (s/(1 + s) - log(1 + s)) with dR/dr^2 = -g/2
  alpha = -0.5 * a * g * (s / (1.0 + s) - s.log1p()) -
          0.5 * k.r.col(0).array() * s / (1.0 + s).square();
}

void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower, Matrix& slope,
                      Matrix& alpha_slope) {
  const Dense& loops = dense();
  const Eigen::Index n = x.rows();
  for (Eigen::Index j = 0; j < n; ++j) {
    lower(j, j) = 1.0;
    const Eigen::Index below = n - 1 - j;
    const Eigen::Index first = j * n + j + 1;
    double* column = lower.data() + first;
    loops.squared_distances(x.data() + j + 1, below, n, x.cols(), x.data() + j, n,
                            correlator.weight.data(), column);
    loops.correlate(correlator.correlation, correlator.alpha, below, column,
                    {slope.size() > 0 ? slope.data() + first : nullptr,
                     alpha_slope.size() > 0 ? alpha_slope.data() + first : nullptr});
  }
}

void fill_correlation(const Correlator& correlator, const Matrix& x, Matrix& lower) {
  Matrix unwanted;
  fill_correlation(correlator, x, lower, unwanted, unwanted);
}

}  // namespace repose::surrogate

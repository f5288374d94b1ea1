#include "correlation.hpp"

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

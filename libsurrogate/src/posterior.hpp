// The joint distribution of a Gaussian process at many points, given its data.
#pragma once

#include "state.hpp"

namespace repose::surrogate {

/// Standardised, in units of the process variance: covariance k(q_i, q_j) - v_i^T v_j + t_i^T t_j
/// + e_i^T e_j with V = L^-1 k(X, q) and T = U^-T h(q) - Q1^T V; the last two parts are the
/// coefficients' own uncertainty and that of the hyper-parameters, to first order.
struct Posterior {
  Matrix at;  ///< m x p, encoded
  Vector mean;
  Matrix v;  ///< n x m
  Matrix t;  ///< q x m
  Matrix e;  ///< r x m

  /// With L^-1, where many points follow each other, V is a product and no solution.
  Posterior(const ModelAccess::State& s, const Matrix& natural, const Matrix* l_inverse = nullptr);
  /// 1 - |v_i|^2: at known coefficients.
  Vector kriging_variance() const { return 1.0 - v.colwise().squaredNorm().transpose().array(); }
  Vector trend_variance() const { return t.colwise().squaredNorm(); }
  Vector variance() const {
    return kriging_variance() + trend_variance() + e.colwise().squaredNorm().transpose();
  }
  Vector covariance_with(const ModelAccess::State& s, Eigen::Index j) const;
};

}  // namespace repose::surrogate

// Draws of several quantities at several points at once, and of others given these.
#pragma once

#include "believed.hpp"

namespace repose::opt {

/// Joint posterior draws of every quantity at n points: f_j = mean_j + L_j xi_j, L_j L_j^T the
/// posterior covariance.
class JointDraws {
 public:
  JointDraws(std::span<const Surrogate> models, const Matrix& points, Eigen::Index draws,
             std::uint64_t seed);

  /// The objective at point i in draw m: n x draws.
  Matrix objective(const Goal& goal) const;

  /// What the draws say of quantity j at other points: the mean is shifted by shift(p, m), the
  /// variance is reduced by explained[p] [Rasmussen2006, Eq. 2.19].
  struct Conditional {
    Matrix shift;
    Vector explained;
  };
  Conditional given(std::size_t quantity, const Matrix& at) const;

 private:
  std::span<const Surrogate> models_;
  Matrix points_;
  Eigen::Index draws_;
  std::vector<Vector> mean_;
  std::vector<Matrix> factor_;  ///< 0 x 0 where nothing is uncertain
  std::vector<Matrix> normal_;
};

}  // namespace repose::opt

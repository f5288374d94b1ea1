#include "minimum_norm.hpp"

#include <Eigen/QR>

namespace repose::surrogate {
namespace {

constexpr double kNegligiblePivot = 1e-11;

}  // namespace

MinimumNormFit minimum_norm_fit(const Matrix& x, const Vector& y, const Vector& weights) {
  const Vector root_weights = weights.cwiseSqrt();
  Eigen::CompleteOrthogonalDecomposition<Matrix> decomposition;
  decomposition.setThreshold(kNegligiblePivot);
  decomposition.compute(root_weights.asDiagonal() * x);
  const Eigen::Index r = decomposition.rank();
  MinimumNormFit fit{.coefficients = decomposition.solve(root_weights.cwiseProduct(y)), .rank = r};
  // X P = Q [T 0; 0 0] Z, so that the rows are spanned by V = P Z^T [I; 0] and X^+ = V T^-1 Q^T
  // (Eigen 3.4 computes no Z where the rank is full, and matrixZ() is then not the identity)
  const Matrix z = r < x.cols() ? Matrix(decomposition.matrixZ().adjoint().leftCols(r))
                                : Matrix(Matrix::Identity(r, r));
  fit.row_space = decomposition.colsPermutation() * z;
  fit.root = decomposition.matrixT()
                 .topLeftCorner(r, r)
                 .triangularView<Eigen::Upper>()
                 .solve<Eigen::OnTheRight>(fit.row_space);
  return fit;
}

}  // namespace repose::surrogate

#include "joint_draws.hpp"

#include <Eigen/Cholesky>

#include "repose/base/random.hpp"

namespace repose::opt {
namespace {

/// Lower Cholesky factor, the diagonal raised as far as rounding asks for; 0 x 0 for no variance.
Matrix factor_of(Matrix covariance) {
  const double largest = covariance.diagonal().maxCoeff();
  if (!(largest > 0.0)) return {};
  for (double jitter = 1e-12;; jitter *= 100.0) {
    covariance.diagonal().array() += jitter * largest;
    const Eigen::LLT<Matrix> llt(covariance);
    if (llt.info() == Eigen::Success) return llt.matrixL();
    if (jitter > 1.0) return {};
  }
}

}  // namespace

JointDraws::JointDraws(std::span<const Surrogate> models, const Matrix& points, Eigen::Index draws,
                       std::uint64_t seed)
    : models_(models), points_(points), draws_(draws) {
  for (std::size_t j = 0; j < models.size(); ++j) {
    const std::vector<Gaussian> predicted = models[j].predict_rows(points);
    Vector mean(points.rows());
    for (Eigen::Index i = 0; i < mean.size(); ++i)
      mean[i] = predicted[static_cast<std::size_t>(i)].mean;
    mean_.push_back(std::move(mean));
    factor_.push_back(factor_of(models[j].covariance(points, points)));
    Matrix normal(points.rows(), draws);
    for (Eigen::Index m = 0; m < draws; ++m) {
      RandomStream random(seed, static_cast<std::uint64_t>(m) * models.size() + j);
      for (double& value : normal.col(m)) value = random.normal();
    }
    normal_.push_back(std::move(normal));
  }
}

Matrix JointDraws::objective(const Goal& goal) const {
  std::vector<Matrix> values;
  for (std::size_t j = 0; j < models_.size(); ++j) {
    Matrix f = mean_[j].replicate(1, draws_);
    if (factor_[j].size() > 0) f.noalias() += factor_[j] * normal_[j];
    values.push_back(std::move(f));
  }
  Matrix result(points_.rows(), draws_);
  std::vector<double> at(values.size());
  for (Eigen::Index m = 0; m < draws_; ++m)
    for (Eigen::Index i = 0; i < points_.rows(); ++i) {
      for (std::size_t j = 0; j < at.size(); ++j) at[j] = values[j](i, m);
      result(i, m) = goal.objective(std::span<const double>(at));
    }
  return result;
}

JointDraws::Conditional JointDraws::given(std::size_t quantity, const Matrix& at) const {
  if (factor_[quantity].size() == 0)
    return {Matrix::Zero(at.rows(), draws_), Vector::Zero(at.rows())};
  Matrix w = models_[quantity].covariance(points_, at);
  factor_[quantity].triangularView<Eigen::Lower>().solveInPlace(w);
  return {w.transpose() * normal_[quantity], w.colwise().squaredNorm().transpose()};
}

}  // namespace repose::opt

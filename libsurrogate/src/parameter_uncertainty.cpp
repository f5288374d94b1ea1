#include "parameter_uncertainty.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "search.hpp"

namespace repose::surrogate {
namespace {

/// Of the log parameters before any data: 1/standard deviation^2.
constexpr double kVague = 1.0 / (2.0 * 2.0);
/// Of the differences of gradients, in log parameters.
constexpr double kStep = 1e-3;
/// Below this the variance of a t distribution says little about its middle.
constexpr double kLeastFreedom = 4.0;

std::vector<Eigen::Index> inside(const Vector& p, const opt::Bounds& bounds) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < p.size(); ++k)
    if (p[k] > bounds.lower[k] + kAtBound && p[k] < bounds.upper[k] - kAtBound) free.push_back(k);
  return free;
}

/// Over the free parameters; not finite where an evaluation fails.
Matrix hessian(const NegativeLogPosterior& objective, const Vector& p,
               const std::vector<Eigen::Index>& free) {
  const auto size = static_cast<Eigen::Index>(free.size());
  Vector here(p.size());
  Vector there(p.size());
  Matrix h(size, size);
  bool all_there = std::isfinite(objective(p, &here));
  for (Eigen::Index j = 0; j < size; ++j) {
    double step = kStep;
    const auto moved = [&] {
      Vector q = p;
      q[free[static_cast<std::size_t>(j)]] += step;
      return q;
    };
    if (!std::isfinite(objective(moved(), &there))) {  // at the edge of what can be factored
      step = -kStep;
      all_there = all_there && std::isfinite(objective(moved(), &there));
    }
    h.col(j) = (there - here)(free) / step;
  }
  if (!all_there) h.setConstant(std::nan(""));
  return 0.5 * (h + h.transpose());
}

/// Rows of the shape's parameters as sums of rows of the objective's.
Matrix shape_rows(const NegativeLogPosterior& objective, const Matrix& rows) {
  const Eigen::Index before = objective.amplitude_parameter();  // scales and alpha
  Matrix shape = Matrix::Zero(before + 1, rows.cols());
  shape.topRows(before) = rows.topRows(before);
  if (objective.estimates_noise()) shape.row(before) = rows.row(objective.noise_parameter());
  if (objective.searches_amplitude()) shape.row(before) -= rows.row(before);
  return shape;
}

/// dk_s(q)^T a for s shape parameters, s x m at m points; the noise ratio changes no k.
Matrix through_correlations(const Dataset& data, const Correlator& correlator, const Vector& a,
                            const Matrix& q, const CrossCorrelation& k, Eigen::Index shape) {
  const Dense& loops = dense();
  const Eigen::Index n = data.points();
  Matrix by_parameter = Matrix::Zero(shape, q.rows());
  Vector weighted(n);
  for (Eigen::Index j = 0; j < q.rows(); ++j) {
    weighted = k.slope.col(j).cwiseProduct(a);
    for (Eigen::Index c = 0; c < data.encoding.coordinates(); ++c)
      by_parameter(data.encoding.scale_of(c), j) +=
          correlator.weight[c] *
          loops.weighted_square_sum(data.x.col(c).data(), n, q(j, c), weighted.data());
  }
  if (k.alpha_slope.size() > 0)
    by_parameter.row(data.encoding.scales()) = a.transpose() * k.alpha_slope;
  return by_parameter;
}

}  // namespace

ParameterPosterior approximate_posterior(const NegativeLogPosterior& objective, const Vector& p,
                                         const opt::Bounds& bounds, const Freedom& freedom) {
  const std::vector<Eigen::Index> free = inside(p, bounds);
  if (free.empty()) return {};
  const Matrix h = hessian(objective, p, free);
  if (!h.allFinite()) return {};
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(h);
  const Vector known = eigen.eigenvalues().cwiseMax(0.0);
  Matrix rows = Matrix::Zero(p.size(), known.size());
  rows(free, Eigen::all) =
      eigen.eigenvectors() * (known.array() + kVague).rsqrt().matrix().asDiagonal();
  ParameterPosterior posterior{.root = shape_rows(objective, rows)};
  if (!objective.searches_amplitude()) {
    const double spent = (known.array() / (known.array() + kVague)).sum();
    const double left =
        std::max(kLeastFreedom, freedom.observations - freedom.coefficients - spent);
    posterior.variance_factor = std::max(1.0, freedom.divisor() / (left - 2.0));
  }
  return posterior;
}

MeanSensitivity::MeanSensitivity(const Dataset& data, const Covariance& covariance,
                                 const Factor& factor, const Matrix& root, double unit)
    : root_(root / unit) {
  const Correlator correlator = covariance.correlator(data.encoding);
  const Eigen::Index n = data.points();
  const Vector& a = factor.alpha;
  Matrix by_parameter(n, root.rows());  // dC a; row i is what the mean at x_i would have of dk
  for (Eigen::Index i = 0; i < n; ++i) {
    const Matrix q = data.x.row(i);
    by_parameter.row(i) = through_correlations(data, correlator, a, q,
                                               CrossCorrelation(correlator, data.x, q), root.rows())
                              .transpose();
  }
  by_parameter.col(root.rows() - 1) = covariance.noise_ratio * data.noise.cwiseProduct(a);
  const auto l = factor.l.triangularView<Eigen::Lower>();
  Matrix w = l.solve(by_parameter * root_);
  const Matrix projected = factor.q1.transpose() * w;
  by_trend_ = factor.u.triangularView<Eigen::Upper>().solve(projected);
  w.noalias() -= factor.q1 * projected;
  by_correlation_ = factor.l.transpose().triangularView<Eigen::Upper>().solve(w);
}

Matrix MeanSensitivity::at(const Dataset& data, const Correlator& correlator, const Vector& alpha,
                           const Matrix& q, const Matrix& h, const CrossCorrelation& k) const {
  Matrix e = root_.transpose() * through_correlations(data, correlator, alpha, q, k, root_.rows());
  e.noalias() -= by_correlation_.transpose() * k.r;
  e.noalias() -= by_trend_.transpose() * h.transpose();
  return e;
}

/// E = root^T T - Z^T k - c^T h with T_s = sum_i a_i G_i sum_{c in s} w_c u_ic^2, u = q - x; with y
/// = root E and z = Z E, d(E^T E)/2 = y^T dT - z^T dk - (c E)^T dh; dk = -G w u du, dG = 2 G' w u
/// du, G' the derivative in r^2.
Vector MeanSensitivity::squared_by_coordinates(const Dataset& data, const Correlator& correlator,
                                               const Vector& alpha, const Matrix& q,
                                               const CrossCorrelation& k, const Vector& e) const {
  const Encoding& encoding = data.encoding;
  const Vector y = root_ * e;
  const Vector g = k.slope.col(0);
  const SecondSlopes second(correlator, data.x, q, k);
  Vector r2_by_y = Vector::Zero(data.points());  // sum_s y_s sum_{c in s} w_c u_ic^2
  for (Eigen::Index c = 0; c < encoding.coordinates(); ++c)
    r2_by_y.array() +=
        y[encoding.scale_of(c)] * correlator.weight[c] * (q(0, c) - data.x.col(c).array()).square();
  Vector by_r2 = alpha.cwiseProduct(second.scale).cwiseProduct(r2_by_y);
  if (k.alpha_slope.size() > 0) by_r2 += y[encoding.scales()] * alpha.cwiseProduct(second.alpha);
  const Vector by_k = by_correlation_ * e;
  Vector gradient(encoding.coordinates());
  for (Eigen::Index c = 0; c < gradient.size(); ++c) {
    const Vector each = 2.0 * by_r2 + g.cwiseProduct(2.0 * y[encoding.scale_of(c)] * alpha + by_k);
    gradient[c] = 2.0 * correlator.weight[c] * (q(0, c) - data.x.col(c).array()).matrix().dot(each);
  }
  return gradient;
}

}  // namespace repose::surrogate

// Predictions of a Gaussian process and their derivatives.
#include <fmt/format.h>

#include <cmath>

#include "posterior.hpp"
#include "repose/base/error.hpp"
#include "response.hpp"

namespace repose::surrogate {
namespace {

using State = ModelAccess::State;

constexpr Eigen::Index kBlock = 128;
/// Rows a point of the data from which L^-1, n^3/3 flops, is worth its while.
constexpr Eigen::Index kManyRows = 8;
constexpr double kFarFromData = 0.8 * 0.8;  // of the process variance

/// Of standardised responses, in units of the process variance.
struct Block {
  Vector mean;
  Vector kriging_variance;
  Vector variance;
};

/// On the scale that is modelled.
Gaussian modelled_at(const State& s, const Block& block, Eigen::Index i) {
  return {s.data.shift + s.data.scale * block.mean[i],
          s.predicted_amplitude() * std::max(0.0, block.variance[i])};
}

template <class Use>
void for_each_row(const State& s, const Matrix& x, const Use& use) {
  const bool many = x.rows() >= kManyRows * s.data.points();
  const Matrix l_inverse = many ? lower_inverse(s.factor.l) : Matrix();
  for (Eigen::Index begin = 0; begin < x.rows(); begin += kBlock) {
    const Eigen::Index size = std::min(kBlock, x.rows() - begin);
    const Posterior posterior(s, x.middleRows(begin, size), many ? &l_inverse : nullptr);
    const Block block{posterior.mean, posterior.kriging_variance(), posterior.variance()};
    for (Eigen::Index i = 0; i < size; ++i) use(block, i, begin + i);
  }
}

}  // namespace

std::vector<Gaussian> GaussianProcess::predict_rows(const Matrix& x) const {
  const State& s = *state_;
  std::vector<Gaussian> result;
  result.reserve(static_cast<std::size_t>(x.rows()));
  for_each_row(s, x, [&](const Block& block, Eigen::Index i, Eigen::Index) {
    result.push_back(moments(s.data.response_scale, modelled_at(s, block, i)).y);
  });
  return result;
}

Gaussian GaussianProcess::predict(const Vector& x) const {
  return predict_rows(x.transpose())[0];
}

std::vector<Prediction> GaussianProcess::predictions(const Matrix& x) const {
  const State& s = *state_;
  const double noise = noise_variance() * s.parameters.variance_factor;
  std::vector<Prediction> result;
  result.reserve(static_cast<std::size_t>(x.rows()));
  for_each_row(s, x, [&](const Block& block, Eigen::Index i, Eigen::Index row) {
    const Gaussian function = modelled_at(s, block, i);
    Prediction p{.function = moments(s.data.response_scale, function).y};
    p.observation_variance =
        moments(s.data.response_scale, {function.mean, function.variance + noise}).y.variance;
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      p.outside_range = p.outside_range || s.data.encoding.outside(k, x(row, k));
    p.far_from_data = block.kriging_variance[i] > kFarFromData;
    result.push_back(p);
  });
  return result;
}

Matrix GaussianProcess::covariance(const Matrix& a, const Matrix& b) const {
  const State& s = *state_;
  const Posterior at_a(s, a);
  const Posterior at_b(s, b);
  Matrix c = cross_correlation(s.covariance.correlator(s.data.encoding), at_a.at, at_b.at);
  c.noalias() -= at_a.v.transpose() * at_b.v;
  c.noalias() += at_a.t.transpose() * at_b.t;
  c.noalias() += at_a.e.transpose() * at_b.e;
  const double unit = s.predicted_amplitude();
  if (s.data.response_scale == ResponseScale::linear) return unit * c;
  // sd of y / sd of the modelled response, where that is known to vary
  const auto stretch = [&](const Posterior& p) {
    const Vector variance = unit * p.variance();
    Vector factor = Vector::Zero(variance.size());
    for (Eigen::Index i = 0; i < factor.size(); ++i)
      if (variance[i] > 0.0)
        factor[i] = std::sqrt(
            moments(s.data.response_scale, {s.data.shift + s.data.scale * p.mean[i], variance[i]})
                .y.variance /
            variance[i]);
    return factor;
  };
  return unit * (stretch(at_a).asDiagonal() * c * stretch(at_b).asDiagonal());
}

/// mean' = k'^T a + h'^T beta; variance' = -2 k'^T L^-T (w + Q1 t) + 2 h'^T U^-1 t with w = L^-1 k
/// and t = U^-T h - Q1^T w, as d(w^T w) = 2 (L^-T w)^T k'; k' = -G (q - x)/l^2.
opt::PredictionGradient GaussianProcess::predict_gradient(const Vector& x) const {
  const State& s = *state_;
  if (x.size() != dimension())
    throw InputError(
        fmt::format("a gradient at a point of {} inputs; the model has {}", x.size(), dimension()));
  const Encoding& encoding = s.data.encoding;
  const Matrix natural = x.transpose();
  const Matrix q = encoding.encode(natural);
  const Correlator correlator = s.covariance.correlator(encoding);
  const CrossCorrelation k(correlator, s.data.x, q);
  const Vector h = trend_matrix(s.data.trend, encoding, natural, q).row(0);
  const double mean = h.dot(s.factor.beta) + k.r.col(0).dot(s.factor.alpha);
  Vector w = k.r.col(0);
  s.factor.l.triangularView<Eigen::Lower>().solveInPlace(w);
  const Vector t =
      s.factor.u.transpose().triangularView<Eigen::Lower>().solve(h) - s.factor.q1.transpose() * w;
  Vector e;
  if (s.sensitivity.directions() > 0)
    e = s.sensitivity.at(s.data, correlator, s.factor.alpha, q, h.transpose(), k);
  const double variance = std::max(0.0, 1.0 - w.squaredNorm() + t.squaredNorm() + e.squaredNorm());
  const Vector by_k =
      -2.0 * s.factor.l.transpose().triangularView<Eigen::Upper>().solve(w + s.factor.q1 * t);
  Vector by_h = 2.0 * s.factor.u.triangularView<Eigen::Upper>().solve(t);
  Vector by_u = Vector::Zero(encoding.coordinates());
  if (s.sensitivity.directions() > 0) {
    by_h += s.sensitivity.squared_by_trend(e);
    by_u = s.sensitivity.squared_by_coordinates(s.data, correlator, s.factor.alpha, q, k, e);
  }

  const Matrix jacobian = trend_jacobian(s.data.trend, encoding, x, q.row(0));
  Vector d_mean = jacobian.transpose() * s.factor.beta;
  Vector d_variance = jacobian.transpose() * by_h;
  for (Eigen::Index p = 0; p < encoding.coordinates(); ++p) {
    const Eigen::Index i = encoding.input_of(p);
    const double chain = encoding.derivative(i, x[i]);
    if (chain == 0.0) continue;
    const Vector dk = (-correlator.weight[p] * chain) *
                      (k.slope.col(0).array() * (q(0, p) - s.data.x.col(p).array())).matrix();
    d_mean[i] += dk.dot(s.factor.alpha);
    d_variance[i] += dk.dot(by_k) + chain * by_u[p];
  }
  const double unit = s.predicted_amplitude();
  d_mean *= s.data.scale;
  d_variance *= unit;
  const Moments m =
      moments(s.data.response_scale, {s.data.shift + s.data.scale * mean, unit * variance});
  opt::PredictionGradient result{.function = m.y,
                                 .mean = m.mean_by_mean * d_mean + m.mean_by_variance * d_variance};
  const double sd = m.y.standard_deviation();
  result.standard_deviation = Vector::Zero(x.size());
  if (sd > 0.0)
    result.standard_deviation =
        (m.variance_by_mean * d_mean + m.variance_by_variance * d_variance) / (2.0 * sd);
  return result;
}

}  // namespace repose::surrogate

#include "likelihood.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "correlation.hpp"

namespace repose::surrogate {
namespace {

/// Below this fraction of (C^-1)_ii a point alone determines a regression coefficient.
constexpr double kUndetermined = 1e-12;

Vector mean_distances(const Dataset& data) {
  const Encoding& encoding = data.encoding;
  const Eigen::Index n = data.points();
  Vector sum = Vector::Zero(encoding.scales());
  Vector square(n);
  for (Eigen::Index s = 0; s < encoding.scales(); ++s)
    for (Eigen::Index j = 0; j + 1 < n; ++j) {
      auto part = square.tail(n - 1 - j);
      part.setZero();
      for (Eigen::Index p = 0; p < encoding.coordinates(); ++p)
        if (encoding.scale_of(p) == s)
          part.array() += (data.x.col(p).tail(n - 1 - j).array() - data.x(j, p)).square();
      sum[s] += part.cwiseSqrt().sum();
    }
  const auto size = static_cast<double>(n);
  return sum / std::max(1.0, 0.5 * size * (size - 1.0));
}

}  // namespace

NegativeLogPosterior::NegativeLogPosterior(const Dataset& data,
                                           const GaussianProcessOptions& options,
                                           Amplitude amplitude, PriorRate prior_rate)
    : data_(data),
      correlation_(options.kernel.correlation),
      noise_(options.noise),
      estimator_(options.estimator),
      prior_(options.prior),
      prior_rate_(prior_rate),
      amplitude_(amplitude),
      mean_distance_(mean_distances(data)) {}

Covariance NegativeLogPosterior::covariance(const Vector& p) const {
  const Eigen::Index s = data_.encoding.scales();
  Covariance c{.correlation = correlation_, .length_scales = p.head(s).array().exp()};
  if (has_alpha()) c.alpha = std::exp(p[s]);
  if (noise_ == Noise::none) return c;
  const double log_noise = estimates_noise() ? p[noise_parameter()] : 0.0;
  c.noise_ratio = std::exp(searches_amplitude() ? log_noise - p[amplitude_parameter()] : log_noise);
  return c;
}

double NegativeLogPosterior::operator()(const Vector& log_parameters, Vector* gradient) const {
  const bool wants_gradient = gradient != nullptr;
  const Eigen::Index n = data_.points();
  thread_local Evaluation e;
  e.c = covariance(log_parameters);
  e.lower.resize(n, n);
  const Eigen::Index slopes = wants_gradient ? n : 0;
  e.slope.resize(slopes, slopes);
  const Eigen::Index alpha_slopes = has_alpha() ? slopes : 0;
  e.alpha_slope.resize(alpha_slopes, alpha_slopes);
  fill_correlation(e.c.correlator(data_.encoding), data_.x, e.lower, e.slope, e.alpha_slope);
  e.lower.diagonal() += e.c.noise_ratio * data_.noise;
  std::optional<Cholesky> cholesky = factorise(e.lower, std::move(e.f.l));
  if (!cholesky) {
    if (wants_gradient) gradient->setZero(size());
    return std::numeric_limits<double>::infinity();
  }
  e.f = complete(data_, std::move(*cholesky));
  if (wants_gradient || estimator_ == Estimator::loo) {
    e.l_inverse.resize(n, n);
    dense().lower_inverse(e.f.l.data(), n, e.l_inverse.data());
  }
  if (estimator_ == Estimator::loo) e.left_out = leave_out(e.f, e.l_inverse);
  e.amplitude = amplitude(log_parameters, e.c, e.f, e.left_out);

  if (wants_gradient) gradient->setZero(size());
  double prior_by_noise = 0.0;
  double result = value(e);
  if (prior_ == Prior::jointly_robust) result += prior(e.c, gradient, prior_by_noise);
  if (wants_gradient) add_gradient(e, prior_by_noise, *gradient);
  return result;
}

double NegativeLogPosterior::within(const Covariance& c) const {
  return c.noise_ratio > 0.0 ? data_.within / c.noise_ratio : 0.0;
}

// ---- leaving out -------------------------------------------------------------------------------

NegativeLogPosterior::LeftOut NegativeLogPosterior::leave_out(const Factor& f,
                                                              const Matrix& l_inverse) const {
  const Vector full = l_inverse.colwise().squaredNorm();
  LeftOut out{.q = full - (l_inverse.transpose() * f.q1).rowwise().squaredNorm()};
  for (Eigen::Index i = 0; i < full.size(); ++i) {
    if (out.q[i] <= kUndetermined * full[i]) {
      out.q[i] = 0.0;
      continue;
    }
    out.points += 1.0;
    out.squares += f.alpha[i] * f.alpha[i] / out.q[i];
  }
  return out;
}

double NegativeLogPosterior::left_out_observations(const Covariance& c, const LeftOut& out) const {
  return effective_observations(data_, c.noise_ratio) - static_cast<double>(data_.points()) +
         out.points;
}

double NegativeLogPosterior::amplitude(const Vector& p, const Covariance& c, const Factor& f,
                                       const LeftOut& out) const {
  if (searches_amplitude()) return std::exp(p[amplitude_parameter()]);
  if (estimator_ == Estimator::loo)
    return (out.squares + within(c)) / left_out_observations(c, out);
  return best_amplitude(data_, f, c.noise_ratio, estimator_);
}

double NegativeLogPosterior::amplitude(const Vector& log_parameters, const Covariance& c,
                                       const Factor& factor) const {
  LeftOut out;
  if (estimator_ == Estimator::loo) out = leave_out(factor, lower_inverse(factor.l));
  return amplitude(log_parameters, c, factor, out);
}

/// loo: minus the sum over points of the log density of their observations given all others; those
/// of one point by their mean, N(e_i; sigma^2/Q_ii), and what they differ from it.
double NegativeLogPosterior::value(const Evaluation& e) const {
  const double ratio = e.c.noise_ratio;
  if (estimator_ != Estimator::loo)
    return negative_log_likelihood(data_, e.f, ratio, e.amplitude, estimator_);
  double twice =
      left_out_observations(e.c, e.left_out) * std::log(2.0 * std::numbers::pi * e.amplitude) +
      (e.left_out.squares + within(e.c)) / e.amplitude;
  for (const double q : e.left_out.q)
    if (q > 0.0) twice -= std::log(q);
  if (ratio > 0.0)
    twice += static_cast<double>(data_.observations() - data_.points()) * std::log(ratio) +
             data_.log_repeats;
  return 0.5 * twice;
}

// ---- gradient ----------------------------------------------------------------------------------

/// 2 W, lower triangle, with d(objective) = tr(W dC), the amplitude held:
/// ml C^-1 - a a^T/sigma^2; reml Q - a a^T/sigma^2, a = Q y; loo, from dQ = -Q dC Q,
/// Q diag(1/q + a^2/(q^2 sigma^2)) Q - Q h a^T - a (Q h)^T, h = a/(q sigma^2) [Sundararajan2001].
const Matrix& NegativeLogPosterior::twice_sensitivity(Evaluation& e) const {
  Matrix& m = e.inverse;
  m.resize(e.l_inverse.rows(), e.l_inverse.cols());
  dense().inverse_from(e.l_inverse.data(), m.rows(), m.data());
  const Vector& a = e.f.alpha;
  if (estimator_ != Estimator::ml && e.f.q1.cols() > 0) {
    const Matrix b = e.l_inverse.transpose() * e.f.q1;  // Q = C^-1 - B B^T
    m.selfadjointView<Eigen::Lower>().rankUpdate(b, -1.0);
  }
  if (estimator_ != Estimator::loo) {
    m.selfadjointView<Eigen::Lower>().rankUpdate(a, -1.0 / e.amplitude);
    return m;
  }
  const Vector& q = e.left_out.q;
  const Vector h = (q.array() > 0.0).select(a.array() / (q.array() * e.amplitude), 0.0);
  const Vector g =
      (q.array() > 0.0).select(q.array().inverse() + a.array() * h.array() / q.array(), 0.0);
  const Matrix full = m.selfadjointView<Eigen::Lower>();
  const Matrix root = full * g.cwiseSqrt().asDiagonal();
  m.setZero();
  m.selfadjointView<Eigen::Lower>().rankUpdate(root);
  m.selfadjointView<Eigen::Lower>().rankUpdate(full * h, a, -1.0);
  return m;
}

double NegativeLogPosterior::by_log_amplitude(const Evaluation& e) const {
  if (estimator_ == Estimator::loo)
    return 0.5 * (left_out_observations(e.c, e.left_out) -
                  (e.left_out.squares + within(e.c)) / e.amplitude);
  const double best = best_amplitude(data_, e.f, e.c.noise_ratio, estimator_);
  const double freedom = effective_observations(data_, e.c.noise_ratio) -
                         (estimator_ == Estimator::reml ? static_cast<double>(e.f.beta.size()) : 0);
  return 0.5 * freedom * (1.0 - best / e.amplitude);
}

/// One pass over the pairs i > j for all length scales.
void NegativeLogPosterior::add_gradient(Evaluation& e, double prior_by_noise,
                                        Vector& gradient) const {
  const Dense& loops = dense();
  const Eigen::Index n = data_.points();
  const Encoding& encoding = data_.encoding;
  const Matrix& w = twice_sensitivity(e);
  const Vector weight = encoding.weights(e.c.length_scales);
  Vector coefficient(n);
  Vector sums = Vector::Zero(encoding.coordinates());
  double by_alpha = 0.0;
  for (Eigen::Index j = 0; j + 1 < n; ++j) {
    const Eigen::Index below = n - 1 - j;
    const auto wj = w.col(j).tail(below);
    coefficient.head(below) = wj.cwiseProduct(e.slope.col(j).tail(below));
    if (has_alpha()) by_alpha += wj.dot(e.alpha_slope.col(j).tail(below));
    for (Eigen::Index p = 0; p < sums.size(); ++p)
      sums[p] += loops.weighted_square_sum(data_.x.data() + p * n + j + 1, below, data_.x(j, p),
                                           coefficient.data());
  }
  for (Eigen::Index p = 0; p < sums.size(); ++p)
    gradient[encoding.scale_of(p)] += weight[p] * sums[p];
  if (has_alpha()) gradient[encoding.scales()] += by_alpha;

  const double ratio = e.c.noise_ratio;
  double by_noise = prior_by_noise;
  if (ratio > 0.0)
    by_noise += 0.5 * (ratio * w.diagonal().dot(data_.noise) +
                       static_cast<double>(data_.observations() - n) - within(e.c) / e.amplitude);
  if (estimates_noise()) gradient[noise_parameter()] += by_noise;
  if (searches_amplitude()) gradient[amplitude_parameter()] += by_log_amplitude(e) - by_noise;
}

/// -log pi, log pi = a log t - b t, t = sum_k C_k / l_k + noise ratio (where it is estimated), a =
/// 0.2, in its own parameters: no Jacobian of the logarithms. With s length scales b = n^(-1/s) (a
/// + s) [Gu2019], so that t is n^(1/s) on the mean of pi; PriorRate::by_scale b/s: each C_k/l_k is.
double NegativeLogPosterior::prior(const Covariance& c, Vector* gradient, double& by_noise) const {
  const Eigen::Index s = data_.encoding.scales();
  const auto scales = static_cast<double>(s);
  constexpr double kA = 0.2;
  const double shares = prior_rate_ == PriorRate::by_scale ? scales : 1.0;
  const double b =
      std::pow(static_cast<double>(data_.points()), -1.0 / scales) * (kA + scales) / shares;
  const Vector part = mean_distance_.array() / c.length_scales.array();
  const double noise = estimates_noise() ? c.noise_ratio : 0.0;
  const double t = part.sum() + noise;
  const double slope = kA / t - b;
  if (gradient != nullptr) gradient->head(s) += slope * part;
  by_noise = -slope * noise;
  return b * t - kA * std::log(t);
}

}  // namespace repose::surrogate

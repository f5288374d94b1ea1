#include "repose/surrogate/gaussian_process.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "correlation.hpp"
#include "likelihood.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using Clock = std::chrono::steady_clock;

// Bounds of the search, in units of the declared range and of the process variance.
constexpr double kShortest = 0.02;
constexpr double kLongest = 1e5;
constexpr double kLeastNoise = 1e-14;
constexpr double kMostNoise = 1e4;
// Starts: the best of a grid, length scales as fractions of sqrt(d) ranges; then jittered copies of
// it.
constexpr double kGridScales[] = {0.02, 0.0632, 0.2, 0.632, 2.0};
constexpr double kGridNoise[] = {1e-4, 1e-2, 0.3};
constexpr double kScaleJitter = 0.35;
constexpr double kNoiseJitter = 1.5;
/// A parameter this close to a bound, in logarithm, sits on it.
constexpr double kAtBound = 1e-3;
constexpr double kInertBelow = 0.1;  // [Gu2019]
constexpr Eigen::Index kPredictionBlock = 128;

opt::Bounds search_bounds(Eigen::Index dimension, Noise noise) {
  const Eigen::Index size = dimension + (noise == Noise::estimated ? 1 : 0);
  opt::Bounds bounds{Vector::Constant(size, std::log(kShortest)),
                     Vector::Constant(size, std::log(kLongest))};
  if (noise == Noise::estimated) {
    bounds.lower[dimension] = std::log(kLeastNoise);
    bounds.upper[dimension] = std::log(kMostNoise);
  }
  return bounds;
}

Vector best_of_grid(const NegativeLogPosterior& objective, Eigen::Index dimension, Noise noise,
                    const opt::Bounds& bounds, int& evaluations) {
  Vector best;
  double best_value = std::numeric_limits<double>::infinity();
  for (const double scale : kGridScales)
    for (const double ratio : kGridNoise) {
      Vector p = Vector::Constant(objective.size(),
                                  std::log(scale * std::sqrt(static_cast<double>(dimension))));
      if (noise == Noise::estimated) p[dimension] = std::log(ratio);
      p = opt::project(p, bounds);
      const double value = objective(p, nullptr);
      ++evaluations;
      if (value < best_value || best.size() == 0) {
        best = p;
        best_value = value;
      }
      if (noise == Noise::none) break;
    }
  return best;
}

Matrix jittered_starts(const Vector& best, Eigen::Index dimension, int starts, std::uint64_t seed,
                       const opt::Bounds& bounds) {
  Matrix rows(starts, best.size());
  rows.row(0) = best;
  for (Eigen::Index s = 1; s < starts; ++s) {
    RandomStream random(seed, static_cast<std::uint64_t>(s));
    Vector p = best;
    for (Eigen::Index k = 0; k < p.size(); ++k)
      p[k] += (k < dimension ? kScaleJitter : kNoiseJitter) * random.normal();
    rows.row(s) = opt::project(p, bounds);
  }
  return rows;
}

ParameterState state_of(double p, double lower, double upper) {
  if (p <= lower + kAtBound) return ParameterState::at_lower_bound;
  if (p >= upper - kAtBound) return ParameterState::at_upper_bound;
  return ParameterState::converged;
}

std::vector<FittedParameter> describe(const Vector& p, const opt::Bounds& bounds,
                                      const Dataset& data, const Vector& mean_distance) {
  const Eigen::Index d = data.dimension();
  const Vector inverse = mean_distance.array() / p.head(d).array().exp();
  const double mean_inverse = inverse.sum() / static_cast<double>(d);
  std::vector<FittedParameter> parameters;
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    const bool is_scale = k < d;
    const double range = is_scale ? data.declared.upper[k] - data.declared.lower[k] : 1.0;
    FittedParameter f{.name = is_scale ? fmt::format("length_scale_{}", k + 1) : "noise_ratio",
                      .value = range * std::exp(p[k]),
                      .lower = range * std::exp(bounds.lower[k]),
                      .upper = range * std::exp(bounds.upper[k]),
                      .state = state_of(p[k], bounds.lower[k], bounds.upper[k])};
    if (is_scale) {
      f.relevance = mean_inverse > 0.0 ? inverse[k] / mean_inverse : 0.0;
      if (f.relevance < kInertBelow) f.state = ParameterState::inert;
    }
    parameters.push_back(std::move(f));
  }
  return parameters;
}

void check_points(const Dataset& data, Basis basis, Eigen::Index least) {
  if (data.points() < least)
    throw InputError(
        fmt::format("{} different points for {} regression coefficients; at least {} are needed",
                    data.points(), basis_size(basis), least));
}

}  // namespace

const char* to_string(Kernel kernel) {
  return kernel == Kernel::matern52 ? "ard-matern52" : "ard-squared-exponential";
}

Kernel kernel_named(std::string_view name) {
  for (const Kernel kernel : {Kernel::squared_exponential, Kernel::matern52})
    if (name == to_string(kernel)) return kernel;
  throw InputError(fmt::format("kernel '{}' is not known; choose {} or {}", name,
                               to_string(Kernel::squared_exponential),
                               to_string(Kernel::matern52)));
}

const char* to_string(ParameterState state) {
  constexpr const char* kNames[] = {"converged", "at_lower_bound", "at_upper_bound", "inert"};
  return kNames[static_cast<int>(state)];
}

GaussianProcess::GaussianProcess(std::shared_ptr<const State> state) : state_(std::move(state)) {}

GaussianProcess GaussianProcess::fit(const Matrix& x, const Vector& y, const opt::Bounds& declared,
                                     const GaussianProcessOptions& options) {
  if (options.starts < 1)
    throw InputError(fmt::format("a fit from {} starts; there must be at least 1", options.starts));
  const Clock::time_point begin = Clock::now();
  State s{.data = make_dataset(x, y, declared, options.basis, options.noise),
          .noise = options.noise,
          .basis = options.basis,
          .estimator = options.estimator};
  check_points(s.data, options.basis, basis_size(options.basis) + 1);

  const NegativeLogPosterior objective(s.data, options);
  const Eigen::Index d = s.data.dimension();
  const opt::Bounds bounds = search_bounds(d, options.noise);
  Vector p;
  if (s.data.within == 0.0 && s.data.y.isZero(1e-12)) {  // nothing but a constant
    p = opt::project(Vector::Zero(objective.size()), bounds);
    if (options.noise == Noise::estimated) p[d] = bounds.lower[d];
    s.report.message = "the response is constant; nothing to fit";
  } else {
    int grid_evaluations = 0;
    const Vector best = best_of_grid(objective, d, options.noise, bounds, grid_evaluations);
    const opt::Minimum minimum = opt::multi_start(
        [&objective](const Vector& at, Vector* gradient) { return objective(at, gradient); },
        jittered_starts(best, d, options.starts, options.seed, bounds), bounds, options.minimizer,
        options.threads);
    p = minimum.x;
    s.report.termination = minimum.termination;
    s.report.message = minimum.message;
    s.report.evaluations = minimum.evaluations + grid_evaluations;
  }
  s.covariance = objective.covariance(p);
  s.factor = make_factor(s.data, s.covariance, s.basis);
  s.amplitude = best_amplitude(s.data, s.factor, s.covariance.noise_ratio, s.estimator);
  if (s.report.evaluations == 0) s.amplitude = 0.0;
  s.report.parameters = describe(p, bounds, s.data, objective.mean_distance());
  s.report.jitter = s.factor.jitter;
  s.report.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return ModelAccess::make(std::move(s));
}

GaussianProcess GaussianProcess::with_parameters(const Matrix& x, const Vector& y,
                                                 const opt::Bounds& declared,
                                                 const Hyperparameters& parameters,
                                                 const GaussianProcessOptions& options) {
  const Vector& scales = parameters.length_scales;
  if (scales.size() != x.cols() || !(scales.array() > 0.0).all() || !scales.allFinite())
    throw InputError(fmt::format("{} length scales for {} inputs; each must be positive and finite",
                                 scales.size(), x.cols()));
  if (!(parameters.process_variance > 0.0) || !std::isfinite(parameters.process_variance) ||
      !(parameters.noise_variance >= 0.0) || !std::isfinite(parameters.noise_variance))
    throw InputError(
        fmt::format("process variance {} and noise variance {}; the first must be positive, the "
                    "second not negative",
                    parameters.process_variance, parameters.noise_variance));
  const Noise noise = parameters.noise_variance > 0.0 ? Noise::estimated : Noise::none;
  State s{.data = make_dataset(x, y, declared, options.basis, noise),
          .noise = noise,
          .basis = options.basis,
          .estimator = options.estimator};
  check_points(s.data, options.basis, std::max<Eigen::Index>(1, basis_size(options.basis)));
  s.covariance = {options.kernel, scales.array() / (declared.upper - declared.lower).array(),
                  parameters.noise_variance / parameters.process_variance};
  s.amplitude = parameters.process_variance / (s.data.scale * s.data.scale);
  s.factor = make_factor(s.data, s.covariance, s.basis);
  s.report.message = "hyper-parameters were given";
  s.report.jitter = s.factor.jitter;
  return ModelAccess::make(std::move(s));
}

std::vector<Gaussian> GaussianProcess::predict_rows(const Matrix& x) const {
  const State& s = *state_;
  if (x.cols() != dimension())
    throw InputError(fmt::format("a prediction at points of {} inputs; the model has {}", x.cols(),
                                 dimension()));
  const auto l = s.factor.l.triangularView<Eigen::Lower>();
  const auto ut = s.factor.u.transpose().triangularView<Eigen::Lower>();
  std::vector<Gaussian> result;
  result.reserve(static_cast<std::size_t>(x.rows()));
  for (Eigen::Index begin = 0; begin < x.rows(); begin += kPredictionBlock) {
    const Matrix q =
        s.data.to_unit(x.middleRows(begin, std::min(kPredictionBlock, x.rows() - begin)));
    Matrix v = cross_correlation(s.covariance.kernel, s.data.x, q, s.covariance.length_scales);
    const Matrix h = basis_matrix(s.basis, q);
    const Vector mean = h * s.factor.beta + v.transpose() * s.factor.alpha;
    l.solveInPlace(v);
    Vector variance = Vector::Ones(q.rows()) - v.colwise().squaredNorm().transpose();
    if (h.cols() > 0) {  // the coefficients' own uncertainty
      const Matrix trend = ut.solve(h.transpose()) - s.factor.q1.transpose() * v;
      variance += trend.colwise().squaredNorm().transpose();
    }
    for (Eigen::Index i = 0; i < q.rows(); ++i)
      result.push_back({s.data.shift + s.data.scale * mean[i],
                        s.data.scale * s.data.scale * s.amplitude * std::max(0.0, variance[i])});
  }
  return result;
}

Gaussian GaussianProcess::predict(const Vector& x) const {
  return predict_rows(x.transpose())[0];
}

GaussianProcess GaussianProcess::condition_on(const Vector& x, double y) const {
  const State& old = *state_;
  if (x.size() != dimension() || !x.allFinite() || !std::isfinite(y))
    throw InputError(
        fmt::format("conditioning on response {} at a point of {} coordinates; both must be "
                    "finite, with {} coordinates",
                    y, x.size(), dimension()));
  const Vector unit = old.data.to_unit(x.transpose()).row(0);
  State s = old;
  s.data = with_observation(old.data, unit, (y - old.data.shift) / old.data.scale, old.noise);
  const Eigen::Index n = old.data.points();
  if (s.data.points() == n + 1) {  // one more row of the Cholesky factor
    Vector k = cross_correlation(old.covariance.kernel, old.data.x, unit.transpose(),
                                 old.covariance.length_scales);
    old.factor.l.triangularView<Eigen::Lower>().solveInPlace(k);
    const double pivot = 1.0 + old.covariance.noise_ratio + old.factor.jitter - k.squaredNorm();
    if (pivot > 1e-12) {
      Cholesky grown{Matrix::Zero(n + 1, n + 1), old.factor.jitter};
      grown.l.topLeftCorner(n, n) = old.factor.l;
      grown.l.row(n).head(n) = k;
      grown.l(n, n) = std::sqrt(pivot);
      s.factor = complete(s.data, s.basis, std::move(grown));
      return ModelAccess::make(std::move(s));
    }
  }
  s.factor = make_factor(s.data, s.covariance, s.basis);
  s.report.jitter = s.factor.jitter;
  return ModelAccess::make(std::move(s));
}

Eigen::Index GaussianProcess::dimension() const {
  return state_->data.dimension();
}
Eigen::Index GaussianProcess::rows() const {
  return state_->data.observations();
}
Kernel GaussianProcess::kernel() const {
  return state_->covariance.kernel;
}
Noise GaussianProcess::noise() const {
  return state_->noise;
}
Basis GaussianProcess::basis() const {
  return state_->basis;
}
Estimator GaussianProcess::estimator() const {
  return state_->estimator;
}
const FitReport& GaussianProcess::report() const {
  return state_->report;
}
const opt::Bounds& GaussianProcess::declared_bounds() const {
  return state_->data.declared;
}

Hyperparameters GaussianProcess::hyperparameters() const {
  const Dataset& data = state_->data;
  const double variance = state_->amplitude * data.scale * data.scale;
  return {state_->covariance.length_scales.cwiseProduct(data.declared.upper - data.declared.lower),
          variance, variance * state_->covariance.noise_ratio};
}

double GaussianProcess::noise_variance() const {
  return hyperparameters().noise_variance;
}

Vector GaussianProcess::coefficients() const {
  Vector beta = state_->data.scale * state_->factor.beta;
  if (state_->basis != Basis::none) beta[0] += state_->data.shift;
  return beta;
}

double GaussianProcess::negative_log_likelihood() const {
  const Dataset& data = state_->data;
  const Eigen::Index trend = state_->estimator == Estimator::reml ? state_->factor.beta.size() : 0;
  return surrogate::negative_log_likelihood(data, state_->factor, state_->covariance.noise_ratio,
                                            state_->amplitude, state_->estimator) +
         static_cast<double>(data.observations() - trend) * std::log(data.scale);
}

}  // namespace repose::surrogate

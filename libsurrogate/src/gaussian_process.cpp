#include "repose/surrogate/gaussian_process.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <chrono>
#include <cmath>
#include <optional>

#include "dense.hpp"
#include "repose/base/error.hpp"
#include "search.hpp"
#include "state.hpp"

namespace repose::surrogate {
namespace {

using Clock = std::chrono::steady_clock;

void check_points(const Dataset& data, Eigen::Index least) {
  if (data.points() < least)
    throw InputError(
        fmt::format("{} different points for {} regression coefficients; at least {} are needed",
                    data.points(), data.h.cols(), least));
}

/// Whether the regression functions alone reproduce the response, to rounding.
bool trend_explains(const Dataset& data) {
  constexpr double kRounding = 1e-12;
  if (data.within > 0.0) return false;
  Vector residual = data.y;
  if (data.h.cols() > 0)
    residual -= data.h * Eigen::HouseholderQR<Matrix>(data.h).solve(data.y).eval();
  return residual.cwiseAbs().maxCoeff() <= kRounding * std::max(1.0, data.y.cwiseAbs().maxCoeff());
}

void check(const Hyperparameters& p, Eigen::Index scales, Noise noise) {
  if (p.length_scales.size() != scales || !(p.length_scales.array() > 0.0).all() ||
      !p.length_scales.allFinite())
    throw InputError(
        fmt::format("{} length scales where the kernel has {}; each must be positive and finite",
                    p.length_scales.size(), scales));
  if (!(p.process_variance > 0.0) || !std::isfinite(p.process_variance) ||
      !(p.noise_variance >= 0.0) || !std::isfinite(p.noise_variance))
    throw InputError(
        fmt::format("process variance {} and noise variance {}; the first must be positive, the "
                    "second not negative",
                    p.process_variance, p.noise_variance));
  if (!(p.alpha > 0.0) || !std::isfinite(p.alpha))
    throw InputError(fmt::format("alpha is {}; it must be positive and finite", p.alpha));
  if (noise == Noise::none && p.noise_variance > 0.0)
    throw InputError(
        fmt::format("a noise variance of {} for a model without noise", p.noise_variance));
}

using State = ModelAccess::State;

/// The model at these log parameters.
void adopt(State& s, const NegativeLogPosterior& objective, const Vector& p) {
  s.covariance = objective.covariance(p);
  s.factor = make_factor(s.data, s.covariance);
  s.amplitude = objective.amplitude(p, s.covariance, s.factor);
}

double left_out_log_density(const State& s) {
  return ModelAccess::make(s).leave_one_out().log_density;
}

/// The same with the length scales of inert inputs held.
SearchSpace without_inert(const SearchSpace& space, const Vector& p,
                          const NegativeLogPosterior& objective, const Dataset& data) {
  SearchSpace held = space;
  const std::vector<FittedParameter> found = describe(p, space, objective, data);
  for (Eigen::Index k = 0; k < p.size(); ++k)
    if (found[static_cast<std::size_t>(k)].state == ParameterState::inert)
      held.bounds.lower[k] = held.bounds.upper[k] = p[k];
  return held;
}

/// The jointly robust prior first finds the inputs without effect; once these are out its rate
/// flattens functions that vary much in all others, and a weaker one is tried over them. The model
/// that better predicts what is left out is kept. (As the relaxed lasso does [Meinshausen2007].)
void find_parameters(State& s, const NegativeLogPosterior& objective, const SearchSpace& space,
                     const GaussianProcessOptions& options) {
  opt::Minimum best = search(objective, space, s.data, options);
  adopt(s, objective, best.x);
  std::optional<NegativeLogPosterior> weaker;
  const NegativeLogPosterior* chosen = &objective;
  if (options.prior == Prior::jointly_robust && s.data.encoding.scales() > 1) {
    weaker.emplace(s.data, options, amplitude_of(options), PriorRate::by_scale);
    opt::Minimum other =
        search(*weaker, without_inert(space, best.x, objective, s.data), s.data, options);
    other.evaluations += best.evaluations;
    best.evaluations = other.evaluations;
    if (std::isfinite(other.value)) {
      State candidate = s;
      adopt(candidate, *weaker, other.x);
      if (left_out_log_density(candidate) > left_out_log_density(s)) {
        s = std::move(candidate);
        best = std::move(other);
        chosen = &*weaker;
      }
    }
  }
  s.report.termination = best.termination;
  s.report.message = best.message;
  s.report.evaluations = best.evaluations;
  s.report.parameters = describe(best.x, space, *chosen, s.data);
  if (options.parameter_uncertainty == ParameterUncertainty::ignored ||
      s.estimator == Estimator::loo)
    return;
  s.parameters = approximate_posterior(
      *chosen, best.x, space.bounds,
      {.observations = effective_observations(s.data, s.covariance.noise_ratio),
       .coefficients = static_cast<double>(s.factor.beta.size()),
       .estimator = s.estimator});
  s.find_sensitivity();
}

}  // namespace

GaussianProcess::GaussianProcess(std::shared_ptr<const State> state) : state_(std::move(state)) {}

GaussianProcess GaussianProcess::fit(const Matrix& x, const Vector& y,
                                     const std::vector<Input>& inputs,
                                     const GaussianProcessOptions& options) {
  if (options.starts < 1)
    throw InputError(fmt::format("a fit from {} starts; there must be at least 1", options.starts));
  const Clock::time_point begin = Clock::now();
  State s{.data = make_dataset(x, y, inputs, options),
          .noise = options.noise,
          .estimator = options.estimator};
  check_points(s.data, s.data.h.cols() + 1);
  check_independent(s.data.h, trend_names(s.data.trend, s.data.encoding));

  const NegativeLogPosterior objective(s.data, options, amplitude_of(options));
  const SearchSpace space = make_search_space(objective, s.data, options);
  if (!objective.searches_amplitude() && trend_explains(s.data)) {
    const Vector p = default_parameters(objective, space);
    adopt(s, objective, p);
    s.amplitude = 0.0;
    s.report.parameters = describe(p, space, objective, s.data);
    s.report.message = options.basis == Basis::constant && options.functions.names.empty()
                           ? "the response is constant; nothing to fit"
                           : "the trend explains the response; nothing to fit";
  } else {
    find_parameters(s, objective, space, options);
  }
  s.report.jitter = s.factor.jitter;
  s.report.instruction_set = dense().name;
  s.report.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return ModelAccess::make(std::move(s));
}

GaussianProcess GaussianProcess::fit(const Matrix& x, const Vector& y, const opt::Bounds& declared,
                                     const GaussianProcessOptions& options) {
  return fit(x, y, linear_inputs(declared), options);
}

GaussianProcess GaussianProcess::with_parameters(const Matrix& x, const Vector& y,
                                                 const std::vector<Input>& inputs,
                                                 const Hyperparameters& parameters,
                                                 const GaussianProcessOptions& options) {
  GaussianProcessOptions given = options;
  const bool variances_given = options.noise == Noise::known || options.noise == Noise::by_point;
  if (!variances_given)
    given.noise = parameters.noise_variance > 0.0 ? Noise::estimated : Noise::none;
  State s{.data = make_dataset(x, y, inputs, given),
          .noise = given.noise,
          .estimator = options.estimator};
  const Encoding& encoding = s.data.encoding;
  check(parameters, encoding.scales(), given.noise);
  check_points(s.data, std::max<Eigen::Index>(1, s.data.h.cols()));
  check_independent(s.data.h, trend_names(s.data.trend, encoding));
  s.amplitude = parameters.process_variance / (s.data.scale * s.data.scale);
  s.covariance = {.correlation = options.kernel.correlation,
                  .length_scales = parameters.length_scales.cwiseQuotient(encoding.scale_units()),
                  .noise_ratio = variances_given
                                     ? 1.0 / s.amplitude
                                     : parameters.noise_variance / parameters.process_variance,
                  .alpha = parameters.alpha};
  s.factor = make_factor(s.data, s.covariance);
  s.report.message = "hyper-parameters were given";
  s.report.jitter = s.factor.jitter;
  return ModelAccess::make(std::move(s));
}

GaussianProcess GaussianProcess::with_parameters(const Matrix& x, const Vector& y,
                                                 const opt::Bounds& declared,
                                                 const Hyperparameters& parameters,
                                                 const GaussianProcessOptions& options) {
  return with_parameters(x, y, linear_inputs(declared), parameters, options);
}

GaussianProcess GaussianProcess::condition_on(const Vector& x, double y) const {
  const State& old = *state_;
  if (x.size() != dimension() || !x.allFinite() || !std::isfinite(y))
    throw InputError(
        fmt::format("conditioning on response {} at a point of {} coordinates; both must be "
                    "finite, with {} coordinates",
                    y, x.size(), dimension()));
  // told what it predicts anyway, which at a known point may be off by the condition of the matrix
  if (old.noise == Noise::none && predict(x).mean == y)
    for (const auto& known : old.data.natural.rowwise())
      if (known.transpose() == x) return *this;
  State s = old;
  s.data = with_observation(old.data, x, y, old.noise);
  const Eigen::Index n = old.data.points();
  if (s.data.points() == n + 1) {  // one more row of the Cholesky factor
    Vector k = cross_correlation(old.covariance.correlator(old.data.encoding), old.data.x,
                                 s.data.x.bottomRows(1));
    old.factor.l.triangularView<Eigen::Lower>().solveInPlace(k);
    const double pivot =
        1.0 + old.covariance.noise_ratio * s.data.noise[n] + old.factor.jitter - k.squaredNorm();
    if (pivot > 1e-12) {
      Cholesky grown{Matrix::Zero(n + 1, n + 1), old.factor.jitter};
      grown.l.topLeftCorner(n, n) = old.factor.l;
      grown.l.row(n).head(n) = k;
      grown.l(n, n) = std::sqrt(pivot);
      s.factor = complete(s.data, std::move(grown));
      s.find_sensitivity();
      return ModelAccess::make(std::move(s));
    }
  }
  s.factor = make_factor(s.data, s.covariance);
  s.find_sensitivity();
  s.report.jitter = s.factor.jitter;
  return ModelAccess::make(std::move(s));
}

// ---- what it is --------------------------------------------------------------------------------

Eigen::Index GaussianProcess::dimension() const {
  return state_->data.dimension();
}
const Matrix& GaussianProcess::points() const {
  return state_->data.natural;
}

Eigen::Index GaussianProcess::rows() const {
  return state_->data.observations();
}
Kernel GaussianProcess::kernel() const {
  return {state_->covariance.correlation, state_->data.encoding.length_scales()};
}
Noise GaussianProcess::noise() const {
  return state_->noise;
}
Basis GaussianProcess::basis() const {
  return state_->data.trend.basis;
}
const std::vector<std::string>& GaussianProcess::function_names() const {
  return state_->data.trend.functions.names;
}
ResponseScale GaussianProcess::response_scale() const {
  return state_->data.response_scale;
}
Estimator GaussianProcess::estimator() const {
  return state_->estimator;
}
const FitReport& GaussianProcess::report() const {
  return state_->report;
}
const std::vector<Input>& GaussianProcess::inputs() const {
  return state_->data.encoding.inputs();
}

opt::Bounds GaussianProcess::declared_bounds() const {
  opt::Bounds bounds{Vector(dimension()), Vector(dimension())};
  Eigen::Index k = 0;
  for (const Input& input : inputs()) {
    bounds.lower[k] = input.is_categorical() ? 0.0 : input.lower;
    bounds.upper[k] =
        input.is_categorical() ? static_cast<double>(input.levels.size() - 1) : input.upper;
    ++k;
  }
  return bounds;
}

Hyperparameters GaussianProcess::hyperparameters() const {
  const Dataset& data = state_->data;
  const double variance = state_->amplitude * data.scale * data.scale;
  return {state_->covariance.length_scales.cwiseProduct(data.encoding.scale_units()), variance,
          noise_variance(), state_->covariance.alpha};
}

double GaussianProcess::noise_variance() const {
  const Dataset& data = state_->data;
  return state_->amplitude * data.scale * data.scale * state_->covariance.noise_ratio *
         data.mean_noise();
}

Vector GaussianProcess::coefficients() const {
  Vector beta = state_->data.scale * state_->factor.beta;
  if (state_->data.trend.has_constant()) beta[0] += state_->data.shift;
  return beta;
}

double GaussianProcess::negative_log_likelihood() const {
  const State& s = *state_;
  const double ratio = s.covariance.noise_ratio;
  const Eigen::Index trend = s.estimator == Estimator::reml ? s.factor.beta.size() : 0;
  return surrogate::negative_log_likelihood(s.data, s.factor, ratio, s.amplitude, s.estimator) +
         (effective_observations(s.data, ratio) - static_cast<double>(trend)) *
             std::log(s.data.scale) -
         s.data.log_jacobian;
}

}  // namespace repose::surrogate

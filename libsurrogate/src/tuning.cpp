#include "repose/surrogate/tuning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "encoding.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/surrogate/fitter.hpp"
#include "response.hpp"

namespace repose::surrogate {
namespace {

constexpr Basis kBases[] = {Basis::constant, Basis::none, Basis::linear, Basis::quadratic};
constexpr double kE = 2.718281828459045;

/// Places of the tuned parameters in a point.
enum Place : Eigen::Index { kKernel, kBasis, kSigma, kScale, kStandardise };

/// The values whose distances count: logarithms on a log scale.
Vector modelled_column(const Matrix& x, const Input& input, Eigen::Index k) {
  return input.scale == Scale::log ? x.col(k).array().log().matrix() : Vector(x.col(k));
}

double deviation(const Vector& values) {
  const double mean = values.mean();
  return std::sqrt((values.array() - mean).square().sum() /
                   static_cast<double>(std::max<Eigen::Index>(values.size() - 1, 1)));
}

/// Folds of about equal numbers of groups, by chance.
std::vector<Eigen::Index> folds_of(Eigen::Index rows, const TuningOptions& tuning) {
  std::vector<Eigen::Index> group = tuning.groups;
  if (group.empty())
    for (Eigen::Index i = 0; i < rows; ++i) group.push_back(i);
  if (static_cast<Eigen::Index>(group.size()) != rows)
    throw InputError(fmt::format("{} groups for {} rows; each row has one", group.size(), rows));
  std::vector<Eigen::Index> names = group;
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  if (tuning.folds < 2 || static_cast<std::size_t>(tuning.folds) > names.size())
    throw InputError(
        fmt::format("{} folds of {} {}; there must be at least 2 and no more than that",
                    tuning.folds, names.size(), tuning.groups.empty() ? "rows" : "groups"));
  RandomStream(tuning.seed, 1).shuffle(names);
  std::vector<Eigen::Index> folds;
  for (const Eigen::Index g : group)
    folds.push_back((std::find(names.begin(), names.end(), g) - names.begin()) % tuning.folds);
  return folds;
}

/// The data and what every trial shares.
class Tuner {
 public:
  Tuner(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
        const GaussianProcessOptions& options, const TuningOptions& tuning)
      : x_(x), y_(y), inputs_(inputs), options_(options), tuning_(tuning) {
    if (y.size() != x.rows() || static_cast<Eigen::Index>(inputs.size()) != x.cols())
      throw InputError(
          fmt::format("{} x {} inputs, {} values and {} inputs described; they must "
                      "agree",
                      x.rows(), x.cols(), y.size(), inputs.size()));
    Encoding(inputs, LengthScales::one_per_input).encode(x);  // throws, naming row and input
    if (!y.allFinite()) throw InputError("a response is not finite");
    folds_ = folds_of(x.rows(), tuning);
    options_.noise = Noise::estimated;
    options_.estimator = Estimator::ml;
    options_.prior = Prior::none;
    options_.parameter_uncertainty = ParameterUncertainty::ignored;
    for (Eigen::Index k = 0; k < x.cols(); ++k) {
      const Input& input = inputs[static_cast<std::size_t>(k)];
      const Vector u = input.is_categorical() ? Vector(x.col(k)) : modelled_column(x, input, k);
      range_ = std::max(range_, u.maxCoeff() - u.minCoeff());
    }
    if (!(range_ > 0.0)) throw InputError("every input is constant; nothing can be learnt");
  }

  opt::OptimizationProblem problem() const {
    std::vector<std::string> kernels, bases;
    for (const Kernel kernel : all_kernels()) kernels.emplace_back(to_string(kernel));
    for (const Basis basis : kBases) bases.emplace_back(to_string(basis));
    const double sd = deviation(modelled_response());
    return {
        .parameters = ParameterSpace(
            {{.name = "kernel", .kind = ParameterKind::categorical, .categories = kernels},
             {.name = "basis", .kind = ParameterKind::categorical, .categories = bases},
             {.name = "sigma",
              .lower = 1e-4,
              .upper = std::max(1e-3, 10.0 * sd),
              .scale = Scale::log},
             {.name = "kernel_scale", .lower = 1e-3 * range_, .upper = range_, .scale = Scale::log},
             {.name = "standardise",
              .kind = ParameterKind::categorical,
              .categories = {"false", "true"}}}),
        .responses = {"log_mean_square_error"}};
  }

  TuningTrial trial_at(const Vector& point) const {
    return {.kernel = all_kernels()[static_cast<std::size_t>(point[kKernel])],
            .basis = kBases[static_cast<std::size_t>(point[kBasis])],
            .noise_standard_deviation = point[kSigma],
            .kernel_scale = point[kScale],
            .standardised = point[kStandardise] == 1.0};
  }

  /// Fills in rmse or failure.
  void cross_validate(TuningTrial& trial) const {
    const auto folds = static_cast<std::size_t>(tuning_.folds);
    std::vector<double> square(folds, 0.0);
    std::vector<std::string> failure(folds);
    parallel_for(folds, tuning_.threads, [&](std::size_t f) {
      std::vector<Eigen::Index> in, out;
      for (Eigen::Index i = 0; i < y_.size(); ++i)
        (folds_[static_cast<std::size_t>(i)] == static_cast<Eigen::Index>(f) ? out : in)
            .push_back(i);
      try {
        const auto model = fitted(trial, x_(in, Eigen::all), y_(in), 1);
        const auto predicted = model.predict_rows(x_(out, Eigen::all));
        for (std::size_t i = 0; i < out.size(); ++i)
          square[f] += std::pow(predicted[i].mean - y_[out[i]], 2);
      } catch (const Error& error) {
        failure[f] = error.what();
      }
    });
    for (const std::string& f : failure)
      if (!f.empty() && trial.failure.empty()) trial.failure = f;
    double sum = 0.0;
    for (const double s : square) sum += s;
    trial.rmse = std::sqrt(sum / static_cast<double>(y_.size()));
    if (!std::isfinite(trial.rmse)) trial.failure = "a prediction is not finite";
  }

  /// A failed trial counts as if it were off by three deviations of y; a perfect one is not minus
  /// infinity.
  double loss(const TuningTrial& trial) const {
    const double sd = std::max(deviation(y_), 1e-150);
    const double rmse = trial.failure.empty() ? trial.rmse : 3.0 * sd;
    return 2.0 * std::log(std::max(rmse, 1e-12 * sd));
  }

  /// The same model over the inputs as they were declared: a shared length scale becomes one for
  /// each input that is not free.
  GaussianProcess final_model(const TuningTrial& trial) const {
    GaussianProcessOptions o = options_of(trial);
    if (trial.kernel.length_scales == LengthScales::shared) {
      o.kernel.length_scales = LengthScales::one_per_input;
      o.bounds.clear();
      o.bounds.push_back(noise_bounds(trial));
      const Encoding encoding(inputs_, LengthScales::one_per_input);
      std::vector<bool> done(static_cast<std::size_t>(encoding.scales()), false);
      for (Eigen::Index c = 0; c < encoding.coordinates(); ++c) {
        const Eigen::Index s = encoding.scale_of(c);
        if (done[static_cast<std::size_t>(s)]) continue;
        done[static_cast<std::size_t>(s)] = true;
        const double value =
            trial.kernel_scale *
            (inputs_[static_cast<std::size_t>(encoding.input_of(c))].is_categorical()
                 ? encoding.scale_units()[s]
                 : unit_of(trial, x_, encoding.input_of(c)));
        o.bounds.push_back({encoding.scale_names()[static_cast<std::size_t>(s)], value, value});
      }
    }
    return GaussianProcess::fit(x_, y_, inputs_, o);
  }

 private:
  Vector modelled_response() const {
    Vector y = y_;
    for (double& value : y) value = modelled(options_.response_scale, value);
    if (!y.allFinite())
      throw InputError(fmt::format("a response is not allowed on a {} scale",
                                   to_string(options_.response_scale)));
    return y;
  }

  static ParameterBounds noise_bounds(const TuningTrial& trial) {
    const double variance = trial.noise_standard_deviation * trial.noise_standard_deviation;
    return {"noise_variance", variance, variance};
  }

  GaussianProcessOptions options_of(const TuningTrial& trial) const {
    GaussianProcessOptions o = options_;
    o.kernel = trial.kernel;
    o.basis = trial.basis;
    o.bounds = {noise_bounds(trial)};
    if (trial.kernel.length_scales == LengthScales::shared)
      o.bounds.push_back({"length_scale", trial.kernel_scale, trial.kernel_scale});
    return o;
  }

  /// Of an input that is a number: what counts as a distance of 1.
  double unit_of(const TuningTrial& trial, const Matrix& x, Eigen::Index k) const {
    if (!trial.standardised) return 1.0;
    const double sd = deviation(modelled_column(x, inputs_[static_cast<std::size_t>(k)], k));
    return sd > 0.0 ? sd : 1.0;
  }

  GaussianProcess fitted(const TuningTrial& trial, const Matrix& x, const Vector& y,
                         int starts) const {
    std::vector<Input> scaled = inputs_;
    const bool shared = trial.kernel.length_scales == LengthScales::shared;
    for (std::size_t k = 0; k < scaled.size() && shared; ++k) {
      if (scaled[k].is_categorical()) continue;
      const double unit = unit_of(trial, x, static_cast<Eigen::Index>(k));
      scaled[k].lower = scaled[k].scale == Scale::log ? 1.0 : 0.0;
      scaled[k].upper = scaled[k].scale == Scale::log ? std::pow(kE, unit) : unit;
    }
    GaussianProcessOptions o = options_of(trial);
    o.starts = starts;
    o.threads = 1;
    return GaussianProcess::fit(x, y, scaled, o);
  }

  const Matrix& x_;
  const Vector& y_;
  const std::vector<Input>& inputs_;
  GaussianProcessOptions options_;
  const TuningOptions& tuning_;
  std::vector<Eigen::Index> folds_;
  double range_ = 0.0;
};

}  // namespace

Tuning tune_model(const Matrix& x, const Vector& y, const std::vector<Input>& inputs,
                  const GaussianProcessOptions& options, const TuningOptions& tuning) {
  if (tuning.initial_points < 2 || tuning.evaluations < tuning.initial_points)
    throw InputError(
        fmt::format("{} evaluations of which the first {} are by chance; there must "
                    "be at least 2 by chance and no fewer in all",
                    tuning.evaluations, tuning.initial_points));
  const Tuner tuner(x, y, inputs, options, tuning);
  const opt::OptimizationProblem problem = tuner.problem();
  opt::BayesianOptimizationOptions bayesian{.initial_points = tuning.initial_points,
                                            .seed = tuning.seed};
  bayesian.propose.repeats = opt::Repeats::avoid;
  bayesian.propose.threads = tuning.threads;
  // the optimiser's own model: noise estimated, categories exchangeable
  opt::BayesianOptimizer optimizer(problem, gaussian_process_fitter(problem.parameters), bayesian);
  std::vector<TuningTrial> trials;
  double best_rmse = std::numeric_limits<double>::infinity();
  for (int i = 0; i < tuning.evaluations; ++i) {
    const opt::Trial asked = optimizer.ask()[0];
    TuningTrial trial = tuner.trial_at(asked.x);
    tuner.cross_validate(trial);
    optimizer.tell(asked.id, Vector::Constant(1, tuner.loss(trial)));
    if (trial.failure.empty()) best_rmse = std::min(best_rmse, trial.rmse);
    trials.push_back(std::move(trial));
    if (tuning.progress)
      tuning.progress(i + 1, tuning.evaluations, fmt::format("smallest error {:.4g}", best_rmse));
  }
  if (!std::isfinite(best_rmse))
    throw InputError(fmt::format("none of {} settings could be fitted; the first: {}",
                                 trials.size(), trials.front().failure));
  auto best = static_cast<std::size_t>(optimizer.recommend().trial - 1);
  if (!trials[best].failure.empty())
    best =
        static_cast<std::size_t>(std::min_element(trials.begin(), trials.end(),
                                                  [](const TuningTrial& a, const TuningTrial& b) {
                                                    return std::pair(!a.failure.empty(), a.rmse) <
                                                           std::pair(!b.failure.empty(), b.rmse);
                                                  }) -
                                 trials.begin());
  return {tuner.final_model(trials[best]), std::move(trials), best};
}

}  // namespace repose::surrogate

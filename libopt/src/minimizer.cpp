#include "repose/opt/minimizer.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/base/thread_pool.hpp"

namespace repose::opt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct NloptDeleter {
  void operator()(nlopt_opt_s* handle) const { nlopt_destroy(handle); }
};
using NloptHandle = std::unique_ptr<nlopt_opt_s, NloptDeleter>;

/// Stands between NLopt and the objective: counts, remembers the best point, and replaces values
/// that are not finite by one worse than all seen.
class Recorder {
 public:
  Recorder(const Objective& objective, const Bounds& bounds, const Vector& start)
      : objective_(objective), bounds_(bounds), best_(start), x_(start), gradient_(start.size()) {}

  static double call(unsigned n, const double* x, double* gradient, void* self) {
    return static_cast<Recorder*>(self)->evaluate(n, x, gradient);
  }

  void attach(nlopt_opt_s* handle) { handle_ = handle; }
  const Vector& best() const { return best_; }
  double best_value() const { return best_value_; }
  int evaluations() const { return evaluations_; }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

 private:
  double evaluate(unsigned n, const double* x, double* gradient) {
    ++evaluations_;
    const auto size = static_cast<Eigen::Index>(n);
    try {
      x_ = project(Eigen::Map<const Vector>(x, size), bounds_);
      gradient_.setZero(size);
      const double value = objective_(x_, gradient != nullptr ? &gradient_ : nullptr);
      if (gradient != nullptr) {
        const Vector safe = gradient_.array().isFinite().select(gradient_, 0.0);
        Eigen::Map<Vector>(gradient, size) = safe;
      }
      return remember(value);
    } catch (...) {
      error_ = std::current_exception();
      nlopt_force_stop(handle_);
      return 0.0;
    }
  }

  double remember(double value) {
    if (!std::isfinite(value))
      return std::isfinite(worst_) ? worst_ + 10.0 * (1.0 + std::abs(worst_)) : 1e30;
    worst_ = std::max(worst_, value);
    if (value < best_value_) {
      best_value_ = value;
      best_ = x_;
    }
    return value;
  }

  const Objective& objective_;
  const Bounds& bounds_;
  Vector best_;
  Vector x_;
  Vector gradient_;
  double best_value_ = kInfinity;
  double worst_ = -kInfinity;
  int evaluations_ = 0;
  nlopt_opt_s* handle_ = nullptr;
  std::exception_ptr error_;
};

nlopt_algorithm nlopt_name(Algorithm algorithm) {
  switch (algorithm) {
    case Algorithm::lbfgs:
      return NLOPT_LD_LBFGS;
    case Algorithm::slsqp:
      return NLOPT_LD_SLSQP;
    case Algorithm::bobyqa:
      return NLOPT_LN_BOBYQA;
    case Algorithm::crs2:
      return NLOPT_GN_CRS2_LM;
    case Algorithm::direct_l:
      return NLOPT_GN_DIRECT_L;
    case Algorithm::isres:
      return NLOPT_GN_ISRES;
  }
  throw Error(ErrorKind::internal, "unknown minimisation algorithm");
}

const char* algorithm_name(Algorithm algorithm) {
  constexpr const char* kNames[] = {"lbfgs", "slsqp", "bobyqa", "crs2", "direct_l", "isres"};
  return kNames[static_cast<int>(algorithm)];
}

std::optional<Algorithm> fallback_of(Algorithm algorithm) {
  if (algorithm == Algorithm::lbfgs) return Algorithm::slsqp;
  if (algorithm == Algorithm::slsqp) return Algorithm::bobyqa;
  return std::nullopt;
}

void require(nlopt_result result, const char* setting) {
  if (result < 0)
    throw Error(ErrorKind::internal,
                fmt::format("NLopt refused {} with code {}", setting, static_cast<int>(result)));
}

NloptHandle make_handle(Algorithm algorithm, const Bounds& bounds, const MinimizerOptions& options,
                        int evaluations_left) {
  const Vector range = bounds.upper - bounds.lower;
  NloptHandle handle(nlopt_create(nlopt_name(algorithm), static_cast<unsigned>(range.size())));
  if (!handle) throw Error(ErrorKind::internal, "NLopt could not create an optimiser");
  const Vector absolute = options.absolute_x_tolerance * range;
  require(nlopt_set_lower_bounds(handle.get(), bounds.lower.data()), "lower bounds");
  require(nlopt_set_upper_bounds(handle.get(), bounds.upper.data()), "upper bounds");
  require(nlopt_set_xtol_rel(handle.get(), options.relative_x_tolerance),
          "the relative x tolerance");
  require(nlopt_set_xtol_abs(handle.get(), absolute.data()), "the absolute x tolerance");
  require(nlopt_set_ftol_rel(handle.get(), options.relative_f_tolerance), "the f tolerance");
  require(nlopt_set_maxeval(handle.get(), evaluations_left), "the evaluation limit");
  if (algorithm == Algorithm::bobyqa && options.initial_step > 0.0) {
    const Vector step = (options.initial_step * range).cwiseMax(std::numeric_limits<double>::min());
    require(nlopt_set_initial_step(handle.get(), step.data()), "the initial step");
  }
  return handle;
}

/// One method from `start`; what it found is in the recorder.
nlopt_result run(Algorithm algorithm, Vector start, const Bounds& bounds,
                 const MinimizerOptions& options, Recorder& recorder) {
  const int left = options.max_evaluations - recorder.evaluations();
  const NloptHandle handle = make_handle(algorithm, bounds, options, left);
  require(nlopt_set_min_objective(handle.get(), &Recorder::call, &recorder), "the objective");
  recorder.attach(handle.get());
  nlopt_srand(static_cast<unsigned long>(options.seed));  // a state of this thread
  double value = 0.0;
  const nlopt_result result = nlopt_optimize(handle.get(), start.data(), &value);
  recorder.attach(nullptr);
  recorder.rethrow();
  return result;
}

struct Verdict {
  Termination termination;
  std::string message;
};

Verdict verdict(nlopt_result result, Algorithm algorithm, double value, int evaluations) {
  const char* name = algorithm_name(algorithm);
  if (!std::isfinite(value))
    return {Termination::failed,
            fmt::format("no finite value in {} evaluations; start elsewhere", evaluations)};
  if (result == NLOPT_MAXEVAL_REACHED)
    return {Termination::budget, fmt::format("{}: all {} evaluations used", name, evaluations)};
  if (result > 0)
    return {Termination::converged,
            fmt::format("{}: converged after {} evaluations", name, evaluations)};
  return {Termination::round_off,
          fmt::format("{}: no further progress after {} evaluations", name, evaluations)};
}

}  // namespace

const char* to_string(Termination termination) {
  constexpr const char* kNames[] = {"converged", "budget", "round_off", "failed"};
  return kNames[static_cast<int>(termination)];
}

Minimum minimize(const Objective& objective, const Vector& start, const Bounds& bounds,
                 const MinimizerOptions& options) {
  check_bounds(bounds);
  if (start.size() != bounds.lower.size() || !start.allFinite())
    throw InputError(fmt::format("a start of {} coordinates, which must be {} finite numbers",
                                 start.size(), bounds.lower.size()));
  if (options.max_evaluations < 1)
    throw InputError(
        fmt::format("max_evaluations is {}; it must be at least 1", options.max_evaluations));
  const Clock::time_point begin = Clock::now();
  const Vector first = project(start, bounds);
  Recorder recorder(objective, bounds, first);

  Algorithm algorithm = options.algorithm;
  nlopt_result result = run(algorithm, first, bounds, options, recorder);
  while (result < 0 && fallback_of(algorithm) && recorder.evaluations() < options.max_evaluations) {
    algorithm = *fallback_of(algorithm);
    result = run(algorithm, recorder.best(), bounds, options, recorder);
  }
  const Verdict v = verdict(result, algorithm, recorder.best_value(), recorder.evaluations());
  return {recorder.best(), recorder.best_value(),  v.termination,
          v.message,       recorder.evaluations(), seconds_since(begin)};
}

Minimum multi_start(const Objective& objective, const Matrix& starts, const Bounds& bounds,
                    const Minimizer& minimizer, unsigned threads) {
  if (starts.rows() < 1) throw InputError("a multi-start minimisation needs at least one start");
  const Clock::time_point begin = Clock::now();
  std::vector<Minimum> minima(static_cast<std::size_t>(starts.rows()));
  parallel_for(minima.size(), threads, [&](std::size_t i) {
    minima[i] = minimizer.minimize(objective, starts.row(static_cast<Eigen::Index>(i)), bounds);
  });
  std::size_t best = 0;
  int evaluations = 0;
  for (std::size_t i = 0; i < minima.size(); ++i) {
    evaluations += minima[i].evaluations;
    if (minima[i].value < minima[best].value) best = i;
  }
  Minimum result = minima[best];
  result.evaluations = evaluations;
  result.seconds = seconds_since(begin);
  return result;
}

}  // namespace repose::opt

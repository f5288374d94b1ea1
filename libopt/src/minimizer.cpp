#include "repose/opt/minimizer.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "nlopt_search.hpp"
#include "repose/base/error.hpp"
#include "repose/base/thread_pool.hpp"

namespace repose::opt {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

const char* algorithm_name(Algorithm algorithm) {
  constexpr const char* kNames[] = {"lbfgs", "slsqp", "bobyqa", "crs2", "direct_l", "isres"};
  return kNames[static_cast<int>(algorithm)];
}

/// None where there are constraints: bobyqa takes none, and a global search would be another thing.
std::optional<Algorithm> fallback_of(Algorithm algorithm, const FeasibleSet& set) {
  if (!set.inequalities.empty()) return std::nullopt;
  if (algorithm == Algorithm::lbfgs) return Algorithm::slsqp;
  if (algorithm == Algorithm::slsqp) return Algorithm::bobyqa;
  return std::nullopt;
}

bool takes_inequalities(Algorithm algorithm) {
  return algorithm == Algorithm::slsqp || algorithm == Algorithm::isres;
}

void check_problem(const Vector& start, const FeasibleSet& set, const MinimizerOptions& options) {
  check_feasible_set(set);
  if (start.size() != set.bounds.lower.size() || !start.allFinite())
    throw InputError(fmt::format("a start of {} coordinates, which must be {} finite numbers",
                                 start.size(), set.bounds.lower.size()));
  if (options.max_evaluations < 1)
    throw InputError(
        fmt::format("max_evaluations is {}; it must be at least 1", options.max_evaluations));
  if (!(options.initial_curvature >= 0.0) || !std::isfinite(options.initial_curvature))
    throw InputError(fmt::format("initial_curvature is {}; it must be 0 or a finite number above",
                                 options.initial_curvature));
  if (!set.whole.empty())
    throw InputError(fmt::format(
        "coordinate {} is to be a whole number, which {} does not know; the genetic algorithm and "
        "CMA-ES do",
        set.whole.front() + 1, algorithm_name(options.algorithm)));
  if (!set.inequalities.empty() && !takes_inequalities(options.algorithm))
    throw InputError(fmt::format(
        "{} takes no linear constraints; slsqp (local, with gradient) and isres (global) do, and "
        "so do the genetic algorithm and CMA-ES",
        algorithm_name(options.algorithm)));
}

struct Verdict {
  Termination termination;
  std::string message;
};

std::string count_of(const Recorder& recorder) {
  if (recorder.points() == recorder.evaluations())
    return fmt::format("{} evaluation{}", recorder.evaluations(),
                       recorder.evaluations() == 1 ? "" : "s");
  return fmt::format("{} points, {} of which obey the constraints", recorder.points(),
                     recorder.evaluations());
}

/// One method from x; what it found is in the recorder.
RunEnd run(Algorithm algorithm, const Vector& x, const MinimizerOptions& options,
           Recorder& recorder) {
  if (algorithm != Algorithm::lbfgs) return run_nlopt(algorithm, x, options, recorder);
  const Objective objective = [&](const Vector& y, Vector* gradient) {
    return recorder.value_at(y, gradient);
  };
  const ReducedSet& space = recorder.space();
  return run_lbfgs(objective, space.reduced(x), space.bounds(), options,
                   options.max_evaluations - recorder.points());
}

Verdict verdict(RunEnd end, Algorithm algorithm, const Recorder& recorder) {
  const char* name = algorithm_name(algorithm);
  const std::string count = count_of(recorder);
  if (!std::isfinite(recorder.best_value()))
    return {Termination::failed, fmt::format("no finite value in {}; start elsewhere", count)};
  if (end == RunEnd::budget)
    return {Termination::budget, fmt::format("{}: all {} used", name, count)};
  if (end == RunEnd::converged)
    return {Termination::converged, fmt::format("{}: converged after {}", name, count)};
  const bool constrained = !recorder.space().set().inequalities.empty();
  return {Termination::round_off,
          fmt::format("{}: no further progress after {}{}", name, count,
                      constrained ? "; no other local method takes linear constraints" : "")};
}

Minimum without_feasible_point(const Vector& nearest, const FeasibleSet& set) {
  std::string broken;
  for (std::size_t i = 0; i < set.inequalities.size(); ++i) {
    const LinearInequality& c = set.inequalities[i];
    if (violation(nearest, {set.bounds, {c}}) > 0.0)
      broken += fmt::format("{} {} is {} and must be at most {}", broken.empty() ? "" : " and",
                            c.name.empty() ? fmt::format("constraint {}", i + 1) : c.name,
                            c.coefficients.dot(nearest), c.bound);
  }
  return {nearest, std::numeric_limits<double>::infinity(), Termination::failed,
          "no point was found that obeys all constraints at once; at the nearest" + broken};
}

}  // namespace

const char* to_string(Termination termination) {
  constexpr const char* kNames[] = {"converged", "budget", "round_off", "failed"};
  return kNames[static_cast<int>(termination)];
}

Minimum minimize(const Objective& objective, const Vector& start, const Bounds& bounds,
                 const MinimizerOptions& options) {
  return minimize(objective, start, FeasibleSet{bounds}, options);
}

template <std::same_as<FeasibleSet> Set>
Minimum minimize(const Objective& objective, const Vector& start, const Set& set,
                 const MinimizerOptions& options) {
  check_problem(start, set, options);
  const Clock::time_point begin = Clock::now();
  const ReducedSet space(set);
  const Vector first = nearest_feasible(rounded(start, set), space);
  if (violation(first, set) > 0.0) return without_feasible_point(first, set);
  Recorder recorder(objective, space, first);

  Algorithm algorithm = options.algorithm;
  RunEnd end = run(algorithm, first, options, recorder);
  while (end == RunEnd::gave_up && options.fallback == Fallback::next_method &&
         fallback_of(algorithm, set) && recorder.points() < options.max_evaluations) {
    algorithm = *fallback_of(algorithm, set);
    end = run(algorithm, recorder.best(), options, recorder);
  }
  const Verdict v = verdict(end, algorithm, recorder);
  return {recorder.best(), recorder.best_value(),  v.termination,
          v.message,       recorder.evaluations(), seconds_since(begin)};
}

namespace {

Minimum best_of_starts(const Matrix& starts, unsigned threads,
                       const std::function<Minimum(const Vector& start)>& search) {
  if (starts.rows() < 1) throw InputError("a multi-start minimisation needs at least one start");
  const Clock::time_point begin = Clock::now();
  std::vector<Minimum> minima(static_cast<std::size_t>(starts.rows()));
  parallel_for(minima.size(), threads, [&](std::size_t i) {
    minima[i] = search(starts.row(static_cast<Eigen::Index>(i)));
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

}  // namespace

Minimum multi_start(const Objective& objective, const Matrix& starts, const Bounds& bounds,
                    const Minimizer& minimizer, unsigned threads) {
  return best_of_starts(starts, threads, [&](const Vector& start) {
    return minimizer.minimize(objective, start, bounds);
  });
}

template <std::same_as<FeasibleSet> Set>
Minimum multi_start(const Objective& objective, const Matrix& starts, const Set& set,
                    const MinimizerOptions& options, unsigned threads) {
  return best_of_starts(starts, threads, [&](const Vector& start) {
    return minimize(objective, start, set, options);
  });
}

template Minimum minimize(const Objective&, const Vector&, const FeasibleSet&,
                          const MinimizerOptions&);
template Minimum multi_start(const Objective&, const Matrix&, const FeasibleSet&,
                             const MinimizerOptions&, unsigned);

}  // namespace repose::opt

#include "nlopt_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

/// In ranges of a constraint: what SLSQP may leave of it by rounding.
constexpr double kConstraintRounding = 1e-10;

struct NloptDeleter {
  void operator()(nlopt_opt handle) const { nlopt_destroy(handle); }
};
using NloptHandle = std::unique_ptr<nlopt_opt_s, NloptDeleter>;

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

void require(nlopt_result result, const char* setting) {
  if (result < 0)
    throw Error(ErrorKind::internal,
                fmt::format("NLopt refused {} with code {}", setting, static_cast<int>(result)));
}

double excess(unsigned n, const double* y, double* gradient, void* inequality) {
  const auto& c = *static_cast<const LinearInequality*>(inequality);
  const auto size = static_cast<Eigen::Index>(n);
  if (gradient != nullptr) Eigen::Map<Vector>(gradient, size) = c.coefficients;
  return c.coefficients.dot(Eigen::Map<const Vector>(y, size)) - c.bound;
}

NloptHandle make_handle(Algorithm algorithm, const Bounds& bounds,
                        const std::vector<LinearInequality>& inequalities, int max_points) {
  NloptHandle handle(
      nlopt_create(nlopt_name(algorithm), static_cast<unsigned>(bounds.lower.size())));
  if (!handle) throw Error(ErrorKind::internal, "NLopt could not create an optimiser");
  require(nlopt_set_lower_bounds(handle.get(), bounds.lower.data()), "lower bounds");
  require(nlopt_set_upper_bounds(handle.get(), bounds.upper.data()), "upper bounds");
  require(nlopt_set_maxeval(handle.get(), max_points), "the evaluation limit");
  for (const LinearInequality& c : inequalities)
    require(nlopt_add_inequality_constraint(handle.get(), excess, const_cast<LinearInequality*>(&c),
                                            kConstraintRounding),
            "a linear constraint");
  return handle;
}

void set_tolerances(nlopt_opt handle, Algorithm algorithm, const Bounds& bounds,
                    const MinimizerOptions& options) {
  const Vector range = bounds.upper - bounds.lower;
  const Vector absolute = options.absolute_x_tolerance * range;
  require(nlopt_set_xtol_rel(handle, options.relative_x_tolerance), "the relative x tolerance");
  require(nlopt_set_xtol_abs(handle, absolute.data()), "the absolute x tolerance");
  require(nlopt_set_ftol_rel(handle, options.relative_f_tolerance), "the f tolerance");
  if (algorithm == Algorithm::bobyqa && options.initial_step > 0.0) {
    const Vector step = (options.initial_step * range).cwiseMax(std::numeric_limits<double>::min());
    require(nlopt_set_initial_step(handle, step.data()), "the initial step");
  }
}

/// (u - wanted)^2 / 2.
double half_square(unsigned n, const double* u, double* gradient, void* wanted) {
  const Vector off =
      Eigen::Map<const Vector>(u, static_cast<Eigen::Index>(n)) - *static_cast<Vector*>(wanted);
  if (gradient != nullptr) Eigen::Map<Vector>(gradient, off.size()) = off;
  return 0.5 * off.squaredNorm();
}

}  // namespace

ReducedSet::ReducedSet(const FeasibleSet& set) : set_(set), free_(free_coordinates(set)) {
  const Bounds all = narrowed_bounds(set);
  bounds_ = {all.lower(free_), all.upper(free_)};
  for (LinearInequality c : set.inequalities) {
    for (const LinearTie& tie : set.ties) c.bound -= c.coefficients[tie.follower] * tie.offset;
    c.coefficients = reduced_gradient(c.coefficients);
    const double range = c.coefficients.cwiseAbs().dot(bounds_.upper - bounds_.lower);
    if (!(range > 0.0)) continue;  // the same everywhere, and check_feasible_set has seen it
    c.coefficients /= range;
    c.bound /= range;
    inequalities_.push_back(std::move(c));
  }
}

Vector ReducedSet::complete(const Vector& y) const {
  if (set_.ties.empty()) return project(y, bounds_);
  Vector x = set_.bounds.lower;
  x(free_) = y;
  return rounded(x, set_);
}

Vector ReducedSet::reduced_gradient(const Vector& gradient) const {
  Vector all = gradient;
  for (const LinearTie& tie : set_.ties) all[tie.leader] += tie.ratio * gradient[tie.follower];
  return all(free_);
}

double Recorder::call(unsigned n, const double* y, double* gradient, void* self) {
  auto& recorder = *static_cast<Recorder*>(self);
  try {
    return recorder.evaluate(Eigen::Map<const Vector>(y, static_cast<Eigen::Index>(n)), gradient);
  } catch (...) {
    recorder.error_ = std::current_exception();
    nlopt_force_stop(recorder.handle_);
    return 0.0;
  }
}

double Recorder::evaluate(const Vector& y, double* gradient) {
  ++points_;
  x_ = space_.complete(y);
  gradient_.setZero();
  const double off = violation(x_, space_.set());
  double value = std::numeric_limits<double>::quiet_NaN();
  if (off <= kConstraintRounding) {
    ++evaluations_;
    value = objective_(x_, gradient != nullptr ? &gradient_ : nullptr);
  }
  if (gradient != nullptr) {
    const Vector safe = gradient_.array().isFinite().select(gradient_, 0.0);
    Eigen::Map<Vector>(gradient, y.size()) = space_.reduced_gradient(safe);
  }
  return remember(value, off);
}

double Recorder::remember(double value, double violation) {
  if (!std::isfinite(value))
    return std::isfinite(worst_) ? worst_ + 10.0 * (1.0 + std::abs(worst_)) : 1e30;
  worst_ = std::max(worst_, value);
  if (value < best_value_ && violation == 0.0) {
    best_value_ = value;
    best_ = x_;
  }
  return value;
}

nlopt_result run_nlopt(Algorithm algorithm, const Vector& x, const MinimizerOptions& options,
                       Recorder& recorder) {
  const ReducedSet& space = recorder.space();
  const NloptHandle handle = make_handle(algorithm, space.bounds(), space.inequalities(),
                                         options.max_evaluations - recorder.points());
  set_tolerances(handle.get(), algorithm, space.bounds(), options);
  require(nlopt_set_min_objective(handle.get(), &Recorder::call, &recorder), "the objective");
  recorder.attach(handle.get());
  nlopt_srand(static_cast<unsigned long>(options.seed));  // a state of this thread
  Vector y = space.reduced(x);
  double value = 0.0;
  const nlopt_result result = nlopt_optimize(handle.get(), y.data(), &value);
  recorder.attach(nullptr);
  recorder.rethrow();
  return result;
}

Vector nearest_feasible(const Vector& x, const ReducedSet& space) {
  if (violation(x, space.set()) == 0.0) return x;
  const Bounds& bounds = space.bounds();
  const Vector range = (bounds.upper - bounds.lower).cwiseMax(1e-300);
  Vector best = x;
  // The projection touches constraints, and rounding may leave it outside: then inside by a hair.
  for (const double margin : {0.0, 1e-14, 1e-12}) {
    std::vector<LinearInequality> scaled = space.inequalities();
    for (LinearInequality& c : scaled) {
      c.bound -= c.coefficients.dot(bounds.lower) + margin;
      c.coefficients = c.coefficients.cwiseProduct(range).eval();
    }
    const Bounds unit = {Vector::Zero(range.size()),
                         (bounds.upper - bounds.lower).cwiseQuotient(range)};
    const NloptHandle handle = make_handle(Algorithm::slsqp, unit, scaled, 200);
    Vector wanted = (space.reduced(x) - bounds.lower).cwiseQuotient(range);
    require(nlopt_set_min_objective(handle.get(), half_square, &wanted), "a squared distance");
    require(nlopt_set_xtol_rel(handle.get(), 1e-14), "the relative x tolerance");
    Vector u = wanted;
    double value = 0.0;
    nlopt_optimize(handle.get(), u.data(), &value);
    const Vector found = space.complete(bounds.lower + u.cwiseProduct(range));
    if (violation(found, space.set()) < violation(best, space.set())) best = found;
    if (violation(best, space.set()) == 0.0) break;
  }
  return best;
}

const char* algorithm_name(Algorithm algorithm) {
  constexpr const char* kNames[] = {"lbfgs", "slsqp", "bobyqa", "crs2", "direct_l", "isres"};
  return kNames[static_cast<int>(algorithm)];
}

}  // namespace repose::opt

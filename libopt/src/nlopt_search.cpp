#include "nlopt_search.hpp"

#include <fmt/format.h>
#include <nlopt.h>

#include <cmath>
#include <exception>
#include <limits>
#include <memory>
#include <vector>

#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

struct NloptDeleter {
  void operator()(nlopt_opt handle) const { nlopt_destroy(handle); }
};
using NloptHandle = std::unique_ptr<nlopt_opt_s, NloptDeleter>;

nlopt_algorithm nlopt_name(Algorithm algorithm) {
  switch (algorithm) {
    case Algorithm::lbfgs:
      break;  // ours, lbfgs.hpp
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
  throw Error(ErrorKind::internal, "no algorithm of NLopt");
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

/// The recorder as NLopt calls it; exceptions wait until NLopt has returned.
struct Callback {
  Recorder& recorder;
  nlopt_opt handle;
  Vector gradient;
  std::exception_ptr error = nullptr;
};

double call(unsigned n, const double* y, double* gradient, void* callback) {
  auto& self = *static_cast<Callback*>(callback);
  const auto size = static_cast<Eigen::Index>(n);
  try {
    const double value = self.recorder.value_at(Eigen::Map<const Vector>(y, size),
                                                gradient != nullptr ? &self.gradient : nullptr);
    if (gradient != nullptr) Eigen::Map<Vector>(gradient, size) = self.gradient;
    return std::isfinite(value) ? value : self.recorder.penalty();
  } catch (...) {
    self.error = std::current_exception();
    nlopt_force_stop(self.handle);
    return 0.0;
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

RunEnd run_nlopt(Algorithm algorithm, const Vector& x, const MinimizerOptions& options,
                 Recorder& recorder) {
  const ReducedSet& space = recorder.space();
  const NloptHandle handle = make_handle(algorithm, space.bounds(), space.inequalities(),
                                         options.max_evaluations - recorder.points());
  set_tolerances(handle.get(), algorithm, space.bounds(), options);
  Callback callback{recorder, handle.get(), Vector(space.bounds().lower.size())};
  require(nlopt_set_min_objective(handle.get(), call, &callback), "the objective");
  nlopt_srand(static_cast<unsigned long>(options.seed));  // a state of this thread
  Vector y = space.reduced(x);
  double value = 0.0;
  const nlopt_result result = nlopt_optimize(handle.get(), y.data(), &value);
  if (callback.error) std::rethrow_exception(callback.error);
  if (result == NLOPT_MAXEVAL_REACHED) return RunEnd::budget;
  return result > 0 ? RunEnd::converged : RunEnd::gave_up;
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

}  // namespace repose::opt

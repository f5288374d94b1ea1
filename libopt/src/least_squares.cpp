// Least squares by Ceres, which meets the residuals after differences and loss and over the free
// parameters only; it is given nothing that it would log about.
#include "repose/opt/least_squares.hpp"

#include <ceres/cost_function.h>
#include <ceres/iteration_callback.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <utility>
#include <vector>

#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

using Clock = std::chrono::steady_clock;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// rho(s) and its derivative.
struct Weight {
  double rho = 0.0;
  double slope = 1.0;
};

Weight weight_of(Loss loss, double s) {
  switch (loss) {
    case Loss::none:
      return {s, 1.0};
    case Loss::huber:
      return s <= 1.0 ? Weight{s, 1.0} : Weight{2.0 * std::sqrt(s) - 1.0, 1.0 / std::sqrt(s)};
    case Loss::cauchy:
      return {std::log1p(s), 1.0 / (1.0 + s)};
    case Loss::soft_l1:  // 2 (sqrt(1 + s) - 1) without cancellation
      return {2.0 * s / (std::sqrt(1.0 + s) + 1.0), 1.0 / std::sqrt(1.0 + s)};
  }
  throw Error(ErrorKind::internal, "unknown loss");
}

/// The user's residuals: counted, checked, differentiated.
class Model {
 public:
  Model(const Residuals& residuals, const Bounds& bounds, const LeastSquaresOptions& options)
      : residuals_(residuals), bounds_(bounds), options_(options) {
    for (Eigen::Index k = 0; k < bounds.lower.size(); ++k)
      if (bounds.lower[k] < bounds.upper[k]) free_.push_back(k);
  }

  /// Parameters that are not given.
  const std::vector<Eigen::Index>& free() const { return free_; }
  int evaluations() const { return evaluations_; }
  bool has_evaluations_left() const { return evaluations_ < options_.max_evaluations; }

  Vector residuals_at(const Vector& x, Matrix* jacobian = nullptr) {
    ++evaluations_;
    Vector r = residuals_(x, jacobian);
    if (count_ == 0) count_ = r.size();
    if (r.size() == 0 || r.size() != count_)
      throw InputError(
          fmt::format("{} residuals, after {} before; there must be at least one and "
                      "always as many",
                      r.size(), count_));
    return r;
  }

  /// Residuals and their derivatives, n x d; zero in fixed parameters.
  Vector linearised(const Vector& x, Matrix& jacobian) {
    if (options_.derivatives == Derivatives::numeric) {
      Vector r = residuals_at(x);
      jacobian = differences(x, r);
      return r;
    }
    jacobian = Matrix::Constant(count_, x.size(), std::numeric_limits<double>::quiet_NaN());
    Vector r = residuals_at(x, &jacobian);
    if (jacobian.rows() != r.size() || jacobian.cols() != x.size())
      throw InputError(fmt::format("a Jacobian of {} x {} for {} residuals of {} parameters",
                                   jacobian.rows(), jacobian.cols(), r.size(), x.size()));
    return r;
  }

 private:
  /// Central differences over x - h, x + h; where a bound is in the way x, x + h, x + 2 h or their
  /// mirror, of second order too. h = eps^(1/3) of |x| or of a millionth of the range.
  Matrix differences(const Vector& x, const Vector& r) {
    static const double kStep = std::cbrt(std::numeric_limits<double>::epsilon());
    Matrix jacobian = Matrix::Zero(r.size(), x.size());
    for (const Eigen::Index k : free_) {
      const double below = x[k] - bounds_.lower[k], above = bounds_.upper[k] - x[k];
      const double h = kStep * std::max(std::abs(x[k]), 1e-6 * (below + above));
      if (below >= h && above >= h) {
        jacobian.col(k) = (shifted(x, k, h) - shifted(x, k, -h)) / (2.0 * h);
      } else {
        const double s = above >= below ? std::min(h, 0.5 * above) : -std::min(h, 0.5 * below);
        jacobian.col(k) = (4.0 * shifted(x, k, s) - shifted(x, k, 2.0 * s) - 3.0 * r) / (2.0 * s);
      }
    }
    return jacobian;
  }

  Vector shifted(Vector x, Eigen::Index k, double step) {
    x[k] = std::clamp(x[k] + step, bounds_.lower[k], bounds_.upper[k]);
    return residuals_at(x);
  }

  const Residuals& residuals_;
  const Bounds& bounds_;
  const LeastSquaresOptions& options_;
  std::vector<Eigen::Index> free_;
  Eigen::Index count_ = 0;
  int evaluations_ = 0;
};

/// The robust cost as a sum of squares, sum c_i^2/2 with c = sign(r) scale sqrt(rho), and
/// dc/dx = rho' r/c dr/dx.
void apply_loss(const LeastSquaresOptions& options, Vector& r, Matrix* jacobian) {
  if (options.loss == Loss::none) return;
  for (Eigen::Index i = 0; i < r.size(); ++i) {
    const double u = r[i] / options.loss_scale;
    const Weight w = weight_of(options.loss, u * u);
    if (w.rho == 0.0) continue;
    const double c = std::copysign(std::sqrt(w.rho), u);
    r[i] = options.loss_scale * c;
    if (jacobian != nullptr) jacobian->row(i) *= w.slope * u / c;
  }
}

/// What Ceres minimises, over some of the parameters. It must never see a failure where it asks for
/// derivatives, which it does at points it has accepted and would log about: then it is told that
/// nothing goes down, and the failure is kept.
class Cost final : public ceres::CostFunction {
 public:
  Cost(Model& model, const Vector& x, Eigen::Index n, std::vector<Eigen::Index> moving,
       const LeastSquaresOptions& options)
      : model_(model), x_(x), moving_(std::move(moving)), options_(options) {
    set_num_residuals(static_cast<int>(n));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(moving_.size()));
  }

  const std::vector<Eigen::Index>& moving() const { return moving_; }
  bool has_derivatives() const { return has_derivatives_; }
  void rethrow() const {
    if (error_) std::rethrow_exception(error_);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const bool derived = jacobians != nullptr && jacobians[0] != nullptr;
    const auto p = static_cast<Eigen::Index>(moving_.size());
    Vector x = x_;
    x(moving_) = Eigen::Map<const Vector>(parameters[0], p);
    Vector r;
    Matrix j;
    const bool found = evaluate(x, r, derived ? &j : nullptr);
    if (!derived) {
      if (found) Eigen::Map<Vector>(residuals, r.size()) = r;
      return found;
    }
    has_derivatives_ = has_derivatives_ && found;
    Eigen::Map<Vector> to(residuals, num_residuals());
    Eigen::Map<RowMatrix> to_jacobian(jacobians[0], num_residuals(), p);
    to.setZero();
    to_jacobian.setZero();
    if (!found) return true;
    to = r;
    to_jacobian = j(Eigen::all, moving_);
    return true;
  }

 private:
  bool evaluate(const Vector& x, Vector& r, Matrix* jacobian) const {
    if (error_ || !model_.has_evaluations_left()) return false;
    try {
      r = jacobian != nullptr ? model_.linearised(x, *jacobian) : model_.residuals_at(x);
    } catch (...) {
      error_ = std::current_exception();
      return false;
    }
    if (!r.allFinite() || (jacobian != nullptr && !jacobian->allFinite())) return false;
    apply_loss(options_, r, jacobian);
    return true;
  }

  Model& model_;
  const Vector& x_;
  std::vector<Eigen::Index> moving_;
  const LeastSquaresOptions& options_;
  mutable std::exception_ptr error_;
  mutable bool has_derivatives_ = true;
};

/// Ends the search when the evaluations are used up.
struct Budget final : ceres::IterationCallback {
  explicit Budget(const Model& m) : model(m) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return model.has_evaluations_left() ? ceres::SOLVER_CONTINUE
                                        : ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }
  const Model& model;
};

void check(const Vector& start, const Bounds& bounds, const LeastSquaresOptions& o) {
  check_bounds(bounds);
  if (start.size() != bounds.lower.size() || !start.allFinite())
    throw InputError(fmt::format("a start of {} coordinates, which must be {} finite numbers",
                                 start.size(), bounds.lower.size()));
  if (!(o.loss_scale > 0.0) || !std::isfinite(o.loss_scale))
    throw InputError(fmt::format("loss_scale is {}; it must be above 0", o.loss_scale));
  if (!(o.relative_f_tolerance >= 0.0) || !(o.relative_x_tolerance >= 0.0))
    throw InputError(fmt::format("tolerances are {} and {}; they must be 0 or more",
                                 o.relative_f_tolerance, o.relative_x_tolerance));
  if (o.max_evaluations < 1)
    throw InputError(
        fmt::format("max_evaluations is {}; it must be at least 1", o.max_evaluations));
}

/// Ceres from x over the parameters that the cost moves; x becomes what it found.
ceres::TerminationType solve(const Model& model, Cost& cost, Vector& x, const Bounds& bounds,
                             const LeastSquaresOptions& options) {
  Vector parameters = x(cost.moving());
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(&cost, nullptr, parameters.data());
  for (std::size_t i = 0; i < cost.moving().size(); ++i) {
    const Eigen::Index k = cost.moving()[i];
    problem.SetParameterLowerBound(parameters.data(), static_cast<int>(i), bounds.lower[k]);
    problem.SetParameterUpperBound(parameters.data(), static_cast<int>(i), bounds.upper[k]);
  }
  Budget budget(model);
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::DENSE_QR;
  o.logging_type = ceres::SILENT;
  o.num_threads = 1;
  o.max_num_iterations = options.max_evaluations;
  o.function_tolerance = options.relative_f_tolerance;
  o.parameter_tolerance = options.relative_x_tolerance;
  o.gradient_tolerance = 0.0;  // has units; a small step says the same
  o.callbacks.push_back(&budget);
  ceres::Solver::Summary summary;
  ceres::Solve(o, &problem, &summary);
  cost.rethrow();
  x(cost.moving()) = parameters;
  x = project(x, bounds);
  return summary.termination_type;
}

/// The free parameters but for those that stand at a bound and are pushed against it.
std::vector<Eigen::Index> movable(const Model& model, const Vector& x, const Vector& gradient,
                                  const Bounds& bounds) {
  std::vector<Eigen::Index> moving;
  for (const Eigen::Index k : model.free()) {
    const bool held = (x[k] <= bounds.lower[k] && gradient[k] >= 0.0) ||
                      (x[k] >= bounds.upper[k] && gradient[k] <= 0.0);
    if (!held) moving.push_back(k);
  }
  return moving;
}

double cost_of(const Vector& r, const LeastSquaresOptions& o) {
  double sum = 0.0;
  for (const double value : r) sum += weight_of(o.loss, std::pow(value / o.loss_scale, 2)).rho;
  return 0.5 * o.loss_scale * o.loss_scale * sum;
}

/// Fills in the covariance or why there is none.
void add_covariance(LeastSquaresResult& result, const Matrix& jacobian, const Bounds& bounds,
                    const LeastSquaresOptions& options) {
  std::vector<Eigen::Index> off;  // their bounds
  for (Eigen::Index k = 0; k < result.x.size(); ++k)
    if (result.x[k] > bounds.lower[k] && result.x[k] < bounds.upper[k]) off.push_back(k);
  const Eigen::Index n = result.residuals.size(), p = static_cast<Eigen::Index>(off.size());
  if (p == 0) {
    result.no_covariance = "every parameter stands at a bound";
    return;
  }
  if (n <= p) {
    result.no_covariance = fmt::format("{} residuals leave none over for {} parameters", n, p);
    return;
  }
  Vector root(n);
  for (Eigen::Index i = 0; i < n; ++i)
    root[i] = std::sqrt(
        weight_of(options.loss, std::pow(result.residuals[i] / options.loss_scale, 2)).slope);
  const Matrix weighted = root.asDiagonal() * jacobian(Eigen::all, off);
  const Vector lengths = weighted.colwise().norm();
  // columns of length 1: no notice is taken of units
  Eigen::ColPivHouseholderQR<Matrix> qr;
  qr.setThreshold(options.derivatives == Derivatives::numeric ? 1e-9 : 1e-12);
  qr.compute(weighted * lengths.cwiseMax(1e-300).cwiseInverse().asDiagonal());
  if (!weighted.allFinite() || qr.rank() < p) {
    result.no_covariance = fmt::format("the residuals determine {} of {} parameters", qr.rank(), p);
    return;
  }
  const Matrix upper = qr.matrixR().topLeftCorner(p, p);
  const Matrix inverse = upper.triangularView<Eigen::Upper>().solve(Matrix::Identity(p, p));
  const Matrix rows = lengths.cwiseInverse().asDiagonal() * (qr.colsPermutation() * inverse);
  const double variance =
      root.cwiseProduct(result.residuals).squaredNorm() / static_cast<double>(n - p);
  result.covariance = Matrix::Zero(result.x.size(), result.x.size());
  result.covariance(off, off) = variance * rows * rows.transpose();
}

struct End {
  Termination termination = Termination::converged;
  const char* message = "converged";
};

End end_of(ceres::TerminationType type, const Model& model, const Cost& cost) {
  if (!model.has_evaluations_left()) return {Termination::budget, "all evaluations used"};
  if (!cost.has_derivatives())
    return {Termination::round_off, "stopped where the derivatives are not finite"};
  if (type == ceres::CONVERGENCE) return {};
  return {Termination::round_off, "no further progress"};
}

/// Ceres projects its steps onto the bounds and may come to rest where only some parameters stand
/// at theirs; so it is called again over the others until the same ones stay.
End search(Model& model, LeastSquaresResult& result, Matrix& jacobian, const Bounds& bounds,
           const LeastSquaresOptions& options) {
  End end;
  std::vector<Eigen::Index> before;
  for (Eigen::Index round = 0; round < 2 * result.x.size() + 2; ++round) {
    Vector r = result.residuals;
    Matrix j = jacobian;
    apply_loss(options, r, &j);
    const std::vector<Eigen::Index> moving = movable(model, result.x, j.transpose() * r, bounds);
    if (moving.empty() || moving == before) return end;
    before = moving;
    Cost cost(model, result.x, r.size(), moving, options);
    Vector x = result.x;
    const ceres::TerminationType type = solve(model, cost, x, bounds, options);
    end = end_of(type, model, cost);
    Matrix there;
    const Vector residuals = model.linearised(x, there);
    if (!(cost_of(residuals, options) <= cost_of(result.residuals, options)) || !there.allFinite())
      return end;
    result.x = x;
    result.residuals = residuals;
    jacobian = there;
    if (end.termination != Termination::converged) return end;
  }
  return end;
}

}  // namespace

LeastSquaresResult fit_least_squares(const Residuals& residuals, const Vector& start,
                                     const Bounds& bounds, const LeastSquaresOptions& options) {
  check(start, bounds, options);
  const Clock::time_point begin = Clock::now();
  Model model(residuals, bounds, options);
  LeastSquaresResult result;
  result.x = project(start, bounds);
  result.residuals = model.residuals_at(result.x);
  Matrix jacobian;
  if (result.residuals.allFinite()) result.residuals = model.linearised(result.x, jacobian);
  if (!result.residuals.allFinite() || !jacobian.allFinite()) {
    result.cost = std::numeric_limits<double>::infinity();
    result.message = "residuals or their derivatives are not finite at the start; start elsewhere";
    result.no_covariance = "there is no fit";
  } else {
    const End end = search(model, result, jacobian, bounds, options);
    result.cost = cost_of(result.residuals, options);
    result.termination = end.termination;
    result.message = fmt::format("{} after {} evaluations", end.message, model.evaluations());
    add_covariance(result, jacobian, bounds, options);
  }
  result.evaluations = model.evaluations();
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

}  // namespace repose::opt

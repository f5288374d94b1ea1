// L-BFGS [NocedalWright2006, chapter 7] with the projection of two metrics [Bertsekas1982]: bounds
// that the gradient pushes against are held, steps run along the projected path.
#include "lbfgs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace repose::opt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr Eigen::Index kMemory = 40;  // pairs; with as many inputs or fewer all of BFGS
constexpr double kFirstStep = 0.1;    // longest of the first step, of the range
// Weak Wolfe conditions [NocedalWright2006, 3.6].
constexpr double kDecrease = 1e-4;
constexpr double kCurvature = 0.9;
constexpr double kNoise = 10.0 * kEpsilon;  // differences of values that are rounding, relative
constexpr int kMaxTrials = 30;              // of one line search
constexpr double kFlat = 1e-10;             // cosine of a step and its change of gradient
constexpr double kFlatPromise = 1e-3;       // of the value or its fall since the start

using Mask = Eigen::Array<double, Eigen::Dynamic, 1>;  // 1: moves, 0: held at its bound

struct Point {
  Vector x;
  double value = kInfinity;
  Vector gradient;
};

/// The last steps and changes of the gradient, and the inverse Hessian that they imply.
class Memory {
 public:
  explicit Memory(Eigen::Index dimension) : s_(dimension, kMemory), y_(dimension, kMemory) {}

  void clear() { used_ = 0; }
  bool empty() const { return used_ == 0; }

  void add(const Vector& s, const Vector& y) {
    if (!(s.dot(y) > kFlat * s.norm() * y.norm())) return;
    newest_ = (newest_ + 1) % kMemory;
    used_ = std::min(used_ + 1, kMemory);
    s_.col(newest_) = s;
    y_.col(newest_) = y;
  }

  /// H v over the moving coordinates [NocedalWright2006, algorithm 7.4]; pairs that show no
  /// curvature there are left out. `initial`: diagonal of the H to start from, where 0 s.y/y.y of
  /// the newest pair.
  Vector times(const Vector& v, const Mask& moving, const Vector& initial) const {
    Vector q = v.array() * moving;
    Vector alpha(used_), rho(used_);
    double newest = 0.0;
    for (Eigen::Index i = 0; i < used_; ++i) {
      const auto s = s_.col(column(i)).array() * moving, y = y_.col(column(i)).array() * moving;
      const double sy = (s * y).sum(), yy = y.square().sum();
      rho[i] = sy > kFlat * std::sqrt(yy * s.square().sum()) ? 1.0 / sy : 0.0;
      if (newest == 0.0 && rho[i] > 0.0) newest = sy / yy;
      alpha[i] = rho[i] * (s * q.array()).sum();
      q.array() -= alpha[i] * y;
    }
    if (newest == 0.0) newest = 1.0;
    q.array() *= (initial.array() > 0.0).select(initial.array(), newest);
    for (Eigen::Index i = used_; i-- > 0;) {
      const auto s = s_.col(column(i)).array() * moving, y = y_.col(column(i)).array() * moving;
      if (rho[i] > 0.0) q.array() += (alpha[i] - rho[i] * (y * q.array()).sum()) * s;
    }
    return q;
  }

 private:
  Eigen::Index column(Eigen::Index age) const { return (newest_ - age + kMemory) % kMemory; }

  Matrix s_, y_;
  Eigen::Index newest_ = 0, used_ = 0;
};

/// A step length with value and slope.
struct Trial {
  double t = 0.0;
  double value = kInfinity;
  double slope = 0.0;
};

/// The minimum of the cubic through both ends, kept off them by a tenth.
double between(const Trial& a, const Trial& b) {
  const double width = b.t - a.t;
  if (!std::isfinite(b.value)) return a.t + 0.25 * width;
  double t = a.t + 0.5 * width;
  const double d1 = a.slope + b.slope - 3.0 * (a.value - b.value) / (a.t - b.t);
  const double under = d1 * d1 - a.slope * b.slope;
  if (under >= 0.0) {  // [NocedalWright2006, 3.59]
    const double d2 = std::sqrt(under);
    const double c = b.t - width * (b.slope + d2 - d1) / (b.slope - a.slope + 2.0 * d2);
    if (std::isfinite(c)) t = c;
  }
  return std::clamp(t, a.t + 0.1 * width, a.t + 0.9 * width);
}

/// Powers of two near the ranges: dividing by them is exact and makes the method take no notice of
/// units.
Vector scale_of(const Bounds& bounds) {
  return (bounds.upper - bounds.lower).unaryExpr([](double range) {
    return range > 0.0 && std::isfinite(range) ? std::exp2(std::round(std::log2(range))) : 1.0;
  });
}

class Search {
 public:
  Search(const Objective& objective, const Bounds& bounds, const MinimizerOptions& options,
         int max_evaluations)
      : objective_(objective),
        options_(options),
        evaluations_left_(max_evaluations),
        scale_(scale_of(bounds)),
        lower_(bounds.lower.cwiseQuotient(scale_)),
        upper_(bounds.upper.cwiseQuotient(scale_)),
        initial_(Vector::Zero(scale_.size())),
        memory_(scale_.size()) {
    if (options.initial_curvature > 0.0)
      initial_ = (options.initial_curvature * scale_.array().square()).inverse();
  }

  RunEnd from(const Vector& start) {
    now_ = evaluated(start.cwiseQuotient(scale_));
    if (!std::isfinite(now_.value)) return RunEnd::gave_up;
    first_value_ = now_.value;
    while (choose_direction()) {
      const Point old = now_;
      const LineEnd line = go_along_direction();
      if (line == LineEnd::budget) return RunEnd::budget;
      const bool goes_on = line == LineEnd::found ? !is_small_step(old) : is_lower_than(old);
      if (goes_on)
        memory_.add(now_.x - old.x, now_.gradient - old.gradient);
      else if (is_flat(now_))
        return RunEnd::converged;
      else if (memory_.empty())
        return RunEnd::gave_up;
      else
        memory_.clear();  // once more, straight down
    }
    return RunEnd::converged;
  }

 private:
  enum class LineEnd {
    found,  ///< a step that obeys the conditions
    none,   ///< what is left of the path promises less than the tolerance
    budget
  };

  Point evaluated(const Vector& x) {
    Point p{x.cwiseMax(lower_).cwiseMin(upper_), kInfinity, Vector::Zero(x.size())};
    --evaluations_left_;
    const double value = objective_(p.x.cwiseProduct(scale_), &p.gradient);
    if (std::isfinite(value)) p.value = value;
    p.gradient = p.gradient.cwiseProduct(scale_).eval();
    return p;
  }

  bool is_blocked(const Vector& x, Eigen::Index k, double step) const {
    return (x[k] <= lower_[k] && step <= 0.0) || (x[k] >= upper_[k] && step >= 0.0);
  }

  /// 1 for the coordinates of x that a step can move.
  Mask movable(const Vector& x, const Vector& step) const {
    Mask mask(x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) mask[k] = is_blocked(x, k, step[k]) ? 0.0 : 1.0;
    return mask;
  }

  bool goes_down(const Vector& step) const {
    return step.dot(now_.gradient) < -kFlat * step.norm() * now_.gradient.norm();
  }

  /// False where no direction inside the box goes down.
  bool choose_direction() {
    Mask moving = movable(now_.x, -now_.gradient);
    const Vector down = -(now_.gradient.array() * moving);
    if ((down.array() == 0.0).all()) return false;
    while (!memory_.empty()) {
      direction_ = memory_.times(down, moving, initial_);
      const Mask still = moving * movable(now_.x, direction_);
      if ((still == moving).all()) break;
      moving = still;
    }
    if (!memory_.empty() && goes_down(direction_)) return true;
    memory_.clear();
    direction_ = (initial_.array() > 0.0).select(initial_, 1.0).cwiseProduct(down);
    const double longest = direction_.cwiseAbs().maxCoeff();
    if (longest > kFirstStep || options_.initial_curvature <= 0.0)
      direction_ *= kFirstStep / longest;
    return true;
  }

  /// To a point that obeys the weak Wolfe conditions on the path bent by the bounds, by growing
  /// steps and cubic interpolation; where there is none, to the best point met.
  LineEnd go_along_direction() {
    const Point start = now_;
    Trial low{0.0, start.value, start.gradient.dot(direction_)}, high{kInfinity};
    const double slope = low.slope;
    double t = 1.0;
    for (int i = 0; i < kMaxTrials; ++i) {
      if (evaluations_left_ <= 0) return LineEnd::budget;
      Point next = evaluated(start.x + t * direction_);
      const Trial trial{t, next.value, slope_at(next)};
      const double most = start.value + kDecrease * start.gradient.dot(next.x - start.x) +
                          kNoise * std::abs(start.value);
      const bool fell = next.value <= most;
      if (next.value < now_.value) now_ = std::move(next);
      if (fell && trial.slope >= kCurvature * slope)
        return now_.value < start.value ? LineEnd::found : LineEnd::none;
      (fell ? low : high) = trial;
      t = std::isfinite(high.t) ? between(low, high) : 3.0 * low.t;
      if (std::isfinite(high.t) && -low.slope * (t - low.t) <= tolerance(start)) break;
    }
    return LineEnd::none;
  }

  double tolerance(const Point& p) const {
    return std::max(options_.relative_f_tolerance, kNoise) * std::abs(p.value);
  }
  bool is_lower_than(const Point& old) const { return old.value - now_.value > tolerance(old); }

  /// Whether what a first step promises is rounding; where steps are small and it is not, the
  /// objective has a kink or a gradient that is not its own.
  bool is_flat(const Point& p) const {
    const Vector down = p.gradient.array() * movable(p.x, -p.gradient);
    const double longest = down.cwiseAbs().maxCoeff();
    if (longest == 0.0) return true;
    const double size = std::max(std::abs(p.value), first_value_ - p.value);
    return kFirstStep / longest * down.squaredNorm() <= kFlatPromise * size;
  }

  /// Along the path, on which coordinates at their bounds no longer move.
  double slope_at(const Point& p) const {
    return (p.gradient.array() * direction_.array() * movable(p.x, direction_)).sum();
  }

  bool is_small_step(const Point& old) const {
    const double change = std::abs(old.value - now_.value);
    if (change <= options_.relative_f_tolerance * std::abs(now_.value)) return true;
    const Vector least = options_.relative_x_tolerance * now_.x.cwiseAbs() +
                         options_.absolute_x_tolerance * (upper_ - lower_);
    return ((now_.x - old.x).cwiseAbs().array() <= least.array()).all();
  }

  const Objective& objective_;
  const MinimizerOptions& options_;
  int evaluations_left_;
  Vector scale_, lower_, upper_;  // the box in units of the scale, as all points
  Vector initial_;                // of the inverse Hessian; 0: from the memory
  Memory memory_;
  Point now_;
  double first_value_ = 0.0;
  Vector direction_;
};

}  // namespace

RunEnd run_lbfgs(const Objective& objective, const Vector& start, const Bounds& bounds,
                 const MinimizerOptions& options, int max_evaluations) {
  return Search(objective, bounds, options, max_evaluations).from(start);
}

}  // namespace repose::opt

#include "repose/opt/propose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acquirer.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::opt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Points around the best known ones that join the candidates.
constexpr int kIncumbents = 5;
constexpr int kPerturbations = 20;
/// A whole coordinate of these is any of its values with this probability.
constexpr double kAnyValue = 0.25;
/// Quasi-random points of the box looked at for each candidate that obeys the constraints.
constexpr Eigen::Index kTries = 200;
/// Best visited points of which one is repeated deliberately.
constexpr Eigen::Index kContenders = 3;

void check(std::span<const Surrogate> models, const FeasibleSet& set, int q,
           const ProposeOptions& o) {
  if (models.empty()) throw InputError("no surrogate to propose points with");
  check_feasible_set(set);
  if (q < 1) throw InputError(fmt::format("a batch of {} points; ask for at least 1", q));
  if (o.candidates < 1 || o.polished < 0 || o.draws < 1)
    throw InputError(
        fmt::format("candidates = {}, polished = {}, draws = {}; they must be at "
                    "least 1, 0 and 1",
                    o.candidates, o.polished, o.draws));
  if (!(o.minimum_distance >= 0.0) || !(o.failed_distance >= 0.0) || !(o.kappa >= 0.0))
    throw InputError(
        fmt::format("minimum_distance = {}, failed_distance = {}, kappa = {}; none "
                    "may be negative",
                    o.minimum_distance, o.failed_distance, o.kappa));
  const Eigen::Index dimension = set.bounds.lower.size();
  const auto check_points = [&](const Matrix& points, const char* name) {
    if (points.rows() > 0 && points.cols() != dimension)
      throw InputError(fmt::format("{} points have {} coordinates; the space has {}", name,
                                   points.cols(), dimension));
    if (!points.allFinite())
      throw InputError(fmt::format("{} points hold a value that is not finite", name));
  };
  check_points(o.visited, "visited");
  check_points(o.pending, "pending");
  check_points(o.failed, "failed");
  if (o.repeats == Repeats::deliberate && o.acquisition == Acquisition::lower_confidence_bound)
    throw InputError(
        "deliberate repeats weigh what they tell against expected improvement; the lower "
        "confidence bound has none: choose expected improvement, or repeats that are only allowed");
  const bool joint =
      o.repeats == Repeats::deliberate || o.acquisition == Acquisition::noisy_expected_improvement;
  for (const Surrogate& model : models)
    if (joint && !model.has_covariance())
      throw InputError(
          "noisy expected improvement and deliberate repeats need a surrogate that gives "
          "covariances, such as a Gaussian process");
}

bool is_whole(const FeasibleSet& set, Eigen::Index k) {
  return std::find(set.whole.begin(), set.whole.end(), k) != set.whole.end();
}

/// One step of the batch: everything that is fixed while a single point is sought.
class Search {
 public:
  Search(const BelievedModels& models, const Goal& goal, const FeasibleSet& set,
         const ProposeOptions& options, std::uint64_t seed)
      : models_(models),
        goal_(goal),
        set_(set),
        options_(options),
        seed_(seed),
        bounds_(narrowed_bounds(set)),
        range_((set.bounds.upper - set.bounds.lower).cwiseMax(1e-300)),
        acquirer_(models, goal, options, seed) {}

  struct Found {
    Vector x;
    double merit;
    bool repeat = false;
  };

  Found best_point() {
    const Matrix points = candidates();
    const std::vector<Predictions> predicted = models_.predict_rows(points);
    if (acquirer_.incumbent_means().empty()) acquirer_.beat_the_best_of(predicted);
    std::vector<double> loss = acquirer_.values(points, predicted);
    for (std::size_t i = 0; i < loss.size(); ++i)
      loss[i] = allowed(points.row(static_cast<Eigen::Index>(i))) && !std::isnan(loss[i])
                    ? -loss[i]
                    : kInfinity;
    const std::vector<Eigen::Index> order = ascending(loss);
    const double best_loss = loss[static_cast<std::size_t>(order[0])];
    const Found found = std::isfinite(best_loss)
                            ? polish(points, order, best_loss)
                            : Found{most_uncertain(points, predicted), -kInfinity};
    return options_.repeats == Repeats::deliberate ? repeat_or(found) : found;
  }

 private:
  /// Largest coordinate difference to the nearest of `points`, of the range.
  double distance_to(const Matrix& points, const Vector& x) const {
    double nearest = kInfinity;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      nearest = std::min(
          nearest, (points.row(i).transpose() - x).cwiseQuotient(range_).cwiseAbs().maxCoeff());
    return nearest;
  }

  bool allowed(const Vector& x) const {
    if (distance_to(options_.failed, x) < options_.failed_distance) return false;
    return options_.repeats == Repeats::allow ||
           distance_to(models_.known(), x) >= options_.minimum_distance;
  }

  /// Quasi-random points, and normal steps of three sizes from the best known points.
  Matrix candidates() const {
    const Matrix spread = spread_candidates();
    const std::vector<Eigen::Index> order = ascending(acquirer_.incumbent_means());
    const auto centers =
        std::min<Eigen::Index>(kIncumbents, static_cast<Eigen::Index>(order.size()));
    Matrix points(spread.rows() + centers * kPerturbations, spread.cols());
    points.topRows(spread.rows()) = spread;
    Eigen::Index rows = spread.rows();
    RandomStream random(seed_, 1);
    for (int step = 0; step < centers * kPerturbations; ++step) {
      const Vector center =
          models_.incumbents().row(order[static_cast<std::size_t>(step / kPerturbations)]);
      const Vector x = perturbed(center, 0.1 * std::pow(0.2, step % 3), random);
      if (violation(x, set_) == 0.0) points.row(rows++) = x;
    }
    points.conservativeResize(rows, Eigen::NoChange);
    return points;
  }

  Matrix spread_candidates() const {
    const Eigen::Index d = range_.size();
    const Eigen::Index wanted = options_.candidates;
    const Eigen::Index tries = set_.inequalities.empty() ? wanted : kTries * wanted;
    Matrix points(wanted, d);
    Eigen::Index rows = 0;
    for (Eigen::Index begin = 0; begin < tries && rows < wanted; begin += wanted) {
      const Matrix unit = scrambled_uniforms(
          wanted, d, begin == 0 ? seed_ : derive_seed(seed_, static_cast<std::uint64_t>(begin)));
      for (Eigen::Index i = 0; i < wanted && rows < wanted; ++i) {
        const Vector x = at_unit(unit.row(i));
        if (violation(x, set_) == 0.0) points.row(rows++) = x;
      }
    }
    if (rows == 0)
      throw InputError(fmt::format(
          "none of {} points of the box obeys the constraints; they leave too little of it",
          tries));
    points.conservativeResize(rows, Eigen::NoChange);
    return points;
  }

  /// Whole coordinates have values of equal shares.
  Vector at_unit(const Vector& unit) const {
    Vector x = bounds_.lower + unit.cwiseProduct(bounds_.upper - bounds_.lower);
    for (const Eigen::Index k : set_.whole) {
      const double first = std::ceil(bounds_.lower[k]);
      const double values = std::floor(bounds_.upper[k]) - first + 1.0;
      x[k] = first + std::min(std::floor(unit[k] * values), values - 1.0);
    }
    return rounded(x, set_);
  }

  Vector perturbed(const Vector& center, double size, RandomStream& random) const {
    Vector x = center;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const double step = size * random.normal();
      if (is_whole(set_, k) && random.uniform() < kAnyValue)
        x[k] = bounds_.lower[k] + random.uniform() * (bounds_.upper[k] - bounds_.lower[k]);
      else
        x[k] += step * range_[k];
    }
    return rounded(x, set_);
  }

  Found polish(const Matrix& points, const std::vector<Eigen::Index>& order,
               double best_loss) const {
    Found best{points.row(order[0]), -best_loss};
    const auto starts = std::min<Eigen::Index>(options_.polished, points.rows());
    if (options_.polish_evaluations < 1) return best;
    std::vector<Minimum> minima(static_cast<std::size_t>(starts));
    parallel_for(minima.size(), options_.threads,
                 [&](std::size_t i) { minima[i] = climb(points.row(order[i])); });
    for (const Minimum& minimum : minima)
      if (-minimum.value > best.merit) best = {minimum.x, -minimum.value};
    return best;
  }

  /// From `start`, its whole coordinates kept. Methods without gradient take no constraints: they
  /// turn away from points that break one.
  Minimum climb(const Vector& start) const {
    FeasibleSet set = set_;
    set.whole.clear();
    for (const Eigen::Index k : set_.whole) set.bounds.lower[k] = set.bounds.upper[k] = start[k];
    std::erase_if(set.ties, [this](const LinearTie& tie) { return is_whole(set_, tie.follower); });
    std::erase_if(set.inequalities, [&set](const LinearInequality& inequality) {
      const auto free = set.bounds.lower.array() < set.bounds.upper.array();
      return (free && inequality.coefficients.array() != 0.0).count() == 0;
    });
    Algorithm algorithm = Algorithm::lbfgs;
    if (!acquirer_.has_gradient()) {
      algorithm = Algorithm::bobyqa;
      set.inequalities.clear();
    } else if (!set.inequalities.empty()) {
      algorithm = Algorithm::slsqp;
    }
    const bool turns_away = !acquirer_.has_gradient() && !set_.inequalities.empty();
    const Objective loss = [this, turns_away](const Vector& x, Vector* gradient) {
      if (!allowed(x) || (turns_away && violation(x, set_) > 0.0)) return kInfinity;
      if (gradient == nullptr) return -acquirer_.value(x);
      const double value = acquirer_.value(x, *gradient);
      *gradient = -*gradient;
      return -value;
    };
    return minimize(loss, start, set,
                    {.algorithm = algorithm,
                     .relative_x_tolerance = 1e-5,
                     .absolute_x_tolerance = 1e-5,
                     .relative_f_tolerance = 1e-10,
                     .max_evaluations = options_.polish_evaluations,
                     .initial_step = 0.05});
  }

  /// Where no improvement can be expected anywhere: the allowed candidate about which least is
  /// known, the farthest from all known and failed points if that does not decide or none is
  /// allowed.
  Vector most_uncertain(const Matrix& points, const std::vector<Predictions>& predicted) const {
    Eigen::Index best = 0;
    std::pair<double, double> most{-1.0, -1.0};
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const std::span<const Gaussian> p = predicted[static_cast<std::size_t>(i)];
      const double variance = goal_.objective(p).variance;
      const std::pair score{allowed(points.row(i)) ? variance : -1.0,
                            std::min(distance_to(models_.known(), points.row(i)),
                                     distance_to(options_.failed, points.row(i)))};
      if (score > most) {
        most = score;
        best = i;
      }
    }
    return points.row(best);
  }

  /// The one of the best visited points with the largest P(best) x variance, if knowing their order
  /// is worth more than `found`: E(f_i - min f), i the one with the smallest mean.
  Found repeat_or(const Found& found) const {
    const Matrix visited = rows_in(set_, options_.visited);
    if (visited.rows() == 0) return found;
    const Matrix contenders =
        promising_rows(visited, models_.predict_rows(visited), goal_, kContenders);
    const std::vector<Predictions> predicted = models_.predict_rows(contenders);
    const Matrix drawn =
        JointDraws(models_.models(), contenders, options_.draws, derive_seed(seed_, 3))
            .objective(goal_);
    Vector best_share = Vector::Zero(contenders.rows());  // of the draws
    for (const auto& draw : drawn.colwise()) {
      Eigen::Index best = 0;
      draw.minCoeff(&best);
      best_share[best] += 1.0 / static_cast<double>(drawn.cols());
    }
    Vector mean(contenders.rows());
    Vector doubt(contenders.rows());  // variance where the point may be the best
    for (Eigen::Index i = 0; i < contenders.rows(); ++i) {
      const std::span<const Gaussian> p = predicted[static_cast<std::size_t>(i)];
      const Gaussian objective = goal_.objective(p);
      mean[i] = objective.mean;
      doubt[i] = best_share[i] * objective.variance;
    }
    Eigen::Index smallest = 0;
    Eigen::Index repeated = 0;
    mean.minCoeff(&smallest);
    doubt.maxCoeff(&repeated);
    const double worth =
        (drawn.row(smallest) - drawn.colwise().minCoeff()).mean();  // of knowing which is best
    if (!(worth > 0.0) || std::log(worth) <= found.merit) return found;
    return {contenders.row(repeated), std::log(worth), true};
  }

  const BelievedModels& models_;
  const Goal& goal_;
  const FeasibleSet& set_;
  const ProposeOptions& options_;
  std::uint64_t seed_;
  Bounds bounds_;
  Vector range_;
  Acquirer acquirer_;
};

Proposal propose(std::span<const Surrogate> models, std::span<const Target> targets,
                 const FeasibleSet& set, int q, const ProposeOptions& options) {
  check(models, set, q, options);
  const Goal goal(targets);
  BelievedModels believed(models, goal, set, options);
  Proposal proposal;
  proposal.points.resize(q, set.bounds.lower.size());
  for (int i = 0; i < q; ++i) {
    Search search(believed, goal, set, options,
                  derive_seed(options.seed, static_cast<std::uint64_t>(i)));
    const auto [x, merit, repeat] = search.best_point();
    proposal.points.row(i) = x;
    const Predictions predicted = believed.predict(x);
    proposal.predicted.push_back(goal.objective(std::span<const Gaussian>(predicted)));
    proposal.merit.push_back(merit);
    proposal.repeat.push_back(repeat);
    if (i + 1 < q) believed.believe(x);
  }
  return proposal;
}

}  // namespace

const char* to_string(Acquisition acquisition) {
  constexpr const char* kNames[] = {"ei", "nei", "lcb"};
  return kNames[static_cast<int>(acquisition)];
}

const char* to_string(Belief belief) {
  constexpr const char* kNames[] = {"kriging", "best-lie", "mean-lie", "worst-lie"};
  return kNames[static_cast<int>(belief)];
}

const char* to_string(Repeats repeats) {
  constexpr const char* kNames[] = {"avoid", "allow", "deliberate"};
  return kNames[static_cast<int>(repeats)];
}

Proposal propose_batch(const Surrogate& objective, const FeasibleSet& set, int q,
                       const ProposeOptions& options) {
  return propose({&objective, 1}, {}, set, q, options);
}

Proposal propose_batch(std::span<const Surrogate> kpis, std::span<const Target> targets,
                       const FeasibleSet& set, int q, const ProposeOptions& options) {
  check_targets(targets);
  if (kpis.size() != targets.size())
    throw InputError(fmt::format("{} surrogates for {} targets; there must be one for each",
                                 kpis.size(), targets.size()));
  return propose(kpis, targets, set, q, options);
}

}  // namespace repose::opt

#include "repose/opt/propose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"
#include "repose/opt/acquisition.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::opt {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Points around the best known ones that join the candidates.
constexpr int kIncumbents = 5;
constexpr int kPerturbations = 20;

using Predictions = std::vector<Gaussian>;  // one of each surrogate, at one point

/// What the proposals are for: the objective and how much a point promises to lower it.
struct Merit {
  std::function<Gaussian(std::span<const Gaussian>)> objective;
  std::function<double(std::span<const Gaussian>, double best)> log_improvement;
};

/// The surrogates as they are believed to be after the points chosen so far.
class Belief {
 public:
  Belief(std::span<const Surrogate> models, Eigen::Index dimension, const ProposeOptions& options)
      : models_(models.begin(), models.end()), known_(0, dimension), threads_(options.threads) {
    append_rows(options.visited);
    for (Eigen::Index i = 0; i < options.pending.rows(); ++i) believe(options.pending.row(i));
  }

  const Matrix& known() const { return known_; }

  Predictions predict(const Vector& x) const {
    Predictions p;
    p.reserve(models_.size());
    for (const Surrogate& model : models_) p.push_back(model.predict(x));
    return p;
  }

  std::vector<Predictions> predict_rows(const Matrix& rows) const {
    std::vector<Predictions> of_model(models_.size());
    parallel_for(models_.size(), threads_,
                 [&](std::size_t j) { of_model[j] = models_[j].predict_rows(rows); });
    std::vector<Predictions> of_row(static_cast<std::size_t>(rows.rows()));
    for (std::size_t i = 0; i < of_row.size(); ++i)
      for (const Predictions& p : of_model) of_row[i].push_back(p[i]);
    return of_row;
  }

  /// Takes the posterior means at x for its values.
  void believe(const Vector& x) {
    for (Surrogate& model : models_) model = model.condition_on(x, model.predict(x).mean);
    append_rows(x.transpose());
  }

 private:
  void append_rows(const Matrix& rows) {
    if (rows.rows() == 0) return;
    Matrix all(known_.rows() + rows.rows(), known_.cols());
    all << known_, rows;
    known_ = std::move(all);
  }

  std::vector<Surrogate> models_;
  Matrix known_;
  unsigned threads_;
};

void check(std::size_t surrogates, Eigen::Index dimension, int q, const ProposeOptions& o) {
  if (surrogates == 0) throw InputError("no surrogate to propose points with");
  if (dimension < 1)
    throw InputError(fmt::format("{} dimensions; there must be at least 1", dimension));
  if (q < 1) throw InputError(fmt::format("a batch of {} points; ask for at least 1", q));
  if (o.candidates < 1 || o.polished < 0 || o.draws < 1 || !(o.minimum_distance >= 0.0) ||
      !(o.failed_distance >= 0.0))
    throw InputError(
        fmt::format("candidates = {}, polished = {}, draws = {}, minimum_distance = {}; they "
                    "must be at least 1, 0, 1 and 0",
                    o.candidates, o.polished, o.draws, o.minimum_distance));
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
}

/// Largest coordinate difference to the nearest known point.
double distance_to(const Matrix& known, const Vector& x) {
  double nearest = kInfinity;
  for (Eigen::Index i = 0; i < known.rows(); ++i)
    nearest = std::min(nearest, (known.row(i).transpose() - x).cwiseAbs().maxCoeff());
  return nearest;
}

std::vector<Eigen::Index> order_of(const std::vector<double>& values) {
  std::vector<Eigen::Index> order(values.size());
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return values[static_cast<std::size_t>(a)] < values[static_cast<std::size_t>(b)];
  });
  return order;
}

/// One step of the batch: everything that is fixed while a single point is sought.
class Search {
 public:
  Search(const Belief& belief, const Merit& merit, const ProposeOptions& options,
         std::uint64_t seed)
      : belief_(belief), merit_(merit), options_(options), seed_(seed) {
    const std::vector<Predictions> at_known = belief.predict_rows(belief.known());
    for (const Predictions& p : at_known) known_mean_.push_back(merit.objective(p).mean);
    if (!known_mean_.empty()) best_ = *std::min_element(known_mean_.begin(), known_mean_.end());
  }

  /// The point of largest log improvement, with its value.
  std::pair<Vector, double> best_point() {
    const Matrix points = candidates();
    const std::vector<Predictions> predicted = belief_.predict_rows(points);
    if (known_mean_.empty())  // nothing is known: improve on the best that is expected anywhere
      for (const Predictions& p : predicted) best_ = std::min(best_, merit_.objective(p).mean);
    std::vector<double> loss(predicted.size());
    for (std::size_t i = 0; i < loss.size(); ++i)
      loss[i] = -value(points.row(static_cast<Eigen::Index>(i)), predicted[i]);
    const std::vector<Eigen::Index> order = order_of(loss);
    const double best_loss = loss[static_cast<std::size_t>(order[0])];
    if (!std::isfinite(best_loss)) return {most_uncertain(points, predicted), -kInfinity};
    return polish(points, order, best_loss);
  }

 private:
  bool allowed(const Vector& x) const {
    if (distance_to(options_.failed, x) < options_.failed_distance) return false;
    return options_.repeats == Repeats::allow ||
           distance_to(belief_.known(), x) >= options_.minimum_distance;
  }

  double value(const Vector& x, std::span<const Gaussian> predicted) const {
    return allowed(x) ? merit_.log_improvement(predicted, best_) : -kInfinity;
  }

  /// Quasi-random points, and normal steps of three sizes from the best known points.
  Matrix candidates() const {
    const Eigen::Index d = belief_.known().cols();
    const Matrix spread = scrambled_uniforms(options_.candidates, d, seed_);
    const std::vector<Eigen::Index> order = order_of(known_mean_);
    const auto centers =
        std::min<Eigen::Index>(kIncumbents, static_cast<Eigen::Index>(order.size()));
    Matrix points(spread.rows() + centers * kPerturbations, d);
    points.topRows(spread.rows()) = spread;
    RandomStream random(seed_, 1);
    for (Eigen::Index i = spread.rows(); i < points.rows(); ++i) {
      const Eigen::Index step = i - spread.rows();
      const Eigen::Index center = order[static_cast<std::size_t>(step / kPerturbations)];
      const double size = 0.1 * std::pow(0.2, static_cast<double>(step % 3));
      for (Eigen::Index k = 0; k < d; ++k)
        points(i, k) = std::clamp(belief_.known()(center, k) + size * random.normal(), 0.0, 1.0);
    }
    return points;
  }

  std::pair<Vector, double> polish(const Matrix& points, const std::vector<Eigen::Index>& order,
                                   double best_loss) const {
    std::pair<Vector, double> best{points.row(order[0]), -best_loss};
    const auto starts = std::min<Eigen::Index>(options_.polished, points.rows());
    if (starts == 0 || options_.polish_evaluations < 1) return best;
    const Matrix from =
        points(std::vector<Eigen::Index>(order.begin(), order.begin() + starts), Eigen::all);
    const NloptMinimizer method{{.algorithm = Algorithm::bobyqa,
                                 .relative_x_tolerance = 1e-5,
                                 .absolute_x_tolerance = 1e-5,
                                 .relative_f_tolerance = 1e-10,
                                 .max_evaluations = options_.polish_evaluations,
                                 .initial_step = 0.05}};
    const Objective loss = [this](const Vector& x, Vector*) {
      return -value(x, belief_.predict(x));
    };
    const Minimum minimum =
        multi_start(loss, from, unit_cube(points.cols()), method, options_.threads);
    if (minimum.value < best_loss) best = {minimum.x, -minimum.value};
    return best;
  }

  /// Where no improvement can be expected anywhere: the allowed candidate about which least is
  /// known, the farthest from all known points if that does not decide.
  Vector most_uncertain(const Matrix& points, const std::vector<Predictions>& predicted) const {
    Eigen::Index best = 0;
    std::pair<double, double> most{-1.0, -1.0};
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double variance = merit_.objective(predicted[static_cast<std::size_t>(i)]).variance;
      const std::pair score{allowed(points.row(i)) ? variance : -1.0,
                            distance_to(belief_.known(), points.row(i))};
      if (score > most) {
        most = score;
        best = i;
      }
    }
    return points.row(best);
  }

  const Belief& belief_;
  const Merit& merit_;
  const ProposeOptions& options_;
  std::uint64_t seed_;
  std::vector<double> known_mean_;
  double best_ = kInfinity;
};

Proposal propose(std::span<const Surrogate> models, const Merit& merit, Eigen::Index dimension,
                 int q, const ProposeOptions& options) {
  check(models.size(), dimension, q, options);
  Belief belief(models, dimension, options);
  Proposal proposal;
  proposal.points.resize(q, dimension);
  for (int i = 0; i < q; ++i) {
    Search search(belief, merit, options, derive_seed(options.seed, static_cast<std::uint64_t>(i)));
    const auto [x, log_improvement] = search.best_point();
    proposal.points.row(i) = x;
    proposal.predicted.push_back(merit.objective(belief.predict(x)));
    proposal.log_improvement.push_back(log_improvement);
    if (i + 1 < q) belief.believe(x);
  }
  return proposal;
}

}  // namespace

Proposal propose_batch(const Surrogate& objective, Eigen::Index dimension, int q,
                       const ProposeOptions& options) {
  const Merit merit{[](std::span<const Gaussian> p) { return p[0]; },
                    [](std::span<const Gaussian> p, double best) {
                      return log_expected_improvement(p[0], best);
                    }};
  return propose({&objective, 1}, merit, dimension, q, options);
}

Proposal propose_batch(std::span<const Surrogate> kpis, std::span<const Target> targets,
                       Eigen::Index dimension, int q, const ProposeOptions& options) {
  check_targets(targets);
  if (kpis.size() != targets.size())
    throw InputError(fmt::format("{} surrogates for {} targets; there must be one for each",
                                 kpis.size(), targets.size()));
  if (options.draws < 1) throw InputError("draws must be at least 1");
  const Matrix normals =
      scrambled_normals(options.draws, static_cast<Eigen::Index>(kpis.size()), options.seed);
  const Merit merit{[targets](std::span<const Gaussian> p) { return weighted_error(p, targets); },
                    [targets, &normals](std::span<const Gaussian> p, double best) {
                      return log_composite_expected_improvement(p, targets, best, normals);
                    }};
  return propose(kpis, merit, dimension, q, options);
}

}  // namespace repose::opt

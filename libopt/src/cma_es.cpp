// CMA-ES after the tutorial [Hansen2016]; equation numbers are its.
#include "repose/opt/cma_es.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "population.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::opt {
namespace {

void check(const CmaEsOptions& o) {
  const auto require = [](bool right, const char* name, double value, const char* allowed) {
    if (!right)
      throw InputError(fmt::format("CMA-ES: {} is {}; it must be {}", name, value, allowed));
  };
  require(o.population == 0 || o.population >= 4, "population", o.population, "0 or at least 4");
  require(o.initial_step > 0.0 && std::isfinite(o.initial_step), "initial_step", o.initial_step,
          "above 0");
  require(o.restarts >= 0, "restarts", o.restarts, "0 or more");
  require(o.max_points >= 1, "max_points", static_cast<double>(o.max_points), "at least 1");
  require(o.function_tolerance >= 0.0, "function_tolerance", o.function_tolerance, "0 or more");
  require(o.x_tolerance >= 0.0, "x_tolerance", o.x_tolerance, "0 or more");
}

/// The constants that follow from dimension and population.
struct Strategy {
  Strategy(Eigen::Index dimension, int lambda) : weights(lambda) {
    const auto d = static_cast<double>(dimension);
    const int mu = lambda / 2;
    for (int i = 0; i < lambda; ++i)
      weights[i] = std::log(0.5 * (lambda + 1.0)) - std::log(i + 1.0);  // (49)
    const Vector good = weights.head(mu), bad = weights.tail(lambda - mu);
    const double mu_eff_bad =
        bad.squaredNorm() > 0.0 ? bad.sum() * bad.sum() / bad.squaredNorm() : 0.0;
    mu_eff = good.sum() * good.sum() / good.squaredNorm();
    c_path = (4.0 + mu_eff / d) / (d + 4.0 + 2.0 * mu_eff / d);  // (56)
    c_step = (mu_eff + 2.0) / (d + mu_eff + 5.0);                // (55)
    c_one = 2.0 / ((d + 1.3) * (d + 1.3) + mu_eff);              // (57)
    c_mu = std::min(1.0 - c_one, 2.0 * (0.25 + mu_eff + 1.0 / mu_eff - 2.0) /
                                     ((d + 2.0) * (d + 2.0) + mu_eff));  // (58)
    damping = 1.0 + 2.0 * std::max(0.0, std::sqrt((mu_eff - 1.0) / (d + 1.0)) - 1.0) + c_step;
    expected_norm = std::sqrt(d) * (1.0 - 1.0 / (4.0 * d) + 1.0 / (21.0 * d * d));
    const double most = std::min({1.0 + c_one / c_mu,                       // (50)
                                  1.0 + 2.0 * mu_eff_bad / (mu_eff + 2.0),  // (51)
                                  (1.0 - c_one - c_mu) / (d * c_mu)});      // (52)
    for (int i = 0; i < lambda; ++i)                                        // (53)
      weights[i] = i < mu ? weights[i] / good.sum() : most * weights[i] / -bad.sum();
    parents = mu;
  }
  Vector weights;  ///< positive for the parents, which sum to 1, else negative
  int parents = 0;
  double mu_eff = 0.0, c_path = 0.0, c_step = 0.0, c_one = 0.0, c_mu = 0.0;
  double damping = 1.0, expected_norm = 1.0;
};

/// Into [0, 1], as between mirrors.
double reflected(double x) {
  const double folded = std::abs(std::remainder(x, 2.0));
  return std::min(folded, 1.0);
}

/// One run: the distribution and how it learns.
class Run {
 public:
  Run(const BatchObjective& objective, const GenomeSpace& space, const CmaEsOptions& options,
      int population, Vector mean, RandomStream& random, std::int64_t& points,
      EvolutionResult& result)
      : objective_(objective),
        space_(space),
        options_(options),
        strategy_(mean.size(), population),
        population_(population),
        random_(random),
        points_(points),
        result_(result),
        mean_(std::move(mean)),
        covariance_(Matrix::Identity(mean_.size(), mean_.size())),
        path_(Vector::Zero(mean_.size())),
        step_path_(path_),
        step_(options.initial_step) {
    decompose();
  }

  Termination go() {
    while (points_ < options_.max_points) {
      const Matrix steps = sample();
      const Population p = evaluated(objective_, genomes_of(steps), space_, result_);
      points_ += population_;
      ++result_.generations;
      ++generation_;
      keep_best(p, space_, result_);
      const std::vector<Eigen::Index> order = ranking(p);
      adapt(steps, order);
      remember(p, order);
      if (has_converged(p, order)) return Termination::converged;
      if (is_degenerate()) return Termination::round_off;
    }
    return Termination::budget;
  }

 private:
  /// Rows are steps y ~ N(0, C), before the step size.
  Matrix sample() {
    Matrix steps(population_, mean_.size());
    for (Eigen::Index i = 0; i < steps.rows(); ++i) {
      Vector z(mean_.size());
      for (double& value : z) value = random_.normal();
      steps.row(i) = axes_ * lengths_.cwiseProduct(z);
    }
    return steps;
  }

  Matrix genomes_of(const Matrix& steps) const {
    const Matrix genomes = (step_ * steps).rowwise() + mean_.transpose();
    return genomes.unaryExpr(&reflected);
  }

  void adapt(const Matrix& steps, const std::vector<Eigen::Index>& order) {
    const auto d = static_cast<double>(mean_.size());
    const Strategy& s = strategy_;
    Vector mean_step = Vector::Zero(mean_.size());
    for (int i = 0; i < s.parents; ++i)
      mean_step += s.weights[i] * steps.row(order[static_cast<std::size_t>(i)]).transpose();
    mean_ += step_ * mean_step;  // (42)
    step_path_ = (1.0 - s.c_step) * step_path_ +
                 std::sqrt(s.c_step * (2.0 - s.c_step) * s.mu_eff) * whitened(mean_step);  // (43)
    const double decay = std::sqrt(1.0 - std::pow(1.0 - s.c_step, 2.0 * generation_));
    const bool steady = step_path_.norm() / decay < (1.4 + 2.0 / (d + 1.0)) * s.expected_norm;
    path_ = (1.0 - s.c_path) * path_;
    if (steady) path_ += std::sqrt(s.c_path * (2.0 - s.c_path) * s.mu_eff) * mean_step;  // (45)

    double weight_sum = 0.0;
    Matrix update = s.c_one * path_ * path_.transpose();
    for (int i = 0; i < population_; ++i) {
      const Vector y = steps.row(order[static_cast<std::size_t>(i)]);
      double weight = s.weights[i];
      weight_sum += weight;
      if (weight < 0.0) weight *= d / std::max(whitened(y).squaredNorm(), 1e-300);  // (46)
      update += s.c_mu * weight * y * y.transpose();
    }
    const double lost = steady ? 0.0 : s.c_path * (2.0 - s.c_path);
    covariance_ *= 1.0 + s.c_one * lost - s.c_one - s.c_mu * weight_sum;  // (47)
    covariance_ += update;
    step_ *= std::exp(
        std::min(1.0, s.c_step / s.damping * (step_path_.norm() / s.expected_norm - 1.0)));  // (44)
    decompose();
    keep_whole_coordinates_moving();
  }

  Vector whitened(const Vector& y) const {
    return axes_ * (axes_.transpose() * y).cwiseQuotient(lengths_);
  }

  void decompose() {
    covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(covariance_);
    axes_ = solver.eigenvectors();
    lengths_ = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  }

  void keep_whole_coordinates_moving() {
    bool changed = false;
    for (const Eigen::Index k : space_.whole()) {
      const double range = space_.range(k);
      if (!(range > 0.0)) continue;
      const double least = 0.2 / range / step_;
      if (covariance_(k, k) >= least * least) continue;
      covariance_(k, k) = least * least;
      changed = true;
    }
    if (changed) decompose();
  }

  void remember(const Population& p, const std::vector<Eigen::Index>& order) {
    recent_.push_back(p.values[order.front()]);
    const auto window = static_cast<std::size_t>(
        10.0 + std::ceil(30.0 * static_cast<double>(mean_.size()) / population_));
    if (recent_.size() > window) recent_.pop_front();
    window_is_full_ = recent_.size() == window;
  }

  bool has_converged(const Population& p, const std::vector<Eigen::Index>& order) const {
    const Vector deviations = step_ * covariance_.diagonal().cwiseSqrt();
    if (space_.whole().empty() && deviations.maxCoeff() < options_.x_tolerance) return true;
    if (!window_is_full_) return false;
    const auto [least, most] = std::minmax_element(recent_.begin(), recent_.end());
    const double worst = p.values[order[order.size() / 2]];
    return std::isfinite(*most) && *most - *least <= options_.function_tolerance &&
           worst - p.values[order.front()] <= options_.function_tolerance;
  }

  bool is_degenerate() const {
    const double least = lengths_.minCoeff(), most = lengths_.maxCoeff();
    return !(least > 1e-7 * most) || !std::isfinite(step_) || step_ * most > 1e4;
  }

  const BatchObjective& objective_;
  const GenomeSpace& space_;
  const CmaEsOptions& options_;
  Strategy strategy_;
  int population_;
  RandomStream& random_;
  std::int64_t& points_;
  EvolutionResult& result_;
  Vector mean_;
  Matrix covariance_, axes_;
  Vector lengths_;  // of the axes, square roots of eigenvalues
  Vector path_, step_path_;
  double step_;
  int generation_ = 0;
  std::deque<double> recent_;
  bool window_is_full_ = false;
};

}  // namespace

EvolutionResult minimize_cma_es(const BatchObjective& objective, const FeasibleSet& set,
                                const CmaEsOptions& options) {
  check_feasible_set(set);
  check(options);
  const GenomeSpace space(set);
  const Eigen::Index d = space.size();
  RandomStream random(options.seed);
  EvolutionResult result;
  result.value = std::numeric_limits<double>::infinity();
  int population = options.population > 0
                       ? options.population
                       : 4 + static_cast<int>(3.0 * std::log(static_cast<double>(d)));
  Termination last = Termination::budget;
  int runs = 0;
  std::int64_t points = 0;
  for (; runs <= options.restarts && points < options.max_points; ++runs) {
    Vector mean = Vector::Constant(d, 0.5);
    if (runs > 0)
      for (double& value : mean) value = random.uniform();
    last = Run(objective, space, options, population, std::move(mean), random, points, result).go();
    population *= 2;
  }
  result.termination = std::isfinite(result.value) ? last : Termination::failed;
  result.message =
      result.termination == Termination::failed
          ? fmt::format("no finite value in {} generations", result.generations)
          : fmt::format("{} run{}, {} evaluations", runs, runs == 1 ? "" : "s", result.evaluations);
  return result;
}

}  // namespace repose::opt

#include "repose/opt/genetic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::opt {
namespace {

/// Genomes are rows in the unit cube, sorted by value, best first.
struct Population {
  Matrix genomes;
  Vector values;
};

void check(const GeneticOptions& o) {
  const auto fraction = [](double p, const char* name) {
    if (!(p >= 0.0 && p <= 1.0))
      throw InputError(fmt::format("genetic algorithm: {} is {}; it must be in [0, 1]", name, p));
  };
  const auto at_least = [](double value, double least, const char* name) {
    if (!(value >= least))
      throw InputError(
          fmt::format("genetic algorithm: {} is {}; it must be at least {}", name, value, least));
  };
  fraction(o.crossover_probability, "crossover_probability");
  fraction(o.mutation_probability, "mutation_probability");
  fraction(o.elite_fraction, "elite_fraction");
  at_least(o.population, 4, "population");
  at_least(o.max_generations, 1, "max_generations");
  at_least(o.stall_generations, 1, "stall_generations");
  at_least(o.tournament, 1, "tournament");
  at_least(o.function_tolerance, 0.0, "function_tolerance");
  at_least(o.crossover_index, 0.0, "crossover_index");
  at_least(o.mutation_index, 0.0, "mutation_index");
}

Eigen::Index elite_count(const GeneticOptions& o) {
  return std::min<Eigen::Index>(
      o.population - 2, static_cast<Eigen::Index>(std::ceil(o.elite_fraction * o.population)));
}

Matrix natural(const Matrix& genomes, const Bounds& bounds) {
  Matrix x = genomes;
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    x.col(k) = (bounds.lower[k] + x.col(k).array() * (bounds.upper[k] - bounds.lower[k]))
                   .max(bounds.lower[k])
                   .min(bounds.upper[k]);
  return x;
}

Vector evaluate(const BatchObjective& objective, const Matrix& genomes, const Bounds& bounds) {
  Vector values = objective(natural(genomes, bounds));
  if (values.size() != genomes.rows())
    throw InputError(fmt::format("a batch objective returned {} values for {} points",
                                 values.size(), genomes.rows()));
  for (double& v : values)
    if (!std::isfinite(v)) v = std::numeric_limits<double>::infinity();
  return values;
}

void sort_by_value(Population& p) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(p.values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return p.values[a] < p.values[b]; });
  const Matrix genomes = p.genomes(order, Eigen::all);
  const Vector values = p.values(order);
  p = {genomes, values};
}

/// The best of `size` random individuals; of a sorted population that is the smallest index.
Eigen::Index tournament(const Population& p, int size, RandomStream& random) {
  const auto n = static_cast<std::uint64_t>(p.values.size());
  std::uint64_t winner = random.below(n);
  for (int i = 1; i < size; ++i) winner = std::min(winner, random.below(n));
  return static_cast<Eigen::Index>(winner);
}

/// Simulated binary crossover of one coordinate [Deb1995]: children keep the parents' mean.
void cross(double& a, double& b, double index, RandomStream& random) {
  const double u = random.uniform();
  const double exponent = 1.0 / (index + 1.0);
  const double spread =
      u <= 0.5 ? std::pow(2.0 * u, exponent) : std::pow(1.0 / (2.0 * (1.0 - u)), exponent);
  const double mean = 0.5 * (a + b);
  const double half = 0.5 * spread * (a - b);
  a = std::clamp(mean + half, 0.0, 1.0);
  b = std::clamp(mean - half, 0.0, 1.0);
}

/// Polynomial mutation of a coordinate in [0, 1] that cannot leave it [Deb2002; Deb2014].
double mutated(double x, double index, RandomStream& random) {
  const double u = random.uniform();
  const double exponent = 1.0 / (index + 1.0);
  if (u < 0.5)
    return std::max(
        0.0,
        x + std::pow(2.0 * u + (1.0 - 2.0 * u) * std::pow(1.0 - x, index + 1.0), exponent) - 1.0);
  return std::min(
      1.0,
      x + 1.0 - std::pow(2.0 * (1.0 - u) + (2.0 * u - 1.0) * std::pow(x, index + 1.0), exponent));
}

/// Children of tournament winners, crossed and mutated, as many as asked for.
Matrix offspring(const Population& p, Eigen::Index count, const GeneticOptions& o,
                 RandomStream& random) {
  Matrix children(count, p.genomes.cols());
  for (Eigen::Index i = 0; i < count; i += 2) {
    Vector a = p.genomes.row(tournament(p, o.tournament, random));
    Vector b = p.genomes.row(tournament(p, o.tournament, random));
    if (random.uniform() < o.crossover_probability)
      for (Eigen::Index k = 0; k < a.size(); ++k)
        if (random.uniform() < 0.5) cross(a[k], b[k], o.crossover_index, random);
    for (Vector* child : {&a, &b})
      for (double& gene : *child)
        if (random.uniform() < o.mutation_probability)
          gene = mutated(gene, o.mutation_index, random);
    children.row(i) = a;
    if (i + 1 < count) children.row(i + 1) = b;
  }
  return children;
}

Population next_generation(const BatchObjective& objective, const Bounds& bounds,
                           const Population& old, const GeneticOptions& o, RandomStream& random) {
  const auto n = static_cast<Eigen::Index>(o.population);
  const Eigen::Index elite = elite_count(o);
  const Matrix children = offspring(old, n - elite, o, random);
  Population next{Matrix(n, old.genomes.cols()), Vector(n)};
  next.genomes << old.genomes.topRows(elite), children;
  next.values << old.values.head(elite), evaluate(objective, children, bounds);
  sort_by_value(next);
  return next;
}

bool has_stalled(const std::vector<double>& best, const GeneticOptions& o) {
  const auto window = static_cast<std::size_t>(o.stall_generations);
  if (best.size() <= window) return false;
  const double before = best[best.size() - 1 - window];
  if (!std::isfinite(before)) return false;
  return before - best.back() < o.function_tolerance * std::max(1.0, std::abs(best.back()));
}

}  // namespace

GeneticResult minimize_genetic(const BatchObjective& objective, const Bounds& bounds,
                               const GeneticOptions& options) {
  check_bounds(bounds);
  check(options);
  RandomStream random(options.seed);
  Population p{Matrix(options.population, bounds.lower.size()), {}};
  for (double& gene : p.genomes.reshaped()) gene = random.uniform();
  p.values = evaluate(objective, p.genomes, bounds);
  sort_by_value(p);

  GeneticResult result;
  result.evaluations = options.population;
  result.best_by_generation.push_back(p.values[0]);
  while (result.generations < options.max_generations &&
         !has_stalled(result.best_by_generation, options)) {
    p = next_generation(objective, bounds, p, options, random);
    ++result.generations;
    result.evaluations += options.population - elite_count(options);
    result.best_by_generation.push_back(p.values[0]);
  }
  result.x = natural(p.genomes.topRows(1), bounds).row(0);
  result.value = p.values[0];
  if (!std::isfinite(result.value)) {
    result.termination = Termination::failed;
    result.message = fmt::format("no finite value in {} generations", result.generations);
  } else if (has_stalled(result.best_by_generation, options)) {
    result.termination = Termination::converged;
    result.message =
        fmt::format("improved by less than {} in the last {} of {} generations",
                    options.function_tolerance, options.stall_generations, result.generations);
  } else {
    result.termination = Termination::budget;
    result.message = fmt::format("all {} generations used", options.max_generations);
  }
  return result;
}

}  // namespace repose::opt

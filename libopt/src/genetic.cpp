#include "repose/opt/genetic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "population.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::opt {
namespace {

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

Population sorted(const Population& p) {
  const std::vector<Eigen::Index> order = ranking(p);
  return {p.genomes(order, Eigen::all), p.values(order), p.violations(order)};
}

/// The best of `size` random individuals; of a sorted population that is the smallest index.
Eigen::Index tournament(const Population& p, int size, RandomStream& random) {
  const auto n = static_cast<std::uint64_t>(p.values.size());
  std::uint64_t winner = random.below(n);
  for (int i = 1; i < size; ++i) winner = std::min(winner, random.below(n));
  return static_cast<Eigen::Index>(winner);
}

/// Parents of a sorted population, as many as asked for.
std::vector<Eigen::Index> parents(const Population& p, Eigen::Index count, const GeneticOptions& o,
                                  RandomStream& random) {
  std::vector<Eigen::Index> chosen;
  if (o.selection == Selection::tournament) {
    for (Eigen::Index i = 0; i < count; ++i) chosen.push_back(tournament(p, o.tournament, random));
    return chosen;
  }
  double total = 0.0;
  for (Eigen::Index i = 0; i < p.values.size(); ++i) total += 1.0 / std::sqrt(i + 1.0);
  const double spacing = total / static_cast<double>(count);
  double pointer = spacing * random.uniform(), passed = 1.0;
  for (Eigen::Index i = 0; static_cast<Eigen::Index>(chosen.size()) < count; pointer += spacing) {
    while (passed < pointer && i + 1 < p.values.size()) passed += 1.0 / std::sqrt(++i + 1.0);
    chosen.push_back(i);
  }
  random.shuffle(chosen);
  return chosen;
}

/// Simulated binary crossover of one coordinate [Deb1995]: children keep the parents' mean.
void cross_near(double& a, double& b, double index, RandomStream& random) {
  const double u = random.uniform();
  const double exponent = 1.0 / (index + 1.0);
  const double spread =
      u <= 0.5 ? std::pow(2.0 * u, exponent) : std::pow(1.0 / (2.0 * (1.0 - u)), exponent);
  const double mean = 0.5 * (a + b);
  const double half = 0.5 * spread * (a - b);
  a = std::clamp(mean + half, 0.0, 1.0);
  b = std::clamp(mean - half, 0.0, 1.0);
}

/// BLX-0.5 [Eshelman1993].
void blend(double& a, double& b, RandomStream& random) {
  const double low = std::min(a, b), high = std::max(a, b), half = 0.5 * (high - low);
  for (double* child : {&a, &b})
    *child = std::clamp(random.uniform(low - half, high + half), 0.0, 1.0);
}

/// Of two parents that are to be crossed.
void cross(Vector& a, Vector& b, const GeneticOptions& o, RandomStream& random) {
  for (Eigen::Index k = 0; k < a.size(); ++k) {
    if (o.crossover == Crossover::blend) {
      blend(a[k], b[k], random);
    } else if (random.uniform() < 0.5) {
      if (o.crossover == Crossover::scattered)
        std::swap(a[k], b[k]);
      else
        cross_near(a[k], b[k], o.crossover_index, random);
    }
  }
}

/// Polynomial mutation of a coordinate in [0, 1] that cannot leave it [Deb2002; Deb2014].
double mutated_near(double x, double index, RandomStream& random) {
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

double mutated(double x, const GeneticOptions& o, int generation, RandomStream& random) {
  switch (o.mutation) {
    case Mutation::polynomial:
      return mutated_near(x, o.mutation_index, random);
    case Mutation::uniform:
      return random.uniform();
    case Mutation::gaussian: {
      const double left = 1.0 - static_cast<double>(generation) / o.max_generations;
      const double moved = x + 0.1 * left * random.normal();
      return std::min(1.0, std::abs(std::remainder(moved, 2.0)));  // between mirrors
    }
  }
  return x;
}

/// Children of the parents, crossed and mutated, as many as asked for.
Matrix offspring(const Population& p, Eigen::Index count, const GeneticOptions& o, int generation,
                 RandomStream& random) {
  Matrix children(count, p.genomes.cols());
  const std::vector<Eigen::Index> chosen = parents(p, count + count % 2, o, random);
  for (Eigen::Index i = 0; i < count; i += 2) {
    Vector a = p.genomes.row(chosen[static_cast<std::size_t>(i)]);
    Vector b = p.genomes.row(chosen[static_cast<std::size_t>(i) + 1]);
    if (random.uniform() < o.crossover_probability) cross(a, b, o, random);
    for (Vector* child : {&a, &b})
      for (double& gene : *child)
        if (random.uniform() < o.mutation_probability) gene = mutated(gene, o, generation, random);
    children.row(i) = a;
    if (i + 1 < count) children.row(i + 1) = b;
  }
  return children;
}

Population next_generation(const BatchObjective& objective, const GenomeSpace& space,
                           const Population& old, const GeneticOptions& o, RandomStream& random,
                           EvolutionResult& result) {
  const auto n = static_cast<Eigen::Index>(o.population);
  const Eigen::Index elite = elite_count(o);
  const Population young =
      evaluated(objective, offspring(old, n - elite, o, result.generations, random), space, result);
  Population next{Matrix(n, old.genomes.cols()), Vector(n), Vector(n)};
  next.genomes << old.genomes.topRows(elite), young.genomes;
  next.values << old.values.head(elite), young.values;
  next.violations << old.violations.head(elite), young.violations;
  return sorted(next);
}

bool has_stalled(const std::vector<double>& best, const GeneticOptions& o) {
  const auto window = static_cast<std::size_t>(o.stall_generations);
  if (best.size() <= window) return false;
  const double before = best[best.size() - 1 - window];
  if (!std::isfinite(before)) return false;
  return before - best.back() < o.function_tolerance * std::max(1.0, std::abs(best.back()));
}

}  // namespace

EvolutionResult minimize_genetic(const BatchObjective& objective, const FeasibleSet& set,
                                 const GeneticOptions& options) {
  check_feasible_set(set);
  check(options);
  RandomStream random(options.seed);
  const GenomeSpace space(set);
  Matrix genomes(options.population, space.size());
  for (double& gene : genomes.reshaped()) gene = random.uniform();
  EvolutionResult result;
  result.value = std::numeric_limits<double>::infinity();
  Population p = sorted(evaluated(objective, std::move(genomes), space, result));
  keep_best(p, space, result);
  while (result.generations < options.max_generations &&
         !has_stalled(result.best_by_generation, options)) {
    p = next_generation(objective, space, p, options, random, result);
    ++result.generations;
    keep_best(p, space, result);
  }
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

// Populations of the evolutionary methods.
#include "population.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"

namespace repose::opt {

GenomeSpace::GenomeSpace(const FeasibleSet& set)
    : set_(set), bounds_(narrowed_bounds(set)), free_(free_coordinates(set)) {
  for (std::size_t place = 0; place < free_.size(); ++place)
    if (std::find(set.whole.begin(), set.whole.end(), free_[place]) != set.whole.end())
      whole_.push_back(static_cast<Eigen::Index>(place));
}

Vector GenomeSpace::decoded(const Vector& genome) const {
  Vector x = bounds_.lower;
  for (Eigen::Index i = 0; i < size(); ++i) x[coordinate(i)] += genome[i] * range(i);
  return rounded(x, set_);
}

Population evaluated(const BatchObjective& objective, Matrix genomes, const GenomeSpace& space,
                     EvolutionResult& result) {
  Population population{std::move(genomes), {}, {}};
  const Eigen::Index n = population.genomes.rows();
  population.values = Vector::Constant(n, std::numeric_limits<double>::infinity());
  population.violations = Vector(n);
  Matrix points(n, space.set().bounds.lower.size());
  std::vector<Eigen::Index> asked;
  for (Eigen::Index i = 0; i < n; ++i) {
    points.row(i) = space.decoded(population.genomes.row(i));
    population.violations[i] = violation(points.row(i), space.set());
    if (population.violations[i] == 0.0) asked.push_back(i);
  }
  if (asked.empty()) return population;
  const Vector values = objective(points(asked, Eigen::all));
  if (values.size() != static_cast<Eigen::Index>(asked.size()))
    throw InputError(fmt::format("a batch objective returned {} values for {} points",
                                 values.size(), asked.size()));
  result.evaluations += values.size();
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (const double value = values[static_cast<Eigen::Index>(i)]; std::isfinite(value))
      population.values[asked[i]] = value;
  return population;
}

std::vector<Eigen::Index> ranking(const Population& p) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(p.values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return std::pair(p.violations[a], p.values[a]) < std::pair(p.violations[b], p.values[b]);
  });
  return order;
}

void keep_best(const Population& p, const GenomeSpace& space, EvolutionResult& result) {
  const Eigen::Index best = ranking(p).front();
  const bool first = result.x.size() == 0;
  if (first || (p.violations[best] == 0.0 && p.values[best] < result.value)) {
    result.x = space.decoded(p.genomes.row(best));
    result.value = p.values[best];
  }
  result.best_by_generation.push_back(result.value);
}

RepeatedSearch repeat_search(const std::function<EvolutionResult(std::uint64_t)>& search,
                             int repetitions, std::uint64_t seed, unsigned threads) {
  if (repetitions < 1)
    throw InputError(fmt::format("a search repeated {} times; once is the least", repetitions));
  RepeatedSearch repeated;
  repeated.results.resize(static_cast<std::size_t>(repetitions));
  parallel_for(repeated.results.size(), threads,
               [&](std::size_t i) { repeated.results[i] = search(derive_seed(seed, i)); });
  Matrix points(repetitions, repeated.results.front().x.size());
  for (std::size_t i = 0; i < repeated.results.size(); ++i) {
    points.row(static_cast<Eigen::Index>(i)) = repeated.results[i].x;
    if (repeated.results[i].value < repeated.results[repeated.best].value) repeated.best = i;
  }
  repeated.mean = points.colwise().mean();
  const Matrix centred = points.rowwise() - repeated.mean.transpose();
  repeated.standard_deviation =
      repetitions > 1 ? Vector((centred.colwise().squaredNorm() / (repetitions - 1.0)).cwiseSqrt())
                      : Vector::Constant(points.cols(), std::numeric_limits<double>::quiet_NaN());
  return repeated;
}

}  // namespace repose::opt

// Which rows of a new configuration to simulate first.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "repose/base/error.hpp"
#include "task.hpp"
#include "task_relations.hpp"

namespace repose::surrogate {
namespace {

constexpr Eigen::Index kMostRows = 2000;

void check_numbers(Eigen::Index candidates, Eigen::Index count, Eigen::Index simulated) {
  if (count < 0 || count > candidates)
    throw InputError(fmt::format(
        "{} runs to choose from {} candidates; ask for no more than there are", count, candidates));
  if (candidates + simulated > kMostRows)
    throw InputError(
        fmt::format("{} candidates and {} rows that are simulated; choose among {} in all at most, "
                    "such as a part of the candidates taken by chance",
                    candidates, simulated, kMostRows));
}

}  // namespace

/// Greedy: row i takes away sum_j C_ij^2/(C_ii + noise) of the candidates' variances.
std::vector<Eigen::Index> first_target_runs(const GaussianProcess& source, const Matrix& candidates,
                                            Eigen::Index count, const Matrix& simulated) {
  const Eigen::Index m = candidates.rows(), p = simulated.rows();
  check_numbers(m, count, p);
  if (count == 0) return {};
  Matrix all(p + m, candidates.cols());
  if (p > 0) all.topRows(p) = simulated;
  all.bottomRows(m) = candidates;
  Matrix c = prior_target_covariance(source, all);
  const double noise = std::max(source.noise_variance(), 1e-9 * c.diagonal().maxCoeff());
  const auto observe = [&](Eigen::Index i) {
    const Vector column = c.col(i);
    c -= column * column.transpose() / (column[i] + noise);
  };
  for (Eigen::Index i = 0; i < p; ++i) observe(i);
  std::vector<Eigen::Index> chosen;
  std::vector<bool> taken(static_cast<std::size_t>(m), false);
  while (static_cast<Eigen::Index>(chosen.size()) < count) {
    Eigen::Index best = -1;
    double most = -1.0;
    for (Eigen::Index i = 0; i < m; ++i) {
      if (taken[static_cast<std::size_t>(i)]) continue;
      const double gain =
          c.col(p + i).tail(m).squaredNorm() / (std::max(0.0, c(p + i, p + i)) + noise);
      if (gain > most) {
        most = gain;
        best = i;
      }
    }
    if (best < 0)
      throw NumericalError(fmt::format(
          "no candidate has a finite variance to take away, at a source variance of {:.4g} and a "
          "noise variance of {:.4g}; give the response another unit",
          source.hyperparameters().process_variance, source.noise_variance()));
    taken[static_cast<std::size_t>(best)] = true;
    chosen.push_back(best);
    observe(p + best);
  }
  return chosen;
}

std::vector<Eigen::Index> first_target_runs(const PretrainedModel& source,
                                            const TrainingSet& source_rows,
                                            const Matrix& candidates, Eigen::Index count,
                                            const Matrix& simulated) {
  check_numbers(candidates.rows(), count, simulated.rows());
  const GaussianProcess* process = process_of(source);
  return first_target_runs(
      process != nullptr ? *process
                         : GaussianProcess::fit(source_rows.x, source_rows.y, source_rows.inputs),
      candidates, count, simulated);
}

}  // namespace repose::surrogate

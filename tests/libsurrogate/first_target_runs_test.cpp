// Which rows of a new configuration to simulate first.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <set>

#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "transfer/task_relations.hpp"
#include "transfer_data.hpp"

namespace repose::surrogate {
namespace {

using test::bumps;
using test::sampled;

GaussianProcess source_process() {
  const TrainingSet source = sampled(bumps, 40, 0.05, 1);
  return GaussianProcess::fit(source.x, source.y, source.inputs);
}

/// Sum of the variances of all rows once some of them are observed, by one dense solve.
double variance_left(const Matrix& prior, const std::vector<Eigen::Index>& observed, double noise) {
  Matrix known = prior(observed, observed);
  known.diagonal().array() += noise;
  const Matrix across = prior(Eigen::all, observed);
  return prior.trace() - (across * known.ldlt().solve(across.transpose())).trace();
}

TEST(FirstTargetRuns, EachLeaveTheSmallestVarianceOfAllCandidates) {
  const GaussianProcess process = source_process();
  const Matrix candidates = sampled(bumps, 25, 0.0, 5).x;
  const Matrix prior = prior_target_covariance(process, candidates);
  const double noise = std::max(process.noise_variance(), 1e-9 * prior.diagonal().maxCoeff());
  const auto chosen = first_target_runs(process, candidates, 8);
  std::vector<Eigen::Index> observed;
  for (const Eigen::Index next : chosen) {
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < 25; ++i) {
      if (std::find(observed.begin(), observed.end(), i) != observed.end()) continue;
      auto with = observed;
      with.push_back(i);
      least = std::min(least, variance_left(prior, with, noise));
    }
    observed.push_back(next);
    EXPECT_NEAR(variance_left(prior, observed, noise), least, 1e-9 * prior.trace());
  }
}

/// Of the functions deemed possible: as much as the source's own far from its data, and more.
TEST(FirstTargetRuns, TakeTheTargetForMoreUncertainThanTheSource) {
  const GaussianProcess process = source_process();
  const Matrix x = sampled(bumps, 20, 0.0, 6).x;
  const Matrix prior = prior_target_covariance(process, x);
  EXPECT_LT((prior - prior.transpose()).cwiseAbs().maxCoeff(), 1e-12);
  for (Eigen::Index i = 0; i < 20; ++i)
    EXPECT_GT(prior(i, i), process.predict(x.row(i).transpose()).variance);
}

TEST(FirstTargetRuns, ComeInOneOrderWithoutWhatIsSimulated) {
  const GaussianProcess process = source_process();
  const Matrix candidates = sampled(bumps, 30, 0.0, 5).x;
  const auto order = first_target_runs(process, candidates, 30);
  EXPECT_EQ(std::set<Eigen::Index>(order.begin(), order.end()).size(), 30u);
  const auto first = first_target_runs(process, candidates, 3);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), order.begin()));
  // what is simulated already need not be simulated again: of two equal rows one is worth nothing
  Matrix twice(31, 2);
  twice << candidates, candidates.row(order[0]);
  const auto next = first_target_runs(process, twice, 10, candidates.row(order[0]));
  EXPECT_EQ(next[0], order[1]);
  EXPECT_EQ(std::count(next.begin(), next.end(), order[0]), 0);
  EXPECT_EQ(std::count(next.begin(), next.end(), 30), 0);
  EXPECT_THROW(first_target_runs(process, candidates, 31), InputError);
  EXPECT_THROW(first_target_runs(process, Matrix::Zero(2001, 2), 1), InputError);
  EXPECT_TRUE(first_target_runs(process, candidates, 0).empty());
  EXPECT_TRUE(first_target_runs(process, Matrix(0, 2), 0).empty());
}

/// A process of log y has no covariances of y to go by; one of the same rows has.
TEST(FirstTargetRuns, OfALogarithmAreThoseOfAProcessOfItsRows) {
  TrainingSet source = sampled(bumps, 30, 0.05, 1);
  source.y = source.y.array().exp();
  GaussianProcessOptions options;
  options.response_scale = ResponseScale::log;
  const Trainer trainer = gaussian_process_trainer("log", options);
  const PretrainedModel model{trainer.fit(source, 1), trainer};
  const Matrix candidates = sampled(bumps, 15, 0.0, 5).x;
  EXPECT_EQ(
      first_target_runs(model, source, candidates, 5),
      first_target_runs(GaussianProcess::fit(source.x, source.y, source.inputs), candidates, 5));
}

}  // namespace
}  // namespace repose::surrogate

// Two correlated functions: against the joint Gaussian distribution of all rows, and what is found
// of how they relate.
#include "repose/surrogate/coregionalised_process.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "transfer_data.hpp"

namespace repose::surrogate {
namespace {

using test::bumps;
using test::sampled;

/// Squared exponential, two inputs, parameters as given.
GaussianProcess source_process(const TrainingSet& data) {
  return GaussianProcess::with_parameters(
      data.x, data.y, data.inputs,
      {.length_scales = Vector{{0.4, 0.7}}, .process_variance = 2.0, .noise_variance = 0.01},
      {.kernel = {Correlation::squared_exponential}});
}

double squared_exponential(const Vector& a, const Vector& b, double first, double second) {
  return std::exp(-0.5 *
                  (std::pow((a[0] - b[0]) / first, 2) + std::pow((a[1] - b[1]) / second, 2)));
}

struct Moments {
  Vector mean;
  Matrix covariance;
};

/// The target's function at `q` given all observations, by conditioning one joint distribution in
/// which the source's mean has a variance too large to matter.
Moments by_joint_distribution(const TrainingSet& source, const TrainingSet& target,
                              const GaussianProcess& process, const TaskRelation& r,
                              const Matrix& q) {
  constexpr double kVague = 1e5;
  const Eigen::Index ns = source.rows(), nt = target.rows(), m = q.rows(), n = ns + nt + m;
  Matrix x(n, 2);
  x << source.x, target.x, q;
  double centre = 0.0;
  for (const Gaussian& g : process.predict_rows(process.points())) centre += g.mean;
  centre /= static_cast<double>(process.points().rows());
  Vector mean = Vector::Zero(n), factor = Vector::Ones(n);
  mean.tail(nt + m).setConstant(centre * (1.0 - r.scale));
  factor.tail(nt + m).setConstant(r.scale);
  Matrix c(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Vector a = x.row(i), b = x.row(j);
      c(i, j) = factor[i] * factor[j] * (2.0 * squared_exponential(a, b, 0.4, 0.7) + kVague);
      if (i >= ns && j >= ns)
        c(i, j) += r.own_variance * squared_exponential(a, b, 0.4 * r.length_factors[0],
                                                        0.7 * r.length_factors[1]) +
                   r.shift_deviation * r.shift_deviation;
    }
  for (Eigen::Index i = 0; i < ns; ++i) c(i, i) += 0.01;
  for (Eigen::Index i = ns; i < ns + nt; ++i) c(i, i) += r.noise_variance;
  Vector y(ns + nt);
  y << source.y, target.y;
  const Eigen::Index k = ns + nt;
  const Eigen::LDLT<Matrix> known(c.topLeftCorner(k, k));
  const Matrix across = c.bottomLeftCorner(m, k);
  return {mean.tail(m) + across * known.solve(y - mean.head(k)),
          c.bottomRightCorner(m, m) - across * known.solve(across.transpose())};
}

const TaskRelation kRelation{.correlation = 0.8,
                             .scale = 1.3,
                             .own_variance = 0.4,
                             .length_factors = Vector{{1.5, 0.6}},
                             .shift_deviation = 0.7,
                             .noise_variance = 0.02,
                             .weight = 1.0};

TEST(CoregionalisedProcess, PredictsAsTheJointDistributionOfBothTasks) {
  const TrainingSet source = sampled(bumps, 18, 0.1, 1);
  const TrainingSet target = sampled([](const Vector& x) { return 1.0 - bumps(x); }, 6, 0.1, 2);
  const Matrix q = sampled(bumps, 9, 0.0, 3).x;
  const GaussianProcess process = source_process(source);
  const auto model =
      CoregionalisedProcess::with_relations(process, target.x, target.y, {kRelation});
  const Moments expected = by_joint_distribution(source, target, process, kRelation, q);
  const Predictions found = model.predict_with_variances(q);
  // the vague mean leaves 1/kVague of the variances and 1e5 eps of rounding
  EXPECT_LT((found.mean - expected.mean).cwiseAbs().maxCoeff(), 2e-4);
  EXPECT_LT((found.function_variance - expected.covariance.diagonal()).cwiseAbs().maxCoeff(), 2e-4);
  const Vector noise = found.observation_variance - found.function_variance;
  EXPECT_LT((noise.array() - 0.02).abs().maxCoeff(), 1e-12);
  EXPECT_EQ(model.predict(q), found.mean);
}

TEST(CoregionalisedProcess, MixesItsRelationsByTheirWeights) {
  const TrainingSet source = sampled(bumps, 18, 0.1, 1), target = sampled(bumps, 6, 0.1, 2);
  const Matrix q = sampled(bumps, 9, 0.0, 3).x;
  const GaussianProcess process = source_process(source);
  TaskRelation other = kRelation;
  other.scale = -0.5;
  other.weight = 0.25;
  TaskRelation first = kRelation;
  first.weight = 0.75;
  const auto one = [&](const TaskRelation& r) {
    return CoregionalisedProcess::with_relations(process, target.x, target.y, {r})
        .predict_with_variances(q);
  };
  TaskRelation alone = other;
  alone.weight = 1.0;
  const Predictions a = one(kRelation), b = one(alone);
  const Predictions found =
      CoregionalisedProcess::with_relations(process, target.x, target.y, {first, other})
          .predict_with_variances(q);
  const Vector mean = 0.75 * a.mean + 0.25 * b.mean;
  const Vector between = 0.75 * (a.mean - mean).cwiseAbs2() + 0.25 * (b.mean - mean).cwiseAbs2();
  EXPECT_LT((found.mean - mean).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT(
      (found.function_variance - 0.75 * a.function_variance - 0.25 * b.function_variance - between)
          .cwiseAbs()
          .maxCoeff(),
      1e-12);
}

/// What fit() drops as improbable has a thousandth of the weight: predictions agree to that part of
/// the spread of what relations predict, within which all responses are.
TEST(CoregionalisedProcess, LeavesRowsOutAsIfFittedWithoutThem) {
  const TrainingSet source = sampled(bumps, 30, 0.05, 1);
  const GaussianProcess process = GaussianProcess::fit(source.x, source.y, source.inputs);
  TrainingSet target = sampled(bumps, 8, 0.05, 2);
  target.y[3] += 3.0;  // relations that the others deem probable are not with this row
  const double tolerance = 2e-3 * (target.y.maxCoeff() - target.y.minCoeff());
  for (const std::vector<Eigen::Index>& groups :
       {std::vector<Eigen::Index>{0, 1, 2, 3, 4, 5, 6, 7}, {5, 5, 2, 2, 9, 9, 9, 4}}) {
    const auto judged =
        CoregionalisedProcess::fit_and_leave_out(process, target.x, target.y, groups);
    EXPECT_EQ(judged.process.predict(source.x),
              CoregionalisedProcess::fit(process, target.x, target.y).predict(source.x));
    for (const Eigen::Index group : groups) {
      std::vector<Eigen::Index> in, out;
      for (std::size_t i = 0; i < groups.size(); ++i)
        (groups[i] == group ? out : in).push_back(static_cast<Eigen::Index>(i));
      const TrainingSet rest = selected_rows(target, in), left = selected_rows(target, out);
      const Predictions expected =
          CoregionalisedProcess::fit(process, rest.x, rest.y).predict_with_variances(left.x);
      for (std::size_t k = 0; k < out.size(); ++k) {
        const auto i = static_cast<Eigen::Index>(k);
        EXPECT_NEAR(judged.left_out.mean[out[k]], expected.mean[i], tolerance);
        EXPECT_NEAR(std::sqrt(judged.left_out.observation_variance[out[k]]),
                    std::sqrt(expected.observation_variance[i]), tolerance);
        EXPECT_NEAR(std::sqrt(judged.left_out.function_variance[out[k]]),
                    std::sqrt(expected.function_variance[i]), tolerance);
      }
    }
  }
}

TEST(CoregionalisedProcess, FindsHowTheFunctionsRelate) {
  const TrainingSet source = sampled(bumps, 40, 0.05, 1);
  const GaussianProcess process = GaussianProcess::fit(source.x, source.y, source.inputs);
  const auto correlation = [&](const test::Function& f) {
    const TrainingSet target = sampled(f, 12, 0.05, 2);
    return CoregionalisedProcess::fit(process, target.x, target.y).correlation();
  };
  const Gaussian same = correlation(bumps);
  const Gaussian opposed = correlation([](const Vector& x) { return 2.0 - bumps(x); });
  const Gaussian other = correlation([](const Vector& x) { return std::cos(9.0 * x[1]); });
  EXPECT_GT(same.mean, 0.95);
  EXPECT_LT(opposed.mean, -0.9);
  EXPECT_LT(std::abs(other.mean), 0.4);
  EXPECT_LT(same.standard_deviation(), other.standard_deviation());
}

TEST(CoregionalisedProcess, HasWeightsThatSumToOneWithoutTheImprobable) {
  const TrainingSet source = sampled(bumps, 40, 0.05, 1), target = sampled(bumps, 12, 0.05, 2);
  const GaussianProcess process = GaussianProcess::fit(source.x, source.y, source.inputs);
  const auto model = CoregionalisedProcess::fit(process, target.x, target.y);
  double sum = 0.0;
  for (const TaskRelation& r : model.relations()) sum += r.weight;
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_LT(model.relations().size(), 1024u);
  EXPECT_EQ(model.points(), target.x);
  EXPECT_EQ(model.values(), target.y);
}

TEST(CoregionalisedProcess, TakesResponsesThatAreAllTheSame) {
  const TrainingSet source = sampled(bumps, 30, 0.05, 1);
  TrainingSet target = sampled(bumps, 5, 0.0, 2);
  target.y.setConstant(0.3);
  for (const double level : {0.0, 0.3, -1e6}) {
    target.y.setConstant(level);
    const auto model = CoregionalisedProcess::fit(
        GaussianProcess::fit(source.x, source.y, source.inputs), target.x, target.y);
    EXPECT_TRUE(model.predict(target.x).allFinite()) << level;
  }
}

TEST(CoregionalisedProcess, RefusesWhatItCannotUse) {
  const TrainingSet source = sampled(bumps, 30, 0.05, 1), target = sampled(bumps, 5, 0.0, 2);
  const auto process = GaussianProcess::fit(source.x, source.y, source.inputs);
  EXPECT_THROW(CoregionalisedProcess::fit(process, target.x, target.y.head(4)), InputError);
  EXPECT_THROW(CoregionalisedProcess::fit(process, Matrix(0, 2), Vector()), InputError);
  EXPECT_THROW(CoregionalisedProcess::fit(process, Matrix::Zero(5, 3), target.y), InputError);
  const auto positive = GaussianProcess::fit(source.x, source.y.array().exp(), source.inputs,
                                             {.response_scale = ResponseScale::log});
  EXPECT_THROW(CoregionalisedProcess::fit(positive, target.x, target.y), InputError);
  const std::vector<Eigen::Index> one_group(5, 0), few(4, 0);
  const auto judged = [&](const std::vector<Eigen::Index>& groups) {
    return CoregionalisedProcess::fit_and_leave_out(process, target.x, target.y, groups).left_out;
  };
  EXPECT_TRUE(judged(one_group).mean.array().isNaN().all());
  EXPECT_THROW(judged(few), InputError);
  EXPECT_THROW(CoregionalisedProcess::fit(process, target.x, 1e160 * target.y), NumericalError);
}

TEST(CoregionalisedProcess, RefusesImpossibleRelations) {
  const TrainingSet source = sampled(bumps, 18, 0.1, 1), target = sampled(bumps, 6, 0.1, 2);
  const GaussianProcess process = source_process(source);
  const auto refused = [&](auto change) {
    TaskRelation r = kRelation;
    change(r);
    EXPECT_THROW(CoregionalisedProcess::with_relations(process, target.x, target.y, {r}),
                 InputError);
  };
  refused([](TaskRelation& r) { r = {}; });
  refused([](TaskRelation& r) { r.correlation = 1.1; });
  refused([](TaskRelation& r) { r.scale = std::numeric_limits<double>::infinity(); });
  refused([](TaskRelation& r) { r.own_variance = -0.1; });
  refused([](TaskRelation& r) { r.shift_deviation = 0.0; });
  refused([](TaskRelation& r) { r.noise_variance = std::nan(""); });
  refused([](TaskRelation& r) { r.length_factors = Vector{{1.0}}; });
  refused([](TaskRelation& r) { r.length_factors = Vector(); });
  refused([](TaskRelation& r) { r.length_factors[1] = 0.0; });
  refused([](TaskRelation& r) { r.weight = 0.5; });
  EXPECT_THROW(CoregionalisedProcess::with_relations(process, target.x, target.y, {}), InputError);
}

/// Relations are in units of the source's deviation, however small beside its mean.
TEST(CoregionalisedProcess, DoesNotTakeASourceOfSmallRelativeDeviationForConstant) {
  const TrainingSet source = sampled(bumps, 30, 0.0, 1), target = sampled(bumps, 6, 0.0, 2);
  const auto correlation = [&](double level) {
    const auto process = GaussianProcess::fit(source.x, source.y.array() + level, source.inputs);
    return CoregionalisedProcess::fit(process, target.x, target.y.array() + level)
        .correlation()
        .mean;
  };
  EXPECT_NEAR(correlation(1e7), correlation(0.0), 1e-2);
}

}  // namespace
}  // namespace repose::surrogate

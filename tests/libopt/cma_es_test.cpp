// CMA-ES: known optima, its promises about scale and rotation, constraints, bad values.
#include "repose/opt/cma_es.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "functions.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::opt {
namespace {

using test::by_rows;

class CmaEs : public testing::TestWithParam<test::Benchmark> {};

TEST_P(CmaEs, FindsTheGlobalMinimumWithItsDefaults) {
  const test::Benchmark b = GetParam();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const EvolutionResult r = minimize_cma_es(by_rows(b.value), {b.bounds}, {.seed = seed});
    EXPECT_NEAR(r.value, b.minimum, 1e-8) << b.name << ", seed " << seed << ": " << r.message;
    EXPECT_EQ(r.value, b.value(r.x));
    EXPECT_EQ(r.best_by_generation.size(), static_cast<std::size_t>(r.generations));
    EXPECT_TRUE(std::is_sorted(r.best_by_generation.rbegin(), r.best_by_generation.rend()));
  }
}

INSTANTIATE_TEST_SUITE_P(Benchmarks, CmaEs,
                         testing::Values(test::branin_benchmark(), test::hartmann6_benchmark(),
                                         test::rastrigin_benchmark()),
                         [](const auto& p) { return std::string(p.param.name); });

/// sum 10^(4 i/(d-1)) (Q x)_i^2: the axes of its ellipsoids are 100 to 1 and lie in no plane.
EvolutionResult on_ellipsoid(const Matrix& q) {
  const Eigen::Index d = q.rows();
  const BatchObjective f = [&](const Matrix& rows) {
    Vector values(rows.rows());
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
      const Vector z = q * rows.row(i).transpose();
      values[i] = 0.0;
      for (Eigen::Index k = 0; k < d; ++k)
        values[i] += std::pow(10.0, 4.0 * static_cast<double>(k) / (d - 1.0)) * z[k] * z[k];
    }
    return values;
  };
  return minimize_cma_es(f, {{Vector::Constant(d, -4.0), Vector::Constant(d, 6.0)}},
                         {.restarts = 0, .function_tolerance = 1e-14});
}

// The covariance learns the ellipsoid: turned or not, it takes about as many points. A method that
// works by coordinates would take orders of magnitude more of the turned one.
TEST(CmaEsOnEllipsoids, NeedsNoMorePointsWhenTheAxesAreTurned) {
  constexpr Eigen::Index kDimension = 8;
  RandomStream random(3);
  Matrix m(kDimension, kDimension);
  for (double& value : m.reshaped()) value = random.normal();
  const Matrix turned = Eigen::HouseholderQR<Matrix>(m).householderQ();
  const EvolutionResult along = on_ellipsoid(Matrix::Identity(kDimension, kDimension));
  const EvolutionResult across = on_ellipsoid(turned);
  EXPECT_LT(along.value, 1e-11);
  EXPECT_LT(across.value, 1e-11);
  EXPECT_LT(static_cast<double>(across.evaluations), 1.5 * static_cast<double>(along.evaluations));
}

TEST(CmaEsPromises, RisingTransformationsOfTheObjectiveChangeNothing) {
  const test::Benchmark b = test::branin_benchmark();
  const auto f = by_rows(b.value);
  const BatchObjective transformed = [&](const Matrix& rows) -> Vector {
    return f(rows).array().log();
  };
  const CmaEsOptions options{.restarts = 0, .max_points = 300, .function_tolerance = 0.0};
  EXPECT_EQ(minimize_cma_es(f, {b.bounds}, options).x,
            minimize_cma_es(transformed, {b.bounds}, options).x);
}

TEST(CmaEsPromises, OneSeedGivesTheSameBits) {
  const test::Benchmark b = test::hartmann6_benchmark();
  const CmaEsOptions options{.max_points = 500, .seed = 4};
  const auto first = minimize_cma_es(by_rows(b.value), {b.bounds}, options);
  const auto second = minimize_cma_es(by_rows(b.value), {b.bounds}, options);
  EXPECT_EQ(first.x, second.x);
  EXPECT_EQ(first.best_by_generation, second.best_by_generation);
  EXPECT_NE(first.x,
            minimize_cma_es(by_rows(b.value), {b.bounds}, {.max_points = 500, .seed = 5}).x);
}

TEST(CmaEsPromises, FindsAMinimumOnTheBoundsAndNeverLeavesThem) {
  const Bounds box{Vector{{1.0, -3.0, 0.0}}, Vector{{2.0, -2.0, 0.0}}};  // one coordinate is fixed
  const BatchObjective slope = [&](const Matrix& rows) -> Vector {
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      for (Eigen::Index k = 0; k < 3; ++k)
        EXPECT_TRUE(rows(i, k) >= box.lower[k] && rows(i, k) <= box.upper[k]) << rows.row(i);
    return rows.col(0) - rows.col(1) + rows.col(2);
  };
  EXPECT_NEAR(minimize_cma_es(slope, {box}).value, 3.0, 1e-9);
}

TEST(CmaEsPromises, ObeysLinearConstraintsAndAsksForNoPointThatBreaksThem) {
  const BatchObjective bowl = [](const Matrix& rows) -> Vector {
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      EXPECT_GE(rows.row(i).sum(), 1.2 - 1e-11) << rows.row(i);
    return rows.col(0).array().square() + 2.0 * rows.col(1).array().square();
  };
  const FeasibleSet set{unit_cube(2), {{"sum", Vector{{-1.0, -1.0}}, -1.2}}};
  const EvolutionResult r = minimize_cma_es(bowl, set);
  EXPECT_NEAR(r.value, 0.96, 1e-4);  // at (0.8, 0.4)
}

TEST(CmaEsPromises, KeepsWholeCoordinatesWholeAndMoving) {
  const BatchObjective bowl = [](const Matrix& rows) -> Vector {
    for (Eigen::Index i = 0; i < rows.rows(); ++i) EXPECT_EQ(rows(i, 1), std::round(rows(i, 1)));
    return (rows.col(0).array() - 2.4).square() + (rows.col(1).array() - 3.4).square();
  };
  const FeasibleSet set{{Vector{{0.0, -40.0}}, Vector{{5.0, 90.0}}}, {}, {1}};
  const EvolutionResult r = minimize_cma_es(bowl, set, {.restarts = 1, .max_points = 5000});
  EXPECT_EQ(r.x[1], 3.0);
  EXPECT_NEAR(r.value, 0.16, 1e-6);
}

// x2 = 3 - n follows the whole n = x1 in [-40, 90] within [-50, 20], which leaves n in [-17, 53].
TEST(CmaEsPromises, MovesTheLeadersOfTiesAlone) {
  const FeasibleSet set{
      {Vector{{0.0, -40.0, -50.0}}, Vector{{5.0, 90.0, 20.0}}}, {}, {2, 1}, {{2, 1, -1.0, 3.0}}};
  const BatchObjective f = [](const Matrix& rows) -> Vector {
    return (rows.col(0).array() - 2.4).square() + (rows.col(1).array() + 20.4).square() -
           0.1 * rows.col(2).array();
  };
  const BatchObjective reduced = [&](const Matrix& leaders) {
    Matrix rows(leaders.rows(), 3);
    rows << leaders, 3.0 - leaders.col(1).array();
    return f(rows);
  };
  const FeasibleSet small{{Vector{{0.0, -17.0}}, Vector{{5.0, 53.0}}}, {}, {1}};
  const CmaEsOptions options{.restarts = 1, .max_points = 5000};
  const EvolutionResult full = minimize_cma_es(f, set, options);
  const EvolutionResult by_hand = minimize_cma_es(reduced, small, options);
  EXPECT_EQ(full.best_by_generation, by_hand.best_by_generation);
  EXPECT_EQ(full.x, (Vector{{by_hand.x[0], -17.0, 20.0}}));
}

TEST(CmaEsPromises, EndsWhereNothingIsFiniteOrNothingVaries) {
  const BatchObjective nowhere = [](const Matrix& rows) -> Vector {
    return Vector::Constant(rows.rows(), std::nan(""));
  };
  const auto failed = minimize_cma_es(nowhere, {unit_cube(2)}, {.max_points = 200});
  EXPECT_EQ(failed.termination, Termination::failed);
  EXPECT_EQ(failed.x.size(), 2);
  const BatchObjective flat = [](const Matrix& rows) -> Vector {
    return Vector::Constant(rows.rows(), 7.0);
  };
  const auto same = minimize_cma_es(flat, {unit_cube(2)});
  EXPECT_EQ(same.termination, Termination::converged);
  EXPECT_EQ(same.value, 7.0);
  const BatchObjective line = [](const Matrix& rows) -> Vector { return rows.col(0); };
  EXPECT_NEAR(minimize_cma_es(line, {unit_cube(1)}).value, 0.0, 1e-9);  // one dimension
}

TEST(CmaEsPromises, RefusesBadOptions) {
  const auto f = by_rows(test::branin);
  EXPECT_THROW(minimize_cma_es(f, {unit_cube(2)}, {.population = 3}), InputError);
  EXPECT_THROW(minimize_cma_es(f, {unit_cube(2)}, {.initial_step = 0.0}), InputError);
  EXPECT_THROW(minimize_cma_es(f, {unit_cube(2)}, {.restarts = -1}), InputError);
  EXPECT_THROW(minimize_cma_es(f, {unit_cube(2)}, {.max_points = 0}), InputError);
  EXPECT_THROW(minimize_cma_es(f, {unit_cube(0)}), InputError);
}

}  // namespace
}  // namespace repose::opt

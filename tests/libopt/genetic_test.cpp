// The genetic algorithm: known optima with the defaults, reproducibility, bounds, bad values.
#include "repose/opt/genetic.hpp"

#include <gtest/gtest.h>

#include "functions.hpp"
#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

BatchObjective by_rows(double (*f)(const Vector&)) {
  return [f](const Matrix& rows) {
    Vector values(rows.rows());
    for (Eigen::Index i = 0; i < rows.rows(); ++i) values[i] = f(rows.row(i));
    return values;
  };
}

class Genetic : public testing::TestWithParam<test::Benchmark> {};

// Three seeds each; a broken operator leaves Rastrigin at a multiple of 0.995 and Hartmann6 at
// -3.2032.
TEST_P(Genetic, FindsTheGlobalMinimumWithItsDefaults) {
  const test::Benchmark b = GetParam();
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const GeneticResult r = minimize_genetic(by_rows(b.value), b.bounds, {.seed = seed});
    EXPECT_NEAR(r.value, b.minimum, 1e-3) << b.name << ", seed " << seed << ": " << r.message;
    EXPECT_EQ(r.value, b.value(r.x));
    EXPECT_EQ(r.termination, Termination::converged);
    EXPECT_EQ(r.best_by_generation.size(), static_cast<std::size_t>(r.generations) + 1);
    EXPECT_TRUE(std::is_sorted(r.best_by_generation.rbegin(), r.best_by_generation.rend()));
    EXPECT_EQ(r.evaluations, 1000 + 950 * std::int64_t{r.generations});
  }
}

INSTANTIATE_TEST_SUITE_P(Benchmarks, Genetic,
                         testing::Values(test::branin_benchmark(), test::hartmann6_benchmark(),
                                         test::rastrigin_benchmark()),
                         [](const auto& p) { return std::string(p.param.name); });

TEST(Genetic, GivesTheSameBitsForOneSeedAndOthersForAnother) {
  const test::Benchmark b = test::branin_benchmark();
  const GeneticOptions options{.population = 60, .max_generations = 20, .seed = 8};
  const GeneticResult first = minimize_genetic(by_rows(b.value), b.bounds, options);
  const GeneticResult second = minimize_genetic(by_rows(b.value), b.bounds, options);
  EXPECT_EQ(first.x, second.x);
  EXPECT_EQ(first.best_by_generation, second.best_by_generation);
  GeneticOptions other = options;
  other.seed = 9;
  EXPECT_NE(first.x, minimize_genetic(by_rows(b.value), b.bounds, other).x);
}

TEST(Genetic, NeverLeavesTheBoundsAndFindsAMinimumOnThem) {
  const Bounds box{Vector{{1.0, -3.0}}, Vector{{2.0, -2.0}}};
  const BatchObjective slope = [&](const Matrix& rows) -> Vector {
    for (Eigen::Index i = 0; i < rows.rows(); ++i)
      for (Eigen::Index k = 0; k < 2; ++k)
        if (rows(i, k) < box.lower[k] || rows(i, k) > box.upper[k]) ADD_FAILURE() << rows.row(i);
    return rows.col(0) - rows.col(1);
  };
  const GeneticResult r = minimize_genetic(slope, box, {.population = 50, .max_generations = 200});
  EXPECT_NEAR(r.value, 3.0, 1e-3);
}

TEST(Genetic, AvoidsValuesThatAreNotFinite) {
  const BatchObjective holed = [](const Matrix& rows) -> Vector {
    return (rows.col(0).array() < 0.5).select(std::nan(""), rows.col(0).array());
  };
  const GeneticResult r = minimize_genetic(holed, unit_cube(2), {.population = 50});
  EXPECT_NEAR(r.value, 0.5, 1e-3);
  const BatchObjective nowhere = [](const Matrix& rows) -> Vector {
    return Vector::Constant(rows.rows(), std::nan(""));
  };
  const GeneticOptions brief{.population = 10, .max_generations = 3};
  EXPECT_EQ(minimize_genetic(nowhere, unit_cube(2), brief).termination, Termination::failed);
}

TEST(Genetic, SaysWhenItsGenerationsAreUsedUp) {
  const test::Benchmark b = test::rastrigin_benchmark();
  const GeneticResult r = minimize_genetic(by_rows(b.value), b.bounds, {.max_generations = 5});
  EXPECT_EQ(r.termination, Termination::budget);
  EXPECT_EQ(r.generations, 5);
}

TEST(Genetic, RefusesBadOptions) {
  const BatchObjective f = by_rows(test::branin);
  EXPECT_THROW(minimize_genetic(f, unit_cube(2), {.population = 1}), InputError);
  EXPECT_THROW(minimize_genetic(f, unit_cube(2), {.mutation_probability = 1.5}), InputError);
  const BatchObjective shorter = [](const Matrix&) { return Vector::Zero(3); };
  EXPECT_THROW(minimize_genetic(shorter, unit_cube(2), {}), InputError);
}

}  // namespace
}  // namespace repose::opt

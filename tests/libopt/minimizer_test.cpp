// Minimisers: known optima, bounds, bad values, failures, reproducibility.
#include "repose/opt/minimizer.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "functions.hpp"
#include "repose/base/error.hpp"

namespace repose::opt {
namespace {

double rosenbrock(const Vector& x, Vector* g) {
  double sum = 0.0;
  if (g != nullptr) g->setZero();
  for (Eigen::Index i = 0; i + 1 < x.size(); ++i) {
    const double a = x[i + 1] - x[i] * x[i];
    const double b = 1.0 - x[i];
    sum += 100.0 * a * a + b * b;
    if (g != nullptr) {
      (*g)[i] += -400.0 * a * x[i] - 2.0 * b;
      (*g)[i + 1] += 200.0 * a;
    }
  }
  return sum;
}

const Bounds kBox{Vector::Constant(3, -2.0), Vector::Constant(3, 2.0)};
const Vector kStart = Vector::Constant(3, -1.2);

class LocalMinimizer : public testing::TestWithParam<Algorithm> {};

TEST_P(LocalMinimizer, FindsTheBottomOfRosenbrocksValley) {
  const Minimum m = minimize(rosenbrock, kStart, kBox, {.algorithm = GetParam()});
  EXPECT_LT((m.x - Vector::Ones(3)).cwiseAbs().maxCoeff(), 1e-5) << m.message;
  EXPECT_NE(m.termination, Termination::failed);
  EXPECT_LE(m.evaluations, 2000);
  EXPECT_EQ(m.value, rosenbrock(m.x, nullptr));
}

TEST_P(LocalMinimizer, StopsAtTheBoundThatIsInTheWay) {
  const Bounds box{Vector{{-2.0, -2.0, -2.0}}, Vector{{0.5, 2.0, 2.0}}};
  const Minimum m = minimize(rosenbrock, kStart, box, {.algorithm = GetParam()});
  EXPECT_NEAR(m.x[0], 0.5, 1e-6) << m.message;
  EXPECT_NEAR(m.x[1], 0.25, 0.02);  // f is flat there: the remaining coordinates follow the valley
}

TEST_P(LocalMinimizer, TurnsAwayFromValuesThatAreNotFinite) {
  const Objective holed = [](const Vector& x, Vector* g) {
    if (x[0] > 1.1) return std::numeric_limits<double>::quiet_NaN();
    return rosenbrock(x, g);
  };
  const Minimum m = minimize(holed, kStart, kBox, {.algorithm = GetParam()});
  EXPECT_TRUE(std::isfinite(m.value));
  EXPECT_LT(m.value, 0.1 * rosenbrock(kStart, nullptr));
}

TEST_P(LocalMinimizer, KeepsTheBestPointOfASmallBudget) {
  double smallest = std::numeric_limits<double>::infinity();
  const Objective watched = [&](const Vector& x, Vector* g) {
    const double value = rosenbrock(x, g);
    smallest = std::min(smallest, value);
    return value;
  };
  const Minimum m =
      minimize(watched, kStart, kBox, {.algorithm = GetParam(), .max_evaluations = 9});
  EXPECT_EQ(m.termination, Termination::budget);
  EXPECT_LE(m.evaluations, 9);
  EXPECT_EQ(m.value, smallest);
}

INSTANTIATE_TEST_SUITE_P(All, LocalMinimizer,
                         testing::Values(Algorithm::lbfgs, Algorithm::slsqp, Algorithm::bobyqa));

class GlobalMinimizer : public testing::TestWithParam<Algorithm> {};

TEST_P(GlobalMinimizer, FindsBraninsMinimumFromTheWrongCorner) {
  const test::Benchmark b = test::branin_benchmark();
  const Objective f = [](const Vector& x, Vector*) { return test::branin(x); };
  const MinimizerOptions options{.algorithm = GetParam(), .max_evaluations = 20000, .seed = 3};
  const Minimum m = minimize(f, b.bounds.lower, b.bounds, options);
  EXPECT_NEAR(m.value, b.minimum, 1e-4) << m.message;
  const Minimum again = minimize(f, b.bounds.lower, b.bounds, options);
  EXPECT_EQ(again.x, m.x);
  EXPECT_EQ(again.evaluations, m.evaluations);
}

INSTANTIATE_TEST_SUITE_P(All, GlobalMinimizer,
                         testing::Values(Algorithm::crs2, Algorithm::direct_l, Algorithm::isres));

TEST(Minimize, ProjectsTheStartAndAcceptsFixedCoordinates) {
  const Bounds box{Vector{{0.0, 0.7, -2.0}}, Vector{{2.0, 0.7, 2.0}}};
  for (const Algorithm a : {Algorithm::lbfgs, Algorithm::slsqp, Algorithm::bobyqa}) {
    const Minimum m = minimize(rosenbrock, Vector::Constant(3, 50.0), box, {.algorithm = a});
    EXPECT_EQ(m.x[1], 0.7);
    EXPECT_LT(m.value, 0.3) << m.message;
  }
}

TEST(Minimize, WorksInOneDimension) {
  const Objective f = [](const Vector& x, Vector* g) {
    if (g != nullptr) (*g)[0] = 2.0 * (x[0] - 0.3);
    return (x[0] - 0.3) * (x[0] - 0.3);
  };
  for (const Algorithm a : {Algorithm::lbfgs, Algorithm::slsqp, Algorithm::bobyqa})
    EXPECT_NEAR(minimize(f, Vector::Zero(1), unit_cube(1), {.algorithm = a}).x[0], 0.3, 1e-6);
}

TEST(Minimize, SaysWhenNothingIsFinite) {
  const Objective nowhere = [](const Vector&, Vector*) { return std::nan(""); };
  const Minimum m = minimize(nowhere, kStart, kBox);
  EXPECT_EQ(m.termination, Termination::failed);
  EXPECT_TRUE(std::isinf(m.value));
}

TEST(Minimize, FallsBackWhereAMethodGivesUp) {
  // a kinked valley: line searches with gradients stall on its floor, bobyqa goes on
  const Objective kinked = [](const Vector& x, Vector* g) {
    const double a = x[0] - x[1];
    const double b = x[0] + x[1] - 1.0;
    if (g != nullptr)
      *g = Vector{{std::copysign(10.0, a) + std::copysign(1.0, b),
                   -std::copysign(10.0, a) + std::copysign(1.0, b), 0.0}};
    return 10.0 * std::abs(a) + std::abs(b);
  };
  const Minimum m = minimize(kinked, Vector{{-1.0, 1.5, 0.0}}, kBox);
  EXPECT_EQ(m.message.find("lbfgs"), std::string::npos) << m.message;
  EXPECT_LT(m.value, 1e-2) << m.message;
}

TEST(Minimize, LetsExceptionsOfTheObjectivePass) {
  const Objective broken = [](const Vector&, Vector*) -> double {
    throw std::domain_error("mine");
  };
  EXPECT_THROW(minimize(broken, kStart, kBox), std::domain_error);
}

TEST(Minimize, RefusesBadArguments) {
  EXPECT_THROW(minimize(rosenbrock, Vector::Zero(2), kBox), InputError);
  EXPECT_THROW(minimize(rosenbrock, kStart, {kBox.upper, kBox.lower}), InputError);
  EXPECT_THROW(minimize(rosenbrock, kStart, kBox, {.max_evaluations = 0}), InputError);
}

TEST(MultiStart, FindsTheBestOfItsStartsForAnyNumberOfThreads) {
  const Objective f = [](const Vector& x, Vector*) { return test::rastrigin(x); };
  const Bounds box{Vector::Constant(2, -5.12), Vector::Constant(2, 5.12)};
  Matrix starts(6, 2);
  for (Eigen::Index i = 0; i < 6; ++i) starts.row(i) << double(i) - 4.0, 3.0 - double(i);
  const BuiltinMinimizer method{{.algorithm = Algorithm::bobyqa, .initial_step = 0.01}};
  const Minimum one = multi_start(f, starts, box, method, 1);
  EXPECT_LE(one.value, 2.0);  // (0, -1) is among the starts, one valley from the bottom
  for (Eigen::Index i = 0; i < 6; ++i)
    EXPECT_LE(one.value, method.minimize(f, starts.row(i), box).value);
  for (const unsigned threads : {2u, 4u}) {
    const Minimum many = multi_start(f, starts, box, method, threads);
    EXPECT_EQ(many.x, one.x);
    EXPECT_EQ(many.evaluations, one.evaluations);
  }
}

TEST(Minimizer, IsAnythingThatMinimizes) {
  struct Stubborn {
    Minimum minimize(const Objective& f, const Vector& x, const Bounds&) const {
      return {x, f(x, nullptr), Termination::budget, "did not move", 1, 0.0};
    }
  };
  const Minimizer mine = Stubborn{};
  const Minimizer copy = mine;
  EXPECT_EQ(copy.minimize(rosenbrock, kStart, kBox).x, kStart);
  EXPECT_LT(Minimizer().minimize(rosenbrock, kStart, kBox).value, 1e-8);
}

}  // namespace
}  // namespace repose::opt

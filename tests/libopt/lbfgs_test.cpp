// The quasi-Newton method of the library: optimality certified by the gradient, units, rounding.
#include <gtest/gtest.h>

#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::opt {
namespace {

struct Quadratic {
  Matrix h;
  Vector g;
  double operator()(const Vector& x, Vector* gradient) const {
    const Vector hx = h * x;
    if (gradient != nullptr) *gradient = hx - g;
    return 0.5 * x.dot(hx) - g.dot(x);
  }
};

Quadratic random_quadratic(Eigen::Index d, double condition, RandomStream& random) {
  Matrix root(d, d);
  for (double& value : root.reshaped()) value = random.normal();
  Quadratic q{Matrix::Zero(d, d), Vector(d)};
  for (Eigen::Index k = 0; k < d; ++k)
    q.h += std::pow(condition, -double(k) / double(d - 1)) * root.col(k) * root.col(k).transpose();
  for (double& value : q.g) value = random.normal();
  return q;
}

// A convex function is smallest in a box where no step along the negative gradient stays inside.
TEST(Lbfgs, EndsWhereTheProjectedGradientOfAConvexFunctionVanishes) {
  RandomStream random(11);
  const Bounds box{Vector::Constant(6, -0.7), Vector::Constant(6, 1.1)};
  int held = 0;
  for (int i = 0; i < 200; ++i) {
    const Quadratic q = random_quadratic(6, 1e3, random);
    Vector start(6);  // a corner every other time
    for (double& value : start) {
      const double u = random.uniform(-0.7, 1.1);
      value = i % 2 == 0 ? u : (u < 0.2 ? -0.7 : 1.1);
    }
    const Minimum m = minimize(q, start, box);
    EXPECT_EQ(m.termination, Termination::converged) << m.message;
    EXPECT_EQ(m.message.find("lbfgs"), 0u) << i << ": " << m.message;
    Vector gradient(6);
    q(m.x, &gradient);
    const Vector step = project(m.x - gradient, box) - m.x;
    EXPECT_LT(step.cwiseAbs().maxCoeff(), 2e-4) << i;  // sqrt(1e-12 |f| 2 L), f and L of some tens
    held += static_cast<int>((m.x.array() == -0.7 || m.x.array() == 1.1).count());
  }
  EXPECT_GT(held, 200);  // the bounds were in the way
}

// Dividing by powers of two is exact, so that all that changes is the exponent.
TEST(Lbfgs, TakesNoNoticeOfUnits) {
  RandomStream random(12);
  const Quadratic q = random_quadratic(3, 10.0, random);
  const Vector unit{{std::exp2(40), 1.0, std::exp2(-20)}};
  const Objective scaled = [&](const Vector& x, Vector* g) {
    const double value = q(x.cwiseQuotient(unit), g);
    if (g != nullptr) *g = g->cwiseQuotient(unit).eval();
    return value;
  };
  const Bounds box{Vector::Constant(3, -3.0), Vector::Constant(3, 5.0)};
  const Minimum one = minimize(q, Vector::Ones(3), box);
  const Minimum other =
      minimize(scaled, unit, {box.lower.cwiseProduct(unit), box.upper.cwiseProduct(unit)});
  EXPECT_EQ(other.x.cwiseQuotient(unit), one.x);
  EXPECT_EQ(other.evaluations, one.evaluations);
}

TEST(Lbfgs, AsksOnceWhereNothingGoesDown) {
  const Objective flat = [](const Vector&, Vector* g) {
    if (g != nullptr) g->setZero();
    return 3.0;
  };
  const Minimum m = minimize(flat, Vector::Constant(2, 0.5), unit_cube(2));
  EXPECT_EQ(m.termination, Termination::converged);
  EXPECT_EQ(m.evaluations, 1);
  const Objective slope = [](const Vector& x, Vector* g) {
    if (g != nullptr) g->setOnes();
    return x.sum();
  };
  EXPECT_EQ(minimize(slope, Vector::Zero(2), unit_cube(2)).evaluations, 1);  // the best corner
  EXPECT_EQ(minimize(slope, Vector::Ones(2), unit_cube(2)).x, Vector::Zero(2));
}

// Values with noise of 1e-9 of their size, as a determinant of an ill-conditioned matrix has.
TEST(Lbfgs, StopsInTheNoiseOfTheValueWithoutUsingUpItsEvaluations) {
  RandomStream random(13);
  for (int i = 0; i < 50; ++i) {
    const Quadratic q = random_quadratic(5, 1e2, random);
    const Objective noisy = [&](const Vector& x, Vector* g) {
      const double value = 100.0 + q(x, g);
      return value + 1e-7 * std::sin(1e9 * value);
    };
    const Bounds box{Vector::Constant(5, -2.0), Vector::Constant(5, 2.0)};
    const Minimum m = minimize(noisy, Vector::Constant(5, -1.5), box);
    const Minimum exact = minimize(q, Vector::Constant(5, -1.5), box);
    EXPECT_NE(m.termination, Termination::budget) << m.message;
    EXPECT_LT(m.evaluations, 300);
    EXPECT_NEAR(m.value, 100.0 + exact.value, 1e-5) << i << ": " << m.message;
  }
}

// The first step goes a tenth of the range at most, and not that far where the curvature says so.
TEST(Lbfgs, TakesTheCurvatureOfTheFirstStepFromItsOption) {
  const auto second_point = [](double curvature) {
    std::vector<double> asked;
    const Objective f = [&](const Vector& x, Vector* g) {
      asked.push_back(x[0]);
      if (g != nullptr) (*g)[0] = x[0];
      return 0.5 * x[0] * x[0];
    };
    minimize(f, Vector::Constant(1, 1.0), {Vector::Constant(1, -8.0), Vector::Constant(1, 8.0)},
             {.initial_curvature = curvature});
    return asked.at(1);
  };
  EXPECT_NEAR(second_point(0.0), 1.0 - 1.6, 1e-15);
  EXPECT_NEAR(second_point(2.0), 0.5, 1e-15);
  EXPECT_NEAR(second_point(0.01), 1.0 - 1.6, 1e-15);
  EXPECT_THROW(second_point(-1.0), InputError);
  EXPECT_THROW(second_point(std::nan("")), InputError);
}

// 20 coordinates: more than one memory's worth of steps.
TEST(Lbfgs, FindsTheBottomOfALongValley) {
  const Objective rosenbrock = [](const Vector& x, Vector* g) {
    double sum = 0.0;
    if (g != nullptr) g->setZero();
    for (Eigen::Index i = 0; i + 1 < x.size(); ++i) {
      const double a = x[i + 1] - x[i] * x[i], b = 1.0 - x[i];
      sum += 100.0 * a * a + b * b;
      if (g == nullptr) continue;
      (*g)[i] += -400.0 * a * x[i] - 2.0 * b;
      (*g)[i + 1] += 200.0 * a;
    }
    return sum;
  };
  const Minimum m = minimize(rosenbrock, Vector::Zero(20),
                             {Vector::Constant(20, -3.0), Vector::Constant(20, 3.0)});
  EXPECT_LT((m.x - Vector::Ones(20)).cwiseAbs().maxCoeff(), 1e-6) << m.message;
  EXPECT_EQ(m.message.find("lbfgs: converged"), 0u) << m.message;
}

// A kink stops it; other methods would go on.
TEST(Lbfgs, EndsThereWithoutAFallback) {
  const Objective roof = [](const Vector& x, Vector* g) {
    if (g != nullptr)
      for (Eigen::Index i = 0; i < x.size(); ++i) (*g)[i] = x[i] > 0.3 ? 1.0 : -2.0;
    return (x.array() > 0.3).select(x.array() - 0.3, 2.0 * (0.3 - x.array())).sum();
  };
  const Bounds box{Vector::Constant(3, -1.0), Vector::Constant(3, 1.0)};
  const Minimum alone = minimize(roof, Vector{{1.0, 0.5, -1.0}}, box, {.fallback = Fallback::none});
  const Minimum followed = minimize(roof, Vector{{1.0, 0.5, -1.0}}, box);
  EXPECT_EQ(alone.message.find("lbfgs: "), 0u) << alone.message;
  EXPECT_NE(followed.message.find("lbfgs: "), 0u) << followed.message;
  EXPECT_LT(alone.evaluations, followed.evaluations);
}

}  // namespace
}  // namespace repose::opt

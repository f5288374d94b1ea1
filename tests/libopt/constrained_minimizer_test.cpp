// Minimisers inside feasible sets: linear constraints against all active sets tried, ties against
// the smaller problem, refusals.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <limits>

#include "functions.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::opt {
namespace {

constexpr Algorithm kAll[] = {Algorithm::lbfgs, Algorithm::slsqp,    Algorithm::bobyqa,
                              Algorithm::crs2,  Algorithm::direct_l, Algorithm::isres};

/// x^2 + 2 y^2 with x + y >= 1.2 in the unit square: 0.96 at (0.8, 0.4).
double bowl(const Vector& x, Vector* g) {
  if (g != nullptr) *g = Vector{{2.0 * x[0], 4.0 * x[1]}};
  return x[0] * x[0] + 2.0 * x[1] * x[1];
}
FeasibleSet above_the_diagonal() {
  return {unit_cube(2), {{"sum", Vector{{-1.0, -1.0}}, -1.2}}};
}

/// x.Hx/2 - g.x over a box and inequalities.
struct QuadraticProgram {
  Matrix h;
  Vector g;
  FeasibleSet set;

  double operator()(const Vector& x, Vector* gradient) const {
    const Vector hx = h * x;
    if (gradient != nullptr) *gradient = hx - g;
    return 0.5 * x.dot(hx) - g.dot(x);
  }
};

QuadraticProgram random_program(RandomStream& random) {
  const Eigen::Index d = 3;
  const auto normal = [&](Eigen::Index rows, Eigen::Index columns) {
    Matrix m(rows, columns);
    for (double& value : m.reshaped()) value = random.normal();
    return m;
  };
  const Matrix root = normal(d, d);
  QuadraticProgram program{root * root.transpose() + 0.1 * Matrix::Identity(d, d),
                           3.0 * normal(d, 1),
                           {{Vector::Constant(d, -1.0), Vector::Constant(d, 2.0)}}};
  const Vector inside = normal(d, 1).cwiseMax(-0.9).cwiseMin(1.9);
  for (int i = 0; i < 3; ++i) {
    const Vector a = normal(d, 1);
    program.set.inequalities.push_back({"", a, a.dot(inside) + 0.1 * random.uniform()});
  }
  return program;
}

/// The slow twin: the minimum on every set of active constraints, the best of those that obey all.
double smallest_by_enumeration(const QuadraticProgram& p) {
  const Eigen::Index d = p.g.size();
  const auto m = static_cast<Eigen::Index>(p.set.inequalities.size());
  Matrix a(m + 2 * d, d);
  Vector b(m + 2 * d);
  for (Eigen::Index i = 0; i < m; ++i) {
    a.row(i) = p.set.inequalities[static_cast<std::size_t>(i)].coefficients;
    b[i] = p.set.inequalities[static_cast<std::size_t>(i)].bound;
  }
  a.middleRows(m, d) = Matrix::Identity(d, d);
  a.bottomRows(d) = -Matrix::Identity(d, d);
  b.segment(m, d) = p.set.bounds.upper;
  b.tail(d) = -p.set.bounds.lower;
  double best = std::numeric_limits<double>::infinity();
  for (unsigned mask = 0; mask < 1u << a.rows(); ++mask) {
    std::vector<Eigen::Index> active;
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      if ((mask >> i & 1u) != 0u) active.push_back(i);
    const auto k = static_cast<Eigen::Index>(active.size());
    if (k > d) continue;
    Matrix kkt = Matrix::Zero(d + k, d + k);
    kkt.topLeftCorner(d, d) = p.h;
    kkt.bottomLeftCorner(k, d) = a(active, Eigen::all);
    kkt.topRightCorner(d, k) = a(active, Eigen::all).transpose();
    Vector right(d + k);
    right << p.g, b(active);
    const Vector x = kkt.colPivHouseholderQr().solve(right).head(d);
    if (x.allFinite() && (a * x - b).maxCoeff() < 1e-9) best = std::min(best, p(x, nullptr));
  }
  return best;
}

TEST(ConstrainedMinimizer, SlsqpFindsTheMinimumOfAnyQuadraticProgram) {
  RandomStream random(31);
  for (int i = 0; i < 300; ++i) {
    const QuadraticProgram program = random_program(random);
    Vector start(3);
    for (double& value : start) value = random.uniform(-1.0, 2.0);
    const Objective asked = [&](const Vector& x, Vector* g) {
      EXPECT_LE(violation(x, program.set), 1e-10) << i;
      return program(x, g);
    };
    const Minimum m = minimize(asked, start, program.set, {.algorithm = Algorithm::slsqp});
    EXPECT_EQ(violation(m.x, program.set), 0.0) << i;
    EXPECT_EQ(m.value, program(m.x, nullptr));
    EXPECT_NEAR(m.value, smallest_by_enumeration(program), 1e-7) << i << ": " << m.message;
  }
}

TEST(ConstrainedMinimizer, IsresFindsTheMinimumWithoutGradientAndAsksForFeasiblePointsOnly) {
  int asked = 0;
  const Objective f = [&](const Vector& x, Vector*) {
    ++asked;
    EXPECT_GE(x.sum(), 1.2 - 1e-9);
    return bowl(x, nullptr);
  };
  const Minimum m = minimize(f, Vector::Zero(2), above_the_diagonal(),
                             {.algorithm = Algorithm::isres, .max_evaluations = 20000});
  EXPECT_NEAR(m.value, 0.96, 1e-4) << m.message;
  EXPECT_EQ(violation(m.x, above_the_diagonal()), 0.0);
  EXPECT_EQ(m.evaluations, asked);
  EXPECT_NE(m.message.find("20000 points"), std::string::npos) << m.message;
}

TEST(ConstrainedMinimizer, StartsAtTheNearestPointThatObeysTheConstraints) {
  Vector first;
  const Objective f = [&](const Vector& x, Vector* g) {
    if (first.size() == 0) first = x;
    return bowl(x, g);
  };
  minimize(f, Vector{{0.1, 0.5}}, above_the_diagonal(), {.algorithm = Algorithm::slsqp});
  EXPECT_LT((first - Vector{{0.4, 0.8}}).cwiseAbs().maxCoeff(), 1e-12) << first.transpose();
}

// a <= b <= a as two inequalities: the feasible set is a line.
TEST(ConstrainedMinimizer, FollowsALineGivenByTwoOppositeInequalities) {
  const FeasibleSet line{unit_cube(2),
                         {{"", Vector{{1.0, -1.0}}, 0.1}, {"", Vector{{-1.0, 1.0}}, -0.1}}};
  const Objective f = [](const Vector& x, Vector* g) { return bowl(x - Vector{{0.5, 0.7}}, g); };
  const Minimum m = minimize(f, Vector{{0.9, 0.9}}, line, {.algorithm = Algorithm::slsqp});
  // with x = y + 0.1: (y - 0.4)^2 + 2 (y - 0.7)^2, least at y = 0.6
  EXPECT_LT((m.x - Vector{{0.7, 0.6}}).cwiseAbs().maxCoeff(), 1e-6) << m.x.transpose();
  EXPECT_EQ(violation(m.x, line), 0.0);
}

TEST(ConstrainedMinimizer, WithoutConstraintsIsTheSearchOfTheBox) {
  const test::Benchmark b = test::branin_benchmark();
  const Objective f = [](const Vector& x, Vector*) { return test::branin(x); };
  for (const Algorithm a : kAll) {
    const MinimizerOptions options{.algorithm = a, .max_evaluations = 300};
    const Minimum box = minimize(f, b.bounds.upper, b.bounds, options);
    const Minimum set = minimize(f, b.bounds.upper, FeasibleSet{b.bounds}, options);
    EXPECT_EQ(set.x, box.x);
    EXPECT_EQ(set.evaluations, box.evaluations);
  }
}

// x2 = 1 - 2 x0 in [0, 1] leaves x0 in [0, 0.5]; by hand the same search, to the bit.
TEST(ConstrainedMinimizer, MovesTheLeadersOfTiesAlone) {
  FeasibleSet set{unit_cube(3)};
  set.ties = {{2, 0, -2.0, 1.0}};
  const Objective f = [](const Vector& x, Vector* g) {
    if (g != nullptr) *g = Vector{{x[0] - 0.7 + x[1], 2.0 * x[1] - 0.4 + x[0], x[2] - 0.6}};
    return 0.5 * (std::pow(x[0] - 0.7, 2) + std::pow(x[2] - 0.6, 2)) + std::pow(x[1] - 0.2, 2) +
           x[0] * x[1];
  };
  const Objective by_hand = [&](const Vector& y, Vector* g) {
    Vector full(3);
    const double value = f(Vector{{y[0], y[1], 1.0 - 2.0 * y[0]}}, g != nullptr ? &full : nullptr);
    if (g != nullptr) *g = Vector{{full[0] - 2.0 * full[2], full[1]}};
    return value;
  };
  const Bounds leaders{Vector::Zero(2), Vector{{0.5, 1.0}}};
  for (const Algorithm a : kAll) {
    const MinimizerOptions options{.algorithm = a, .max_evaluations = 400};
    const Minimum full = minimize(f, Vector{{0.1, 0.9, 0.5}}, set, options);
    const Minimum small = minimize(by_hand, Vector{{0.1, 0.9}}, leaders, options);
    EXPECT_EQ(full.value, small.value);
    EXPECT_EQ(full.x, (Vector{{small.x[0], small.x[1], 1.0 - 2.0 * small.x[0]}}));
    EXPECT_EQ(full.evaluations, small.evaluations);
  }
}

TEST(ConstrainedMinimizer, TiesMayCarryConstraints) {
  FeasibleSet set{unit_cube(2), {{"sum", Vector{{-1.0, -1.0}}, -1.2}}};
  set.ties = {{1, 0}};
  const Minimum m = minimize(bowl, Vector::Zero(2), set, {.algorithm = Algorithm::slsqp});
  EXPECT_LT((m.x - Vector{{0.6, 0.6}}).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(violation(m.x, set), 0.0);
}

// Each constraint has points that obey it, both together have none.
TEST(ConstrainedMinimizer, SaysWhenNoPointObeysAllConstraints) {
  FeasibleSet set = above_the_diagonal();
  set.inequalities.push_back({"most", Vector{{1.0, 1.0}}, 1.1});
  for (const Algorithm a : {Algorithm::slsqp, Algorithm::isres}) {
    const Minimum m = minimize(bowl, Vector::Zero(2), set, {.algorithm = a});
    EXPECT_EQ(m.termination, Termination::failed);
    EXPECT_TRUE(std::isinf(m.value));
    EXPECT_EQ(m.evaluations, 0);
    EXPECT_NE(m.message.find("no point was found that obeys all constraints"), std::string::npos);
    EXPECT_TRUE(m.message.find("sum is") != std::string::npos ||
                m.message.find("most is") != std::string::npos)
        << m.message;
  }
}

TEST(ConstrainedMinimizer, RefusesByNameWhatAMethodCannotDo) {
  const auto expect_refused = [](const FeasibleSet& set, Algorithm a, const char* what) {
    try {
      minimize(bowl, Vector::Zero(2), set, {.algorithm = a});
      FAIL() << what;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    }
  };
  for (const Algorithm a :
       {Algorithm::lbfgs, Algorithm::bobyqa, Algorithm::crs2, Algorithm::direct_l})
    expect_refused(above_the_diagonal(), a, "takes no linear constraints; slsqp");
  FeasibleSet whole{unit_cube(2)};
  whole.whole = {1};
  for (const Algorithm a : kAll)
    expect_refused(whole, a, "coordinate 2 is to be a whole number, which");
  FeasibleSet impossible = above_the_diagonal();
  impossible.inequalities[0].bound = -2.1;
  expect_refused(impossible, Algorithm::slsqp, "constraint sum: no point of the box is below");
}

TEST(ConstrainedMultiStart, GivesTheSameBitsForAnyNumberOfThreads) {
  RandomStream random(5);
  const QuadraticProgram program = random_program(random);
  Matrix starts(5, 3);
  for (double& value : starts.reshaped()) value = random.uniform(-1.0, 2.0);
  const MinimizerOptions options{.algorithm = Algorithm::slsqp};
  const Minimum one = multi_start(program, starts, program.set, options);
  const Minimum four = multi_start(program, starts, program.set, options, 4);
  EXPECT_EQ(one.x, four.x);
  EXPECT_EQ(one.evaluations, four.evaluations);
  EXPECT_NEAR(one.value, smallest_by_enumeration(program), 1e-7);
}

}  // namespace
}  // namespace repose::opt

// Batches of proposals, with a surrogate small enough to see through.
#include "repose/opt/propose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/acquisition.hpp"

namespace repose::opt {
namespace {

/// Simple kriging with a squared exponential of length 0.2 and unit variance, mean 0.
class ToySurrogate {
 public:
  ToySurrogate(Matrix x, Vector y, double noise = 1e-10)
      : x_(std::move(x)), y_(std::move(y)), noise_(noise) {
    Matrix k = kernel(x_, x_);
    k.diagonal().array() += noise_;
    llt_.compute(k);
    alpha_ = llt_.solve(y_);
  }
  Gaussian predict(const Vector& x) const {
    if (x_.rows() == 0) return {0.0, 1.0};
    const Vector k = kernel(x_, x.transpose()).col(0);
    return {k.dot(alpha_), std::max(0.0, 1.0 - k.dot(llt_.solve(k)))};
  }
  std::vector<Gaussian> predict_rows(const Matrix& rows) const {
    std::vector<Gaussian> all;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) all.push_back(predict(rows.row(i)));
    return all;
  }
  PredictionGradient predict_gradient(const Vector& x) const {
    PredictionGradient g{.function = predict(x), .mean = x, .standard_deviation = x};
    const Vector k = kernel(x_, x.transpose()).col(0);
    for (Eigen::Index p = 0; p < x.size(); ++p) {
      const Vector slope = k.cwiseProduct(x_.col(p) - Vector::Constant(k.size(), x[p])) / 0.04;
      g.mean[p] = slope.dot(alpha_);
      const double sd = g.function.standard_deviation();
      g.standard_deviation[p] = sd > 0.0 ? -slope.dot(llt_.solve(k)) / sd : 0.0;
    }
    return g;
  }
  Matrix covariance(const Matrix& a, const Matrix& b) const {
    return kernel(a, b) - kernel(a, x_) * llt_.solve(kernel(x_, b));
  }
  ToySurrogate condition_on(const Vector& x, double y) const {
    Matrix more(x_.rows() + 1, x.size());
    more << x_, x.transpose();
    Vector values(y_.size() + 1);
    values << y_, y;
    return {more, values, noise_};
  }

 private:
  static Matrix kernel(const Matrix& a, const Matrix& b) {
    Matrix k(a.rows(), b.rows());
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      for (Eigen::Index j = 0; j < b.rows(); ++j)
        k(i, j) = std::exp(-0.5 * (a.row(i) - b.row(j)).squaredNorm() / 0.04);
    return k;
  }
  Matrix x_;
  Vector y_;
  double noise_;
  Eigen::LLT<Matrix> llt_;
  Vector alpha_;
};

FeasibleSet cube(Eigen::Index dimension) {
  return {unit_cube(dimension)};
}

double bowl(const Vector& x) {
  return 10.0 * (x - Vector::Constant(x.size(), 0.62)).squaredNorm() - 1.0;
}

struct Known {
  Matrix x = scrambled_uniforms(12, 2, 3);
  ToySurrogate model{x, values()};
  Vector values() const {
    Vector y(x.rows());
    for (Eigen::Index i = 0; i < x.rows(); ++i) y[i] = bowl(x.row(i));
    return y;
  }
};

double smallest_distance(const Matrix& a, const Matrix& b) {
  double smallest = 1.0;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.rows(); ++j)
      if (&a != &b || i != j)
        smallest = std::min(smallest, (a.row(i) - b.row(j)).cwiseAbs().maxCoeff());
  return smallest;
}

TEST(ProposeBatch, FirstPointHasTheLargestExpectedImprovementOfAFineGrid) {
  const Known known;
  const Proposal p = propose_batch(known.model, cube(2), 1, {.visited = known.x});
  const double best = known.values().minCoeff();
  double largest = -1e300;
  for (int i = 0; i <= 100; ++i)
    for (int j = 0; j <= 100; ++j)
      largest = std::max(largest, log_expected_improvement(
                                      known.model.predict(Vector{{i / 100.0, j / 100.0}}), best));
  // the incumbent is a posterior mean: it differs from the datum by the toy's jitter
  EXPECT_GE(p.merit[0], largest - 1e-6);
  EXPECT_NEAR(p.merit[0], log_expected_improvement(known.model.predict(p.points.row(0)), best),
              1e-6);
  EXPECT_NEAR(p.predicted[0].mean, known.model.predict(p.points.row(0)).mean, 1e-12);
}

TEST(ProposeBatch, KeepsItsPointsApartAndInsideTheCube) {
  const Known known;
  const Matrix pending = propose_batch(known.model, cube(2), 2, {.visited = known.x}).points;
  const Proposal p =
      propose_batch(known.model, cube(2), 6, {.visited = known.x, .pending = pending});
  EXPECT_EQ(p.points.rows(), 6);
  EXPECT_GE(p.points.minCoeff(), 0.0);
  EXPECT_LE(p.points.maxCoeff(), 1.0);
  EXPECT_GE(smallest_distance(p.points, p.points), 1e-3);
  EXPECT_GE(smallest_distance(p.points, known.x), 1e-3);
  EXPECT_GE(smallest_distance(p.points, pending), 1e-3);
}

TEST(ProposeBatch, BelievesPendingPointsAsItBelievesItsOwn) {
  const Known known;
  const Proposal two =
      propose_batch(known.model, cube(2), 2, {.visited = known.x, .candidates = 4000});
  const Proposal second =
      propose_batch(known.model, cube(2), 1,
                    {.visited = known.x, .pending = two.points.topRows(1), .candidates = 4000});
  // other candidates, the same maximum: the polished point agrees to its tolerance
  EXPECT_NEAR(second.merit[0], two.merit[1], 1e-3);
}

TEST(ProposeBatch, GivesTheSameBitsForAnyNumberOfThreads) {
  const Known known;
  const std::vector<Target> targets{{.name = "a", .value = -0.9}, {.name = "b", .value = 0.3}};
  const std::vector<Surrogate> kpis{known.model, ToySurrogate(known.x, 0.5 * known.values())};
  ProposeOptions options{.visited = known.x, .seed = 5};
  const Proposal one = propose_batch(kpis, targets, cube(2), 3, options);
  options.threads = 4;
  EXPECT_EQ(one.points, propose_batch(kpis, targets, cube(2), 3, options).points);
  options.acquisition = Acquisition::noisy_expected_improvement;
  options.repeats = Repeats::deliberate;
  const Proposal four = propose_batch(kpis, targets, cube(2), 2, options);
  options.threads = 1;
  const Proposal again = propose_batch(kpis, targets, cube(2), 2, options);
  EXPECT_EQ(four.points, again.points);
  EXPECT_EQ(four.merit, again.merit);
}

TEST(ProposeBatch, SpreadsOutWhereEverythingIsKnownForCertain) {
  struct Certain {
    Gaussian predict(const Vector&) const { return {1.0, 0.0}; }
    std::vector<Gaussian> predict_rows(const Matrix& rows) const {
      return std::vector<Gaussian>(static_cast<std::size_t>(rows.rows()), Gaussian{1.0, 0.0});
    }
    Certain condition_on(const Vector&, double) const { return *this; }
  };
  const Matrix corner{{0.0, 0.0}};
  const Proposal p = propose_batch(Certain{}, cube(2), 2, {.visited = corner});
  EXPECT_GT((p.points.row(0) - corner.row(0)).cwiseAbs().maxCoeff(),
            0.9);  // farthest from all known
  EXPECT_GT(smallest_distance(p.points, p.points), 0.3);
}

TEST(ProposeBatch, WorksBeforeAnythingIsKnown) {
  const ToySurrogate nothing(Matrix(0, 3), Vector(0));
  const Proposal p = propose_batch(nothing, cube(3), 4, {});
  EXPECT_TRUE(p.points.allFinite());
  EXPECT_GE(smallest_distance(p.points, p.points), 1e-3);
}

TEST(ProposeBatch, MayRepeatAPointWhenAsked) {
  // the whole cube is within minimum_distance of the one known point
  const ToySurrogate model(Matrix{{0.5}}, Vector{{0.0}});
  ProposeOptions options{
      .visited = Matrix{{0.5}}, .repeats = Repeats::allow, .minimum_distance = 1.0};
  EXPECT_TRUE(std::isfinite(propose_batch(model, cube(1), 1, options).merit[0]));
  options.repeats = Repeats::avoid;
  EXPECT_TRUE(std::isinf(propose_batch(model, cube(1), 1, options).merit[0]));  // still an answer
}

/// ToySurrogate without its derivatives.
struct Underivable {
  ToySurrogate model;
  Gaussian predict(const Vector& x) const { return model.predict(x); }
  std::vector<Gaussian> predict_rows(const Matrix& rows) const { return model.predict_rows(rows); }
  Underivable condition_on(const Vector& x, double y) const { return {model.condition_on(x, y)}; }
};

TEST(ProposeBatch, FindsTheSameWithAndWithoutGradient) {
  static_assert(HasGradient<ToySurrogate> && !HasGradient<Underivable>);
  const Known known;
  const Proposal with = propose_batch(known.model, cube(2), 1, {.visited = known.x});
  const Proposal without =
      propose_batch(Underivable{known.model}, cube(2), 1, {.visited = known.x});
  EXPECT_NEAR(with.merit[0], without.merit[0], 1e-6);
  EXPECT_LT((with.points - without.points).cwiseAbs().maxCoeff(), 1e-3);
}

/// Eight noisy observations of a bowl, enough noise that the best one is in doubt.
struct NoisyKnown {
  Matrix x = scrambled_uniforms(8, 2, 4);
  ToySurrogate model{x, values(), 0.3};
  Vector values() const {
    RandomStream random(8);
    Vector y(x.rows());
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      y[i] = 0.4 * bowl(x.row(i)) + std::sqrt(0.3) * random.normal();
    return y;
  }
};

TEST(NoisyExpectedImprovement, EqualsTheMeanOverJointDrawsOfVisitedAndNewPoint) {
  const NoisyKnown known;
  const Proposal p = propose_batch(
      known.model, cube(2), 1,
      {.visited = known.x, .acquisition = Acquisition::noisy_expected_improvement, .draws = 8192});
  const Eigen::Index n = known.x.rows();
  Matrix all(n + 1, 2);
  all << known.x, p.points;
  Matrix covariance = known.model.covariance(all, all);
  covariance.diagonal().array() += 1e-12;
  const Matrix l = covariance.llt().matrixL();
  Vector mean(n + 1);
  for (Eigen::Index i = 0; i <= n; ++i) mean[i] = known.model.predict(all.row(i)).mean;
  RandomStream random(77);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kDraws = 400000;
  for (int m = 0; m < kDraws; ++m) {
    Vector z(n + 1);
    for (double& value : z) value = random.normal();
    const Vector f = mean + l.triangularView<Eigen::Lower>() * z;
    const double gain = std::max(0.0, f.head(n).minCoeff() - f[n]);
    sum += gain;
    squares += gain * gain;
  }
  const double expected = sum / kDraws;
  const double deviation = std::sqrt(squares / kDraws - expected * expected);
  // four standard errors of both sides; conditioning leaves 8192 draws less spread than the plain
  EXPECT_NEAR(std::exp(p.merit[0]), expected,
              4.0 * deviation * (1.0 / std::sqrt(kDraws) + 1.0 / std::sqrt(8192.0)));
  EXPECT_GT(expected, 20.0 * deviation / std::sqrt(8192.0));  // the bound above says something
}

TEST(NoisyExpectedImprovement, IsExpectedImprovementWhereVisitedValuesAreCertain) {
  const Known known;
  const Proposal noisy =
      propose_batch(known.model, cube(2), 1,
                    {.visited = known.x, .acquisition = Acquisition::noisy_expected_improvement});
  const Proposal plain = propose_batch(known.model, cube(2), 1, {.visited = known.x});
  EXPECT_NEAR(noisy.merit[0], plain.merit[0], 1e-3);  // what is left is the surrogate's 1e-10 noise
}

TEST(NoisyExpectedImprovement, OfTwoQuantitiesOnTargetEqualsTheMeanOverTheirJointDraws) {
  const NoisyKnown known;
  const ToySurrogate other(known.x, known.x.rowwise().sum(), 0.05);
  const std::vector<Surrogate> kpis{known.model, other};
  const std::vector<Target> targets{{.name = "a", .value = -0.5}, {.name = "b", .value = 1.2}};
  const Proposal p = propose_batch(
      kpis, targets, cube(2), 1,
      {.visited = known.x, .acquisition = Acquisition::noisy_expected_improvement, .draws = 8192});
  const Eigen::Index n = known.x.rows();
  Matrix all(n + 1, 2);
  all << known.x, p.points;
  std::vector<Matrix> factor;
  std::vector<Vector> mean;
  for (const ToySurrogate& model : {known.model, other}) {
    Matrix covariance = model.covariance(all, all);
    covariance.diagonal().array() += 1e-12;
    factor.push_back(covariance.llt().matrixL());
    mean.emplace_back(n + 1);
    for (Eigen::Index i = 0; i <= n; ++i) mean.back()[i] = model.predict(all.row(i)).mean;
  }
  RandomStream random(78);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kDraws = 200000;
  for (int m = 0; m < kDraws; ++m) {
    std::vector<Vector> f;
    for (std::size_t j = 0; j < 2; ++j) {
      Vector z(n + 1);
      for (double& value : z) value = random.normal();
      f.emplace_back(mean[j] + factor[j].triangularView<Eigen::Lower>() * z);
    }
    const auto g = [&](Eigen::Index i) {
      return std::abs(f[0][i] + 0.5) / 0.5 + std::abs(f[1][i] - 1.2) / 1.2;
    };
    double best = g(0);
    for (Eigen::Index i = 1; i < n; ++i) best = std::min(best, g(i));
    const double gain = std::max(0.0, best - g(n));
    sum += gain;
    squares += gain * gain;
  }
  const double expected = sum / kDraws;
  const double deviation = std::sqrt(squares / kDraws - expected * expected);
  EXPECT_NEAR(std::exp(p.merit[0]), expected,
              4.0 * deviation * (1.0 / std::sqrt(kDraws) + 1.0 / std::sqrt(8192.0)));
  EXPECT_GT(expected, 10.0 * deviation / std::sqrt(8192.0));
  const ProposeOptions noisy{.visited = known.x,
                             .acquisition = Acquisition::noisy_expected_improvement};
  EXPECT_THROW(propose_batch(Underivable{known.model}, cube(2), 1, noisy), InputError);
}

TEST(ProposeBatch, KeepsItsDistanceFromFailedPoints) {
  const Known known;
  const Matrix best = propose_batch(known.model, cube(2), 1, {.visited = known.x}).points;
  const Proposal p = propose_batch(known.model, cube(2), 3,
                                   {.visited = known.x, .failed = best, .failed_distance = 0.2});
  EXPECT_GE(smallest_distance(p.points, best), 0.2);
  // failures everywhere: still an answer, as far from them as can be, and no promise
  const Matrix everywhere = scrambled_uniforms(400, 2, 9);
  const Proposal none =
      propose_batch(known.model, cube(2), 1, {.visited = known.x, .failed = everywhere});
  EXPECT_TRUE(std::isinf(none.merit[0]));
  EXPECT_GT(smallest_distance(none.points, everywhere), 0.02);
}

TEST(ProposeBatch, ImprovesOnThePointsThatObeyTheConstraintsOnly) {
  const Known known;  // the best visited points lie above the diagonal
  FeasibleSet below = cube(2);
  below.inequalities.push_back({"sum", Vector{{1.0, 1.0}}, 0.8});
  Matrix inside(0, 2);
  for (const auto& row : known.x.rowwise())
    if (row.sum() <= 0.8) {
      inside.conservativeResize(inside.rows() + 1, 2);
      inside.bottomRows(1) = row;
    }
  ASSERT_LT(inside.rows(), known.x.rows());
  double best = 1e300;
  for (const auto& row : inside.rowwise()) best = std::min(best, known.model.predict(row).mean);
  const Proposal p = propose_batch(known.model, below, 1, {.visited = known.x});
  EXPECT_NEAR(p.merit[0], log_expected_improvement(p.predicted[0], best), 1e-9);
}

TEST(ProposeBatch, ClimbsWhereWholeCoordinatesUseUpAConstraint) {
  const Known known;
  const FeasibleSet set{{Vector{{0.0, 0.0}}, Vector{{1.0, 2.0}}},
                        {{"tight", Vector{{0.0, 0.1}}, 0.2}, {"both", Vector{{0.7, 0.1}}, 0.3}},
                        {1}};
  const Proposal p = propose_batch(known.model, set, 4, {});
  for (const auto& row : p.points.rowwise()) EXPECT_LE(0.7 * row[0] + 0.1 * row[1], 0.3 + 1e-12);
}

// The uncertainty of a target is no reason to miss it: sd of |h - t| is 0 where h is certain.
TEST(LowerConfidenceBoundProposal, DoesNotCountTheUncertaintyOfTheTarget) {
  struct Line {  // h = x, known for certain
    Gaussian predict(const Vector& x) const { return {x[0], 0.0}; }
    std::vector<Gaussian> predict_rows(const Matrix& rows) const {
      std::vector<Gaussian> all;
      for (const auto& row : rows.rowwise()) all.push_back(predict(row));
      return all;
    }
    Line condition_on(const Vector&, double) const { return *this; }
  };
  const std::vector<Surrogate> kpis{Line{}};
  const std::vector<Target> targets{{.name = "a", .value = 0.5, .standard_deviation = 0.2}};
  const Proposal p = propose_batch(kpis, targets, cube(1), 1,
                                   {.acquisition = Acquisition::lower_confidence_bound});
  EXPECT_NEAR(p.points(0, 0), 0.5, 1e-3);
}

TEST(LowerConfidenceBoundProposal, HasTheSmallestBoundOfAFineGrid) {
  const Known known;
  const Proposal p = propose_batch(
      known.model, cube(2), 1,
      {.visited = known.x, .acquisition = Acquisition::lower_confidence_bound, .kappa = 1.5});
  double smallest = 1e300;
  for (int i = 0; i <= 100; ++i)
    for (int j = 0; j <= 100; ++j)
      smallest = std::min(
          smallest, lower_confidence_bound(known.model.predict(Vector{{0.01 * i, 0.01 * j}}), 1.5));
  EXPECT_LE(-p.merit[0], smallest + 1e-6);
}

TEST(ConstantLiar, BelievesTheMeanOfTheVisitedPoints) {
  const Known known;
  const Matrix first = propose_batch(known.model, cube(2), 1, {.visited = known.x}).points;
  Matrix all(known.x.rows() + 1, 2);
  all << known.x, first;
  double mean = 0.0;
  for (const auto& row : known.x.rowwise())
    mean += known.model.predict(row).mean / static_cast<double>(known.x.rows());
  const auto told = known.model.condition_on(first.row(0), mean);
  EXPECT_EQ(propose_batch(told, cube(2), 1, {.visited = all}).points,
            propose_batch(known.model, cube(2), 1,
                          {.visited = known.x, .pending = first, .belief = Belief::mean_lie})
                .points);
}

TEST(ConstantLiar, SpreadsABatchTheMoreTheWorseTheLie) {
  const Known known;
  const auto spread = [&](Belief belief) {
    const Matrix p =
        propose_batch(known.model, cube(2), 6, {.visited = known.x, .belief = belief}).points;
    return (p.rowwise() - p.colwise().mean()).norm();
  };
  EXPECT_LT(spread(Belief::best_lie), spread(Belief::worst_lie));
}

TEST(DeliberateRepeats, SettleWhichOfTheBestPointsIsBestBeforeAnyNewOne) {
  // two equally good points known with noise, and nothing to be gained elsewhere
  Matrix x(40, 1);
  Vector y(40);
  for (Eigen::Index i = 0; i < 40; ++i) {
    x(i, 0) = 0.025 * static_cast<double>(i);
    y[i] = 3.0;
  }
  y[8] = y[32] = 0.0;
  const ToySurrogate noisy(x, y, 0.02);
  const Proposal p =
      propose_batch(noisy, cube(1), 1, {.visited = x, .repeats = Repeats::deliberate});
  const Proposal fresh = propose_batch(noisy, cube(1), 1, {.visited = x});
  EXPECT_TRUE(p.repeat[0]);
  EXPECT_GT(p.merit[0], fresh.merit[0]);
  EXPECT_TRUE(p.points(0, 0) == x(8, 0) || p.points(0, 0) == x(32, 0));
  EXPECT_FALSE(fresh.repeat[0]);
  const Known known;
  const ProposeOptions deliberate{.visited = known.x, .repeats = Repeats::deliberate};
  EXPECT_FALSE(
      propose_batch(known.model, cube(2), 1, deliberate).repeat[0]);  // nothing is in doubt
}

TEST(ProposeBatch, ObeysConstraintsAndFindsTheBestPointOnTheirEdge) {
  const Known known;
  FeasibleSet set = cube(2);
  set.inequalities.push_back({"sum", Vector{{1.0, 1.0}}, 0.7});  // the bowl's bottom is outside
  const Proposal p = propose_batch(known.model, set, 3, {.visited = known.x});
  for (const auto& row : p.points.rowwise()) EXPECT_LE(row.sum(), 0.7 + 1e-9);
  double largest = -1e300;
  double best = 1e300;
  for (const auto& row : known.x.rowwise()) best = std::min(best, known.model.predict(row).mean);
  for (int i = 0; i <= 140; ++i)
    for (int j = 0; i + j <= 140; ++j)
      largest = std::max(largest, log_expected_improvement(
                                      known.model.predict(Vector{{0.005 * i, 0.005 * j}}), best));
  EXPECT_GE(p.merit[0], largest - 0.01);
}

TEST(ProposeBatch, KeepsWholeCoordinatesWhole) {
  const Known known;
  FeasibleSet set{{Vector{{0.0, 0.0}}, Vector{{1.0, 3.0}}}, {}, {1}};
  struct Scaled {  // the second coordinate is a third of a unit of ToySurrogate's
    ToySurrogate model;
    static Vector unit(Vector x) {
      x[1] /= 3.0;
      return x;
    }
    Gaussian predict(const Vector& x) const { return model.predict(unit(x)); }
    std::vector<Gaussian> predict_rows(const Matrix& rows) const {
      std::vector<Gaussian> all;
      for (const auto& row : rows.rowwise()) all.push_back(predict(row));
      return all;
    }
    Scaled condition_on(const Vector& x, double y) const {
      return {model.condition_on(unit(x), y)};
    }
  };
  const Matrix visited{{0.1, 1.0}, {0.9, 2.0}, {0.6, 0.0}};
  const Scaled model{known.model};
  const Proposal p = propose_batch(model, set, 4, {.visited = visited});
  for (const auto& row : p.points.rowwise()) EXPECT_EQ(row[1], std::round(row[1]));
  double best = 1e300;
  for (const auto& row : visited.rowwise()) best = std::min(best, model.predict(row).mean);
  double largest = -1e300;
  for (int i = 0; i <= 1000; ++i)
    for (int level = 0; level <= 3; ++level) {
      const Vector x{{0.001 * i, static_cast<double>(level)}};
      largest = std::max(largest, log_expected_improvement(model.predict(x), best));
    }
  EXPECT_GE(p.merit[0], largest - 1e-5);
}

TEST(ProposeBatch, RefusesBadArguments) {
  const Known known;
  EXPECT_THROW(propose_batch(known.model, cube(2), 0, {}), InputError);
  EXPECT_THROW(propose_batch(known.model, cube(0), 1, {}), InputError);
  EXPECT_THROW(propose_batch(known.model, cube(2), 1, {.visited = Matrix::Zero(3, 5)}), InputError);
  const std::vector<Surrogate> kpis{known.model};
  EXPECT_THROW(propose_batch(kpis, std::vector<Target>{}, cube(2), 1, {}), InputError);
  FeasibleSet nowhere = cube(2);  // each alone leaves points, both together none
  nowhere.inequalities = {{"a", Vector{{1.0, 1.0}}, 0.5}, {"b", Vector{{-1.0, -1.0}}, -0.6}};
  EXPECT_THROW(propose_batch(known.model, nowhere, 1, {}), InputError);
  EXPECT_THROW(propose_batch(known.model, cube(2), 1,
                             {.acquisition = Acquisition::lower_confidence_bound,
                              .repeats = Repeats::deliberate}),
               InputError);
}

}  // namespace
}  // namespace repose::opt

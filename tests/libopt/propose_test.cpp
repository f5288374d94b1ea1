// Batches of proposals, with a surrogate small enough to see through.
#include "repose/opt/propose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "repose/base/error.hpp"
#include "repose/opt/acquisition.hpp"

namespace repose::opt {
namespace {

/// Simple kriging with a squared exponential of length 0.2 and unit variance, mean 0, exact data.
class ToySurrogate {
 public:
  ToySurrogate(Matrix x, Vector y) : x_(std::move(x)), y_(std::move(y)) {
    Matrix k = covariance(x_, x_);
    k.diagonal().array() += 1e-10;
    llt_.compute(k);
    alpha_ = llt_.solve(y_);
  }
  Gaussian predict(const Vector& x) const {
    if (x_.rows() == 0) return {0.0, 1.0};
    const Vector k = covariance(x_, x.transpose()).col(0);
    return {k.dot(alpha_), std::max(0.0, 1.0 - k.dot(llt_.solve(k)))};
  }
  std::vector<Gaussian> predict_rows(const Matrix& rows) const {
    std::vector<Gaussian> all;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) all.push_back(predict(rows.row(i)));
    return all;
  }
  ToySurrogate condition_on(const Vector& x, double y) const {
    Matrix more(x_.rows() + 1, x.size());
    more << x_, x.transpose();
    Vector values(y_.size() + 1);
    values << y_, y;
    return {more, values};
  }

 private:
  static Matrix covariance(const Matrix& a, const Matrix& b) {
    Matrix k(a.rows(), b.rows());
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      for (Eigen::Index j = 0; j < b.rows(); ++j)
        k(i, j) = std::exp(-0.5 * (a.row(i) - b.row(j)).squaredNorm() / 0.04);
    return k;
  }
  Matrix x_;
  Vector y_;
  Eigen::LLT<Matrix> llt_;
  Vector alpha_;
};

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
  const Proposal p = propose_batch(known.model, 2, 1, {.visited = known.x});
  const double best = known.values().minCoeff();
  double largest = -1e300;
  for (int i = 0; i <= 100; ++i)
    for (int j = 0; j <= 100; ++j)
      largest = std::max(largest, log_expected_improvement(
                                      known.model.predict(Vector{{i / 100.0, j / 100.0}}), best));
  // the incumbent is a posterior mean: it differs from the datum by the toy's jitter
  EXPECT_GE(p.log_improvement[0], largest - 1e-6);
  EXPECT_NEAR(p.log_improvement[0],
              log_expected_improvement(known.model.predict(p.points.row(0)), best), 1e-6);
  EXPECT_NEAR(p.predicted[0].mean, known.model.predict(p.points.row(0)).mean, 1e-12);
}

TEST(ProposeBatch, KeepsItsPointsApartAndInsideTheCube) {
  const Known known;
  const Matrix pending = propose_batch(known.model, 2, 2, {.visited = known.x}).points;
  const Proposal p = propose_batch(known.model, 2, 6, {.visited = known.x, .pending = pending});
  EXPECT_EQ(p.points.rows(), 6);
  EXPECT_GE(p.points.minCoeff(), 0.0);
  EXPECT_LE(p.points.maxCoeff(), 1.0);
  EXPECT_GE(smallest_distance(p.points, p.points), 1e-3);
  EXPECT_GE(smallest_distance(p.points, known.x), 1e-3);
  EXPECT_GE(smallest_distance(p.points, pending), 1e-3);
}

TEST(ProposeBatch, BelievesPendingPointsAsItBelievesItsOwn) {
  const Known known;
  const Proposal two = propose_batch(known.model, 2, 2, {.visited = known.x, .candidates = 4000});
  const Proposal second =
      propose_batch(known.model, 2, 1,
                    {.visited = known.x, .pending = two.points.topRows(1), .candidates = 4000});
  // other candidates, the same maximum: the polished point agrees to its tolerance
  EXPECT_NEAR(second.log_improvement[0], two.log_improvement[1], 1e-3);
}

TEST(ProposeBatch, GivesTheSameBitsForAnyNumberOfThreads) {
  const Known known;
  const std::vector<Target> targets{{.name = "a", .value = -0.9}, {.name = "b", .value = 0.3}};
  const std::vector<Surrogate> kpis{known.model, ToySurrogate(known.x, 0.5 * known.values())};
  ProposeOptions options{.visited = known.x, .seed = 5};
  const Proposal one = propose_batch(kpis, targets, 2, 3, options);
  options.threads = 4;
  EXPECT_EQ(one.points, propose_batch(kpis, targets, 2, 3, options).points);
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
  const Proposal p = propose_batch(Certain{}, 2, 2, {.visited = corner});
  EXPECT_GT((p.points.row(0) - corner.row(0)).cwiseAbs().maxCoeff(),
            0.9);  // farthest from all known
  EXPECT_GT(smallest_distance(p.points, p.points), 0.3);
}

TEST(ProposeBatch, WorksBeforeAnythingIsKnown) {
  const ToySurrogate nothing(Matrix(0, 3), Vector(0));
  const Proposal p = propose_batch(nothing, 3, 4, {});
  EXPECT_TRUE(p.points.allFinite());
  EXPECT_GE(smallest_distance(p.points, p.points), 1e-3);
}

TEST(ProposeBatch, MayRepeatAPointWhenAsked) {
  // the whole cube is within minimum_distance of the one known point
  const ToySurrogate model(Matrix{{0.5}}, Vector{{0.0}});
  ProposeOptions options{
      .visited = Matrix{{0.5}}, .repeats = Repeats::allow, .minimum_distance = 1.0};
  EXPECT_TRUE(std::isfinite(propose_batch(model, 1, 1, options).log_improvement[0]));
  options.repeats = Repeats::avoid;
  EXPECT_TRUE(
      std::isinf(propose_batch(model, 1, 1, options).log_improvement[0]));  // still an answer
}

TEST(ProposeBatch, RefusesBadArguments) {
  const Known known;
  EXPECT_THROW(propose_batch(known.model, 2, 0, {}), InputError);
  EXPECT_THROW(propose_batch(known.model, 0, 1, {}), InputError);
  EXPECT_THROW(propose_batch(known.model, 2, 1, {.visited = Matrix::Zero(3, 5)}), InputError);
  const std::vector<Surrogate> kpis{known.model};
  EXPECT_THROW(propose_batch(kpis, std::vector<Target>{}, 2, 1, {}), InputError);
}

}  // namespace
}  // namespace repose::opt

// What is left out is predicted in closed form as by a model that never saw it.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numbers>

#include "gp_data.hpp"
#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

using test::at_rows;
using test::Sample;
using test::smooth_function;
using test::uniform_points;
using Rows = std::vector<Eigen::Index>;

constexpr double kTight = 1e-9;

/// A model of the other rows with the same parameters, and what it says of these.
struct Refit {
  Vector mean;
  Matrix covariance;  ///< of observations
  double log_density;
};

/// The same by dense algebra, [Rasmussen2006, Eqs. 2.41 and 2.42], from nothing but the kernel.
Refit refit(const Matrix& x, const Vector& y, const Vector& noise, const Matrix& h,
            const Hyperparameters& given, const Rows& kept, const Rows& left) {
  const auto covariance = [&](const Rows& a, const Rows& b) {
    Matrix k(static_cast<Eigen::Index>(a.size()), static_cast<Eigen::Index>(b.size()));
    for (std::size_t i = 0; i < a.size(); ++i)
      for (std::size_t j = 0; j < b.size(); ++j) {
        const double r =
            ((x.row(a[i]) - x.row(b[j])).transpose().array() / given.length_scales.array())
                .matrix()
                .norm();
        const double s = std::sqrt(5.0) * r;
        k(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            given.process_variance * (1.0 + s + s * s / 3.0) * std::exp(-s);
      }
    return k;
  };
  Matrix c = covariance(kept, kept);
  c.diagonal() += noise(kept);
  const Matrix inverse = c.inverse();
  const Matrix cross = covariance(kept, left);
  const Matrix hk = h(kept, Eigen::all);
  const Matrix normal = (hk.transpose() * inverse * hk).inverse();
  const Vector beta = normal * (hk.transpose() * (inverse * y(kept)));
  Refit result;
  result.mean = h(left, Eigen::all) * beta + cross.transpose() * inverse * (y(kept) - hk * beta);
  const Matrix r = h(left, Eigen::all) - cross.transpose() * inverse * hk;
  result.covariance =
      covariance(left, left) - cross.transpose() * inverse * cross + r * normal * r.transpose();
  result.covariance.diagonal() += noise(left);
  const Vector e = y(left) - result.mean;
  result.log_density =
      -0.5 * (e.dot(result.covariance.inverse() * e) + std::log(result.covariance.determinant()) +
              double(left.size()) * std::log(2.0 * std::numbers::pi));
  return result;
}

Matrix trend_of(Basis basis, const Matrix& x) {
  Matrix h(x.rows(), basis == Basis::none ? 0 : basis == Basis::constant ? 1 : 1 + x.cols());
  if (basis != Basis::none) h.col(0).setOnes();
  if (basis == Basis::linear) h.rightCols(x.cols()) = x;
  return h;
}

void expect_equals_refits(const LeftOut& out, const std::vector<Eigen::Index>& groups,
                          const Sample& s, const Vector& noise, Basis basis) {
  double density = 0.0;
  double squares = 0.0;
  for (const LeftOut::Group& group : out.groups) {
    Rows kept;
    for (Eigen::Index i = 0; i < s.x.rows(); ++i)
      if (groups[std::size_t(i)] != groups[std::size_t(group.rows[0])]) kept.push_back(i);
    const Refit expected = refit(s.x, s.y, noise, trend_of(basis, s.x), s.given, kept, group.rows);
    density += expected.log_density;
    ASSERT_EQ(group.covariance.rows(), expected.covariance.rows());
    EXPECT_LT((group.covariance - expected.covariance).cwiseAbs().maxCoeff(), kTight);
    for (std::size_t i = 0; i < group.rows.size(); ++i) {
      const Eigen::Index row = group.rows[i];
      const auto at = static_cast<Eigen::Index>(i);
      EXPECT_NEAR(out.predicted[row], expected.mean[at], kTight);
      EXPECT_NEAR(out.variance[row], expected.covariance(at, at), kTight);
      EXPECT_NEAR(out.residual[row], s.y[row] - expected.mean[at], kTight);
      squares += std::pow(s.y[row] - expected.mean[at], 2);
    }
  }
  const double total = (s.y.array() - s.y.mean()).square().sum();
  EXPECT_NEAR(out.q2, 1.0 - squares / total, kTight);
  EXPECT_NEAR(out.rmse, std::sqrt(squares / double(s.x.rows())), kTight);
  EXPECT_NEAR(out.log_density, density, kTight * std::abs(density));
}

/// Rows of one point in one group, and spread over several: every fourth row.
std::vector<Eigen::Index> groups_of(Eigen::Index rows, bool apart) {
  std::vector<Eigen::Index> groups;
  for (Eigen::Index i = 0; i < rows; ++i) groups.push_back(apart ? (i * 7 + i / 9) % 5 : i % 4);
  return groups;
}

TEST(LeaveOneOut, EqualsARefitWithoutThePointForEveryBasis) {
  for (const Basis basis : {Basis::none, Basis::constant, Basis::linear}) {
    const Sample s;
    const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.basis = basis});
    std::vector<Eigen::Index> point;
    for (Eigen::Index i = 0; i < 30; ++i) {
      Eigen::Index first = 0;
      while (s.x.row(first) != s.x.row(i)) ++first;
      point.push_back(first);
    }
    const LeftOut out = gp.leave_one_out();
    expect_equals_refits(out, point, s, Vector::Constant(30, s.given.noise_variance), basis);
    EXPECT_GT(out.coverage95, 0.8);
  }
}

TEST(LeaveGroupsOut, EqualsARefitWithoutTheGroupWithRepeatsInsideAndAcrossGroups) {
  for (const Basis basis : {Basis::none, Basis::constant, Basis::linear})
    for (const bool apart : {false, true}) {
      const Sample s;
      const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.basis = basis});
      const auto groups = groups_of(30, apart);
      expect_equals_refits(gp.leave_groups_out(groups), groups, s,
                           Vector::Constant(30, s.given.noise_variance), basis);
    }
}

TEST(LeaveGroupsOut, HoldsForKnownVariancesThatDiffer) {
  const Sample s;
  const Vector noise = 0.01 + 0.05 * uniform_points(30, 1, 8).col(0).array();
  for (const bool apart : {false, true}) {
    const auto gp = GaussianProcess::with_parameters(
        s.x, s.y, s.cube, s.given,
        {.noise = Noise::known, .noise_variances = noise, .basis = Basis::linear});
    const auto groups = groups_of(30, apart);
    expect_equals_refits(gp.leave_groups_out(groups), groups, s, noise, Basis::linear);
  }
}

TEST(LeaveGroupsOut, OfADeterministicFunctionHoldsToo) {
  Sample s(0);
  s.given.noise_variance = 0.0;
  s.y = at_rows(s.x, smooth_function);
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  const auto groups = groups_of(30, true);
  expect_equals_refits(gp.leave_groups_out(groups), groups, s, Vector::Zero(30), Basis::constant);
}

// four points determine the four coefficients of a linear trend: without two of them none is known
TEST(LeaveGroupsOut, IsUndefinedWhereAGroupAloneDeterminesACoefficient) {
  Sample s;
  s.x.col(2).setConstant(0.25);
  s.x(3, 2) = 0.5;
  s.x(9, 2) = 0.75;
  const auto gp =
      GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given, {.basis = Basis::linear});
  std::vector<Eigen::Index> groups(30, 0);
  groups[3] = groups[9] = 1;
  for (std::size_t i = 20; i < 30; ++i) groups[i] = 2;
  const LeftOut out = gp.leave_groups_out(groups);
  EXPECT_TRUE(std::isnan(out.predicted[3]) && std::isnan(out.variance[9]));
  EXPECT_TRUE(std::isfinite(out.predicted[0]) && std::isfinite(out.predicted[25]));
  EXPECT_EQ(out.groups[1].covariance.size(), 0);
  EXPECT_TRUE(std::isfinite(out.q2) && std::isfinite(out.log_density));
}

TEST(LeaveGroupsOut, RefusesGroupsThatDoNotFit) {
  const Sample s;
  const auto gp = GaussianProcess::with_parameters(s.x, s.y, s.cube, s.given);
  EXPECT_THROW(gp.leave_groups_out(std::vector<Eigen::Index>(29, 0)), InputError);
  const Matrix twice = s.x.topRows(20).replicate(2, 1);
  const Vector y = at_rows(twice, smooth_function);
  const auto exact =
      GaussianProcess::with_parameters(twice, y, s.cube, {s.given.length_scales, 1.0, 0.0});
  std::vector<Eigen::Index> groups(40, 0);
  groups[25] = 1;
  EXPECT_THROW(exact.leave_groups_out(groups), InputError);
}

}  // namespace
}  // namespace repose::surrogate

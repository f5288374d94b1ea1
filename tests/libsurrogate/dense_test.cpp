// The loops for newer processors do what those for any do.
#include "dense.hpp"

#include <gtest/gtest.h>

#include "gp_data.hpp"

namespace repose::surrogate {
namespace {

using test::uniform_points;

/// A well conditioned symmetric matrix of size n.
Matrix positive_definite(Eigen::Index n) {
  const Matrix a = uniform_points(n, n, 3);
  return a * a.transpose() / double(n) + Matrix::Identity(n, n);
}

class DenseV3 : public testing::Test {
 protected:
  void SetUp() override {
    if (dense_v3() == nullptr) GTEST_SKIP() << "not built for this architecture";
    if (&dense() != dense_v3()) GTEST_SKIP() << "this processor has no AVX2";
  }
  const Dense& old_ = dense_baseline();
};

constexpr Eigen::Index kSizes[] = {1, 3, 17, 64, 65, 130};
/// Sums of n products of numbers of order 1, in another order and with fused steps.
double rounding(Eigen::Index n) {
  return 1e-15 * double(n + 10);
}

TEST_F(DenseV3, FactorsAndInvertsAsTheBaseline) {
  for (const Eigen::Index n : kSizes) {
    const Matrix a = positive_definite(n);
    Matrix l[2] = {a, a};
    Matrix p[2] = {Matrix(n, n), Matrix(n, n)};
    Matrix c[2] = {Matrix(n, n), Matrix(n, n)};
    Matrix b[2];
    b[0] = b[1] = uniform_points(n, 9, 4);
    for (const int i : {0, 1}) {
      const Dense& loops = i == 0 ? old_ : dense();
      ASSERT_TRUE(loops.cholesky(l[i].data(), n));
      loops.lower_inverse(l[i].data(), n, p[i].data());
      loops.inverse_from(p[i].data(), n, c[i].data());
      loops.solve_lower(l[i].data(), n, b[i].data(), 9);
      c[i] = c[i].selfadjointView<Eigen::Lower>();
      EXPECT_LT((c[i] * a - Matrix::Identity(n, n)).cwiseAbs().maxCoeff(), 10 * rounding(n));
      Matrix product = uniform_points(n, 9, 4);
      const Matrix expected = p[i] * product;
      EXPECT_LT((expected - b[i]).cwiseAbs().maxCoeff(), 10 * rounding(n));
      loops.multiply_lower(p[i].data(), n, product.data(), 9);
      EXPECT_LT((expected - product).cwiseAbs().maxCoeff(), rounding(n));
    }
    EXPECT_LT((p[0] - p[1]).cwiseAbs().maxCoeff(), rounding(n));
    EXPECT_LT((c[0] - c[1]).cwiseAbs().maxCoeff(), rounding(n));
    EXPECT_LT((b[0] - b[1]).cwiseAbs().maxCoeff(), rounding(n));
  }
}

TEST_F(DenseV3, RefusesWhatIsNotPositiveDefinite) {
  Matrix a = -Matrix::Identity(5, 5);
  EXPECT_FALSE(dense().cholesky(a.data(), 5));
}

TEST_F(DenseV3, CorrelatesAsTheBaseline) {
  constexpr Eigen::Index kN = 37;
  const Matrix x = uniform_points(kN, 3, 5);
  const Vector weight{{0.7, 20.0, 1e-4}};
  const Vector q{{0.3, 0.9, 0.1}};
  for (int kind = 0; kind < 5; ++kind) {
    Vector r[2] = {Vector(kN), Vector(kN)};
    Vector scale[2] = {Vector(kN), Vector(kN)};
    Vector alpha[2] = {Vector::Zero(kN), Vector::Zero(kN)};
    for (const int i : {0, 1}) {
      const Dense& loops = i == 0 ? old_ : dense();
      loops.squared_distances(x.data(), kN, kN, 3, q.data(), 1, weight.data(), r[i].data());
      loops.correlate(static_cast<Correlation>(kind), 1.3, kN, r[i].data(),
                      {scale[i].data(), alpha[i].data()});
    }
    EXPECT_LT((r[0] - r[1]).cwiseAbs().maxCoeff(), 1e-14) << kind;
    EXPECT_LT((scale[0] - scale[1]).cwiseAbs().maxCoeff(), 1e-13) << kind;
    EXPECT_LT((alpha[0] - alpha[1]).cwiseAbs().maxCoeff(), 1e-14) << kind;
  }
  EXPECT_NEAR(old_.weighted_square_sum(x.data(), kN, 0.4, x.data() + kN),
              dense().weighted_square_sum(x.data(), kN, 0.4, x.data() + kN), 1e-14);
}

// the same bits wherever the arrays happen to lie
TEST(Dense, DoesNotDependOnAlignment) {
  constexpr Eigen::Index kN = 37;
  const Matrix x = uniform_points(kN, 1, 5);
  std::vector<double> expected;
  for (std::size_t offset = 0; offset < 4; ++offset) {
    std::vector<double> r2(kN + 8);
    std::copy(x.data(), x.data() + kN, r2.begin() + std::ptrdiff_t(offset));
    dense().correlate(Correlation::matern52, 1.0, kN, r2.data() + offset, {});
    const std::vector<double> found(r2.begin() + std::ptrdiff_t(offset),
                                    r2.begin() + std::ptrdiff_t(offset) + kN);
    if (offset == 0) expected = found;
    EXPECT_EQ(found, expected);

    const Matrix a = positive_definite(41);
    std::vector<double> l(41 * 41 + 8);
    std::copy(a.data(), a.data() + a.size(), l.begin() + std::ptrdiff_t(offset));
    ASSERT_TRUE(dense().cholesky(l.data() + offset, 41));
    std::vector<double> aligned(a.data(), a.data() + a.size());
    ASSERT_TRUE(dense().cholesky(aligned.data(), 41));
    EXPECT_TRUE(std::equal(aligned.begin(), aligned.end(), l.begin() + std::ptrdiff_t(offset)));
  }
}

// the exponential is the library's own; at 1e-3 steps down to where it ends
TEST(Dense, ExponentialsAreGoodToTwoUnitsInTheLastPlace) {
  const auto n = static_cast<Eigen::Index>(707000);
  for (const Dense* loops : {&dense_baseline(), &dense()}) {
    Vector r2 = Vector::LinSpaced(n, 0.0, 1414.0);
    const Vector argument = -0.5 * r2;
    loops->correlate(Correlation::squared_exponential, 1.0, n, r2.data(), {});
    double worst = 0.0;
    for (Eigen::Index i = 0; i < n; ++i)
      worst = std::max(worst, std::abs(r2[i] / std::exp(argument[i]) - 1.0));
    EXPECT_LE(worst, 2.0 * std::numeric_limits<double>::epsilon()) << loops->name;
  }
}

// r = 0, and so far apart that nothing is left
TEST(Dense, CorrelationsAreDefinedAtTheEnds) {
  for (int kind = 0; kind < 5; ++kind) {
    double r2[] = {0.0, 1e-300, 1e12};
    double slope[3];
    double alpha[3];
    dense().correlate(static_cast<Correlation>(kind), 0.7, 3, r2, {slope, alpha});
    EXPECT_EQ(r2[0], 1.0);
    EXPECT_EQ(r2[1], 1.0);
    EXPECT_LT(r2[2], 1e-8);
    for (const double g : slope) EXPECT_TRUE(std::isfinite(g)) << kind;
  }
}

}  // namespace
}  // namespace repose::surrogate

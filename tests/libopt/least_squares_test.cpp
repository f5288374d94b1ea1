// Least squares: certified nonlinear regressions, the linear closed form, bounds, outliers, errors.
#include "repose/opt/least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/base/thread_pool.hpp"

namespace repose::opt {
namespace {

/// NIST Statistical Reference Datasets, nonlinear regression
/// (https://www.itl.nist.gov/div898/strd): data, both starts, certified estimates, their standard
/// deviations and the residual sum of squares, 11 digits.
struct Certified {
  friend void PrintTo(const Certified& c, std::ostream* out) { *out << c.name; }
  const char* name;
  double (*model)(double x, const Vector& b);
  void (*gradient)(double x, const Vector& b, Vector& g);
  Vector x, y;
  Vector starts[2];
  Vector estimates, deviations;
  double sum_of_squares;
  Bounds bounds;
};

/// b1 (1 - exp(-b2 x)); lower difficulty.
Certified misra1a() {
  return {"Misra1a",
          [](double x, const Vector& b) { return b[0] * -std::expm1(-b[1] * x); },
          [](double x, const Vector& b, Vector& g) {
            g = Vector{{-std::expm1(-b[1] * x), b[0] * x * std::exp(-b[1] * x)}};
          },
          Vector{{77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1,
                  689.1, 760.0}},
          Vector{{10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01,
                  66.40, 75.47, 81.78}},
          {Vector{{500.0, 1e-4}}, Vector{{250.0, 5e-4}}},
          Vector{{2.3894212918e2, 5.5015643181e-4}},
          Vector{{2.7070075241, 7.2668688436e-6}},
          1.2455138894e-1,
          {Vector{{0.0, 0.0}}, Vector{{1e4, 1.0}}}};
}

/// b1 (x^2 + x b2)/(x^2 + x b3 + b4), Kowalik & Osborne; higher difficulty.
Certified mgh09() {
  return {"MGH09",
          [](double x, const Vector& b) {
            return b[0] * (x * x + x * b[1]) / (x * x + x * b[2] + b[3]);
          },
          [](double x, const Vector& b, Vector& g) {
            const double top = x * x + x * b[1], bottom = x * x + x * b[2] + b[3];
            g = Vector{{top / bottom, b[0] * x / bottom, -b[0] * top * x / (bottom * bottom),
                        -b[0] * top / (bottom * bottom)}};
          },
          Vector{{4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625}},
          Vector{{0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235,
                  0.0246}},
          {Vector{{25.0, 39.0, 41.5, 39.0}}, Vector{{0.25, 0.39, 0.415, 0.39}}},
          Vector{{1.9280693458e-1, 1.9128232873e-1, 1.2305650693e-1, 1.3606233068e-1}},
          Vector{{1.1435312227e-2, 1.9633220911e-1, 8.0842031232e-2, 9.0025542308e-2}},
          3.0750560385e-4,
          {Vector::Zero(4), Vector::Constant(4, 100.0)}};
}

/// b1 exp(b2/(x + b3)), Meyer; higher difficulty.
Certified mgh10() {
  return {"MGH10",
          [](double x, const Vector& b) { return b[0] * std::exp(b[1] / (x + b[2])); },
          [](double x, const Vector& b, Vector& g) {
            const double e = std::exp(b[1] / (x + b[2])), s = x + b[2];
            g = Vector{{e, b[0] * e / s, -b[0] * e * b[1] / (s * s)}};
          },
          Vector::LinSpaced(16, 50.0, 125.0),
          Vector{{34780, 28610, 23650, 19630, 16370, 13720, 11540, 9744, 8261, 7030, 6005, 5147,
                  4427, 3820, 3307, 2872}},
          {Vector{{2.0, 4e5, 2.5e4}}, Vector{{0.02, 4000.0, 250.0}}},
          Vector{{5.6096364710e-3, 6.1813463463e3, 3.4522363462e2}},
          Vector{{1.5687892471e-4, 2.3309021107e1, 7.8486103508e-1}},
          8.7945855171e1,
          {Vector{{0.0, 0.0, 0.0}}, Vector{{10.0, 1e6, 1e5}}}};
}

Residuals residuals_of(const Certified& c) {
  return [&c](const Vector& b, Matrix* jacobian) {
    Vector r(c.x.size()), g;
    if (jacobian != nullptr) jacobian->resize(c.x.size(), b.size());
    for (Eigen::Index i = 0; i < r.size(); ++i) {
      r[i] = c.model(c.x[i], b) - c.y[i];
      if (jacobian == nullptr) continue;
      c.gradient(c.x[i], b, g);
      jacobian->row(i) = g;
    }
    return r;
  };
}

/// -log10 of the largest relative error.
double digits(const Vector& value, const Vector& certified) {
  return -std::log10((value - certified).cwiseQuotient(certified).cwiseAbs().maxCoeff() + 1e-16);
}

class NistRegression : public testing::TestWithParam<std::tuple<Certified, int, Derivatives>> {};

// Within sqrt(eps (n - p)) deviations of the minimum the cost changes by its rounding, eps of
// itself; of that three times, and the digits printed. The deviations themselves to six digits.
TEST_P(NistRegression, AgreesWithTheCertifiedValues) {
  const auto& [c, start, derivatives] = GetParam();
  const LeastSquaresResult r =
      fit_least_squares(residuals_of(c), c.starts[start], c.bounds, {.derivatives = derivatives});
  const double rounding = std::sqrt(std::numeric_limits<double>::epsilon() *
                                    static_cast<double>(c.x.size() - c.estimates.size()));
  for (Eigen::Index k = 0; k < r.x.size(); ++k)
    EXPECT_NEAR(r.x[k], c.estimates[k],
                3.0 * rounding * c.deviations[k] + 1e-10 * std::abs(c.estimates[k]))
        << k << ": " << r.message;
  EXPECT_NEAR(2.0 * r.cost / c.sum_of_squares, 1.0, 1e-9);
  ASSERT_EQ(r.no_covariance, "");
  EXPECT_GT(digits(r.covariance.diagonal().cwiseSqrt(), c.deviations), 6.0);
  EXPECT_EQ(r.termination, Termination::converged) << r.message;
}

std::vector<std::tuple<Certified, int, Derivatives>> certified_cases() {
  std::vector<std::tuple<Certified, int, Derivatives>> cases;
  for (const Derivatives d : {Derivatives::analytic, Derivatives::numeric}) {
    for (const int start : {0, 1}) {
      cases.emplace_back(misra1a(), start, d);
      cases.emplace_back(mgh09(), start, d);
    }
    cases.emplace_back(mgh10(), 1,
                       d);  // from start 0 it ends far away, docs/methods/optimisation.md
  }
  return cases;
}

std::string name_of(const testing::TestParamInfo<std::tuple<Certified, int, Derivatives>>& info) {
  const auto& [c, start, derivatives] = info.param;
  return std::string(c.name) + (start == 0 ? "Far" : "Near") +
         (derivatives == Derivatives::analytic ? "Analytic" : "Numeric");
}

INSTANTIATE_TEST_SUITE_P(StRD, NistRegression, testing::ValuesIn(certified_cases()), name_of);

/// A line through noisy points, of which the first `outliers` are 50 too high.
struct Line {
  Matrix a = Matrix::Ones(30, 2);
  Vector y = Vector::Zero(30);
  explicit Line(int outliers = 0) {
    RandomStream random(3);
    for (Eigen::Index i = 0; i < 30; ++i) {
      a(i, 1) = 0.1 * static_cast<double>(i);
      y[i] = 2.0 - 3.0 * a(i, 1) + 0.1 * random.normal() + (i < outliers ? 50.0 : 0.0);
    }
  }
  Vector operator()(const Vector& b, Matrix* jacobian) const {
    if (jacobian != nullptr) *jacobian = a;
    return a * b - y;
  }
};
const Bounds kWide{Vector::Constant(2, -100.0), Vector::Constant(2, 100.0)};

TEST(LeastSquares, OfALineAreTheNormalEquations) {
  const Line line;
  const LeastSquaresResult r =
      fit_least_squares(line, Vector::Zero(2), kWide, {.derivatives = Derivatives::analytic});
  const Matrix inverse = (line.a.transpose() * line.a).inverse();
  const Vector b = inverse * line.a.transpose() * line.y;
  EXPECT_LT((r.x - b).cwiseAbs().maxCoeff(), 1e-10);
  const Matrix covariance = (line.a * b - line.y).squaredNorm() / 28.0 * inverse;
  EXPECT_LT((r.covariance - covariance).norm(), 1e-9 * covariance.norm());
}

// The minimum along the bound of a convex problem; the parameter there has no variance left.
TEST(LeastSquares, StopAtTheBoundThatIsInTheWay) {
  const Line line;
  const Bounds box{Vector{{-100.0, -2.5}}, Vector{{100.0, 100.0}}};
  const LeastSquaresResult r = fit_least_squares(line, Vector{{50.0, 7.0}}, box);
  EXPECT_EQ(r.x[1], -2.5);
  EXPECT_NEAR(r.x[0], (line.y + 2.5 * line.a.col(1)).mean(), 1e-8);
  const double s2 = r.residuals.squaredNorm() / 29.0;
  EXPECT_NEAR(r.covariance(0, 0), s2 / 30.0, 1e-9 * s2);
  EXPECT_EQ(r.covariance(1, 1), 0.0);
  const Bounds fixed{Vector{{-100.0, -2.5}}, Vector{{100.0, -2.5}}};
  EXPECT_NEAR(fit_least_squares(line, Vector::Zero(2), fixed).x[0], r.x[0], 1e-8);
}

// r = exp(2 b) - t, of which the differences may only ask inside [0, 1]; the minimum is at a bound
// or a hair inside it.
TEST(LeastSquares, DifferencesStayInsideTheBounds) {
  for (const double b : {0.0, 1e-9, 0.3, 1.0}) {
    const Residuals exponential = [&](const Vector& x, Matrix*) {
      EXPECT_TRUE(x[0] >= 0.0 && x[0] <= 1.0) << x[0];
      return Vector{{std::exp(2.0 * x[0]) - std::exp(2.0 * b), 0.1}};
    };
    const LeastSquaresResult r =
        fit_least_squares(exponential, Vector::Constant(1, 0.9), unit_cube(1));
    EXPECT_NEAR(r.x[0], b, 1e-8) << r.message;
    if (b != 0.3) continue;
    EXPECT_NEAR(r.covariance(0, 0), 0.01 / (4.0 * std::exp(1.2)), 1e-8);  // s^2/J^2
  }
}

class RobustLoss : public testing::TestWithParam<Loss> {};

double rho(Loss loss, double s) {
  if (loss == Loss::huber) return s <= 1.0 ? s : 2.0 * std::sqrt(s) - 1.0;
  return loss == Loss::cauchy ? std::log(1.0 + s) : 2.0 * (std::sqrt(1.0 + s) - 1.0);
}

// Three of thirty points 50 too high draw the plain line up by 7 at its left end, the robust ones
// hardly; their cost is the published rho, smaller than anywhere nearby.
TEST_P(RobustLoss, LeavesOutliersBehindAtTheMinimumOfItsCost) {
  const Line line(3);
  const LeastSquaresOptions options{.loss = GetParam(), .loss_scale = 0.2};
  const auto cost = [&](const Vector& b) {
    double sum = 0.0;
    for (const double r : line(b, nullptr)) sum += rho(GetParam(), r * r / 0.04);
    return 0.5 * 0.04 * sum;
  };
  const LeastSquaresResult plain = fit_least_squares(line, Vector::Zero(2), kWide);
  EXPECT_GT(plain.x[0], 7.0);
  const LeastSquaresResult r = fit_least_squares(line, plain.x, kWide, options);
  EXPECT_LT((r.x - Vector{{2.0, -3.0}}).cwiseAbs().maxCoeff(), 0.3) << r.x.transpose();
  EXPECT_NEAR(r.cost, cost(r.x), 1e-12 * r.cost);
  for (const double step : {1e-3, -1e-3})
    for (Eigen::Index k = 0; k < 2; ++k) {
      Vector aside = r.x;
      aside[k] += step;
      EXPECT_GT(cost(aside), r.cost);
    }
}

INSTANTIATE_TEST_SUITE_P(All, RobustLoss,
                         testing::Values(Loss::huber, Loss::cauchy, Loss::soft_l1));

TEST(LeastSquares, HaveNoCovarianceWhereTheResidualsDoNotDetermineTheParameters) {
  const Residuals sum = [](const Vector& b, Matrix*) {
    return Vector{{b[0] + b[1] - 1.0, 2.0 * (b[0] + b[1]) - 2.1, b[0] + b[1] - 0.9}};
  };
  const LeastSquaresResult r = fit_least_squares(sum, Vector::Zero(2), kWide);
  EXPECT_EQ(r.covariance.size(), 0);
  EXPECT_EQ(r.no_covariance, "the residuals determine 1 of 2 parameters");
  const Residuals exact = [](const Vector& b, Matrix*) { return Vector{{b[0] - 1.0, b[1] - 2.0}}; };
  EXPECT_EQ(fit_least_squares(exact, Vector::Zero(2), kWide).no_covariance,
            "2 residuals leave none over for 2 parameters");
}

// log of a negative number beyond b = 0: steps that land there are taken back.
TEST(LeastSquares, TurnAwayFromResidualsThatAreNotFiniteInSilence) {
  testing::internal::CaptureStderr();
  const Residuals logarithm = [](const Vector& b, Matrix*) {
    return Vector{{std::log(b[0]) - std::log(1e-3), 0.1}};
  };
  const Residuals edge = [](const Vector& b, Matrix* j) {  // no derivative on the way
    if (j != nullptr) *j = Matrix::Constant(2, 1, b[0] < 3.0 ? std::nan("") : 1.0);
    return Vector{{b[0] - 1.0, b[0]}};
  };
  const Bounds box{Vector::Constant(1, -1.0), Vector::Constant(1, 10.0)};
  const LeastSquaresResult r = fit_least_squares(logarithm, Vector::Constant(1, 5.0), box);
  EXPECT_NEAR(r.x[0], 1e-3, 1e-9) << r.message;
  const LeastSquaresResult lost = fit_least_squares(logarithm, Vector::Constant(1, -0.5), box);
  EXPECT_EQ(lost.termination, Termination::failed);
  EXPECT_TRUE(std::isinf(lost.cost));
  EXPECT_NE(lost.message.find("start elsewhere"), std::string::npos);
  const LeastSquaresResult stopped = fit_least_squares(edge, Vector::Constant(1, 5.0), box,
                                                       {.derivatives = Derivatives::analytic});
  EXPECT_EQ(stopped.termination, Termination::round_off);
  EXPECT_NE(stopped.message.find("derivatives are not finite"), std::string::npos);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(LeastSquares, SayWhenTheEvaluationsAreUsedUp) {
  const Certified c = mgh09();
  const LeastSquaresResult r =
      fit_least_squares(residuals_of(c), c.starts[0], c.bounds, {.max_evaluations = 30});
  EXPECT_EQ(r.termination, Termination::budget);
  EXPECT_LE(r.evaluations, 30 + 2 * (2 * 4 + 1));  // to the end of a step, and for the covariance
}

TEST(LeastSquares, GiveTheSameBitsOnSeveralThreads) {
  const Certified c = misra1a();
  const Vector one = fit_least_squares(residuals_of(c), c.starts[0], c.bounds).x;
  std::vector<Vector> many(16);
  parallel_for(many.size(), 4, [&](std::size_t i) {
    many[i] = fit_least_squares(residuals_of(c), c.starts[0], c.bounds).x;
  });
  for (const Vector& x : many) EXPECT_EQ(x, one);
}

TEST(LeastSquares, LetExceptionsOfTheResidualsPass) {
  int calls = 0;
  const Residuals broken = [&](const Vector& b, Matrix*) -> Vector {
    if (++calls > 6) throw std::domain_error("mine");
    return b;
  };
  EXPECT_THROW(fit_least_squares(broken, Vector::Ones(2), kWide), std::domain_error);
}

TEST(LeastSquares, RefuseBadArgumentsByName) {
  const auto expect_refused = [](const Residuals& f, const Vector& start, const Bounds& box,
                                 const LeastSquaresOptions& options, const char* what) {
    try {
      fit_least_squares(f, start, box, options);
      FAIL() << what;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    }
  };
  const Line line;
  const Vector zero = Vector::Zero(2);
  expect_refused(line, Vector::Zero(3), kWide, {}, "a start of 3 coordinates, which must be 2");
  expect_refused(line, zero, {kWide.upper, kWide.lower}, {}, "bounds of coordinate 1 are");
  expect_refused(line, zero, kWide, {.loss_scale = 0.0}, "loss_scale is 0; it must be above 0");
  expect_refused(line, zero, kWide, {.relative_x_tolerance = -1.0}, "tolerances are");
  expect_refused(line, zero, kWide, {.max_evaluations = 0}, "max_evaluations is 0");
  const Residuals transposed = [&](const Vector& b, Matrix* j) {
    if (j != nullptr) *j = line.a.transpose();
    return line(b, nullptr);
  };
  expect_refused(transposed, zero, kWide, {.derivatives = Derivatives::analytic},
                 "a Jacobian of 2 x 30 for 30 residuals of 2 parameters");
  Eigen::Index n = 3;
  const Residuals growing = [&](const Vector&, Matrix*) -> Vector { return Vector::Ones(n++); };
  expect_refused(growing, zero, kWide, {}, "4 residuals, after 3 before");
  const Residuals none = [](const Vector&, Matrix*) -> Vector { return {}; };
  expect_refused(none, zero, kWide, {}, "there must be at least one");
}

}  // namespace
}  // namespace repose::opt

#include "task_relations.hpp"

#include <algorithm>
#include <array>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "prior_covariance.hpp"
#include "repose/doe/space_filling.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"

namespace repose::surrogate {
namespace {

constexpr Eigen::Index kPriorPoints = 1024;
constexpr double kSmallestDiscrepancy = 1e-3;  // 1 - rho^2, of functions much alike
constexpr double kNoiseDeviation = 0.7;        // of logarithms
constexpr double kFactorDeviation = 1.2;
constexpr double kMedianFactor = 2.0;
constexpr Eigen::Index kSpreadPoints = 32;
constexpr double kConstant = 8.0 * std::numeric_limits<double>::epsilon();  // of the mean

/// How much alike two functions may be: standard deviations of the shift, in those of the source,
/// and of log s.
struct Likeness {
  enum class Correlation { high, any, none } correlation;
  double shift_deviation;
  double ratio_deviation;
};
constexpr std::array<Likeness, 4> kLikeness{{{Likeness::Correlation::high, 0.2, 0.1},
                                             {Likeness::Correlation::high, 1.0, 0.5},
                                             {Likeness::Correlation::any, 1.0, 0.5},
                                             {Likeness::Correlation::none, 3.0, 0.7}}};

/// rho from u in (0, 1).
double correlation_of(const Likeness& likeness, double u) {
  switch (likeness.correlation) {
    case Likeness::Correlation::high:
      return std::sqrt(1.0 - std::pow(kSmallestDiscrepancy, u));
    case Likeness::Correlation::any:
      return 2.0 * u - 1.0;
    case Likeness::Correlation::none:
      break;
  }
  return 0.0;
}

double normal_quantile(double p) {
  return -std::numbers::sqrt2 * boost::math::erfc_inv(2.0 * p);
}

/// 1 - mean correlation: of a process' variance, what is expected over these points.
double expected_spread(const GaussianProcess& process, const Matrix& points,
                       const Vector& length_factors) {
  return std::max(1e-12, 1.0 - prior_correlation(process, points, points, length_factors).mean());
}

/// At most `count` of the rows, evenly.
Matrix some_rows(const Matrix& x, Eigen::Index count) {
  const Eigen::Index n = std::min(count, x.rows());
  Matrix some(n, x.cols());
  for (Eigen::Index i = 0; i < n; ++i) some.row(i) = x.row(i * x.rows() / n);
  return some;
}

}  // namespace

std::vector<TaskRelation> possible_relations(const GaussianProcess& source, double noise,
                                             double else_variance) {
  const Vector mean = GaussianProcessRegressor(source).predict(source.points());
  const double own = (mean.array() - mean.mean()).square().mean();
  const double variance =
      own > kConstant * kConstant * mean.cwiseAbs2().mean() ? own : else_variance;
  const Matrix points = some_rows(source.points(), kSpreadPoints);
  const Eigen::Index scales = source.hyperparameters().length_scales.size();
  const Matrix u = doe::sobol_points(kPriorPoints, 3 + scales);
  constexpr auto kEach = kPriorPoints / static_cast<Eigen::Index>(kLikeness.size());
  std::vector<TaskRelation> relations;
  for (Eigen::Index i = 0; i < kPriorPoints; ++i) {  // each part is a net by itself
    const Likeness& likeness = kLikeness[static_cast<std::size_t>(i / kEach)];
    const double rho = correlation_of(likeness, u(i, 0));
    const double ratio = std::exp(likeness.ratio_deviation * normal_quantile(u(i, 1)));
    TaskRelation r{.correlation = rho, .scale = rho * ratio, .length_factors = Vector(scales)};
    for (Eigen::Index k = 0; k < scales; ++k)
      r.length_factors[k] =
          kMedianFactor * std::exp(kFactorDeviation * normal_quantile(u(i, 3 + k)));
    r.own_variance = (1.0 - rho * rho) * ratio * ratio * variance /
                     expected_spread(source, points, r.length_factors);
    r.shift_deviation = likeness.shift_deviation * std::sqrt(variance);
    r.noise_variance = std::exp(kNoiseDeviation * normal_quantile(u(i, 2))) * noise;
    relations.push_back(std::move(r));
  }
  return relations;
}

Matrix prior_target_covariance(const GaussianProcess& source, const Matrix& x) {
  const auto relations = possible_relations(source, source.noise_variance(), 1.0);
  const Matrix known = source.covariance(x, x);
  Matrix c = Matrix::Zero(x.rows(), x.rows());
  for (const TaskRelation& r : relations)
    c.array() += r.scale * r.scale * known.array() + r.shift_deviation * r.shift_deviation +
                 r.own_variance * prior_correlation(source, x, x, r.length_factors).array();
  return c / static_cast<double>(relations.size());
}

}  // namespace repose::surrogate

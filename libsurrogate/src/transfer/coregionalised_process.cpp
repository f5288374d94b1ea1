#include "repose/surrogate/coregionalised_process.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "prior_covariance.hpp"
#include "repose/base/error.hpp"
#include "repose/doe/space_filling.hpp"

namespace repose::surrogate {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr Eigen::Index kPriorPoints = 1024;
constexpr double kSmallestDiscrepancy = 1e-3;  // 1 - rho^2, of functions much alike
constexpr double kNoiseDeviation = 0.7;        // of logarithms
constexpr double kFactorDeviation = 1.2;
constexpr double kMedianFactor = 2.0;
constexpr Eigen::Index kSpreadPoints = 32;
constexpr double kImprobable = 1e-3;
constexpr Eigen::Index kBlock = 256;  // rows predicted at once

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

Vector means(const std::vector<Gaussian>& predictions) {
  Vector mean(static_cast<Eigen::Index>(predictions.size()));
  for (Eigen::Index i = 0; i < mean.size(); ++i)
    mean[i] = predictions[static_cast<std::size_t>(i)].mean;
  return mean;
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

/// The prior by points of equal weight, which are left open. `noise` is the source's;
/// `else_variance` stands for the variance of a source that is constant.
std::vector<TaskRelation> possible_relations(const GaussianProcess& source, double noise,
                                             double else_variance) {
  const Vector mean = means(source.predict_rows(source.points()));
  const double own = (mean.array() - mean.mean()).square().mean();
  const double variance = own > 1e-12 * mean.cwiseAbs2().mean() ? own : else_variance;
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

/// The target's data under one relation: C = L L^T at known b, precision 1^T C^-1 1 + 1/t^2.
struct Fitted {
  bool possible = false;
  Matrix l;
  Vector l_one;                                                      ///< L^-1 1
  double precision = 0;                                              ///< of b
  double shift = 0;                                                  ///< its mean
  Vector weights;                                                    ///< C^-1 (rest - shift)
  double log_likelihood = -std::numeric_limits<double>::infinity();  ///< b integrated out

  Fitted(const Matrix& covariance, const Vector& rest, double shift_deviation) {
    const Eigen::LLT<Matrix> llt(covariance);
    if (llt.info() != Eigen::Success) return;
    l = llt.matrixL();
    l_one = l.triangularView<Eigen::Lower>().solve(Vector::Ones(rest.size()));
    Vector e = l.triangularView<Eigen::Lower>().solve(rest);
    const double variance = shift_deviation * shift_deviation;
    precision = l_one.squaredNorm() + 1.0 / variance;
    shift = l_one.dot(e) / precision;
    log_likelihood = -l.diagonal().array().log().sum() - 0.5 * std::log(variance * precision) -
                     0.5 * (e.squaredNorm() - shift * shift * precision) -
                     0.5 * static_cast<double>(e.size()) * std::log(2.0 * std::numbers::pi);
    e -= shift * l_one;
    weights = l.transpose().triangularView<Eigen::Upper>().solve(e);
    possible = std::isfinite(log_likelihood);
  }
};

/// Sums to 1; from logarithms known but for a constant.
void normalise(Vector& log_weights) {
  log_weights = (log_weights.array() - log_weights.maxCoeff()).exp();
  log_weights /= log_weights.sum();
}

/// Those of largest weight, in their order, renormalised.
std::vector<TaskRelation> probable(const std::vector<TaskRelation>& relations) {
  std::vector<std::size_t> order(relations.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return relations[i].weight > relations[j].weight;
  });
  double kept = 0.0;
  std::size_t count = 0;
  while (count < order.size() && kept < 1.0 - kImprobable) kept += relations[order[count++]].weight;
  order.resize(count);
  std::sort(order.begin(), order.end());
  std::vector<TaskRelation> result;
  for (const std::size_t i : order) {
    result.push_back(relations[i]);
    result.back().weight /= kept;
  }
  return result;
}

std::vector<std::vector<Eigen::Index>> rows_by_group(std::span<const Eigen::Index> groups) {
  std::map<Eigen::Index, std::vector<Eigen::Index>> rows;
  for (std::size_t i = 0; i < groups.size(); ++i)
    rows[groups[i]].push_back(static_cast<Eigen::Index>(i));
  std::vector<std::vector<Eigen::Index>> result;
  for (auto& [group, its_rows] : rows) result.push_back(std::move(its_rows));
  return result;
}

/// What the other rows say of those of a group: Q_GG^-1 and Q_GG^-1 (Qy)_G [Ginsbourger2024].
struct Omitted {
  Vector residual;
  Matrix covariance;
  double log_density = -std::numeric_limits<double>::infinity();

  Omitted(const Matrix& q, const Vector& qy, const std::vector<Eigen::Index>& rows) {
    const Eigen::LLT<Matrix> llt(Matrix(q(rows, rows)));
    if (llt.info() != Eigen::Success) return;
    const Vector part = qy(rows);
    const auto m = static_cast<Eigen::Index>(rows.size());
    residual = llt.solve(part);
    covariance = llt.solve(Matrix::Identity(m, m));
    const Matrix l = llt.matrixL();
    log_density = l.diagonal().array().log().sum() - 0.5 * part.dot(residual) -
                  0.5 * static_cast<double>(m) * std::log(2.0 * std::numbers::pi);
  }
};

}  // namespace

struct CoregionalisedProcess::State {
  GaussianProcess source;
  Matrix x;
  Vector y;
  std::vector<TaskRelation> relations;
  double mean = 0.0;   ///< m
  Vector source_part;  ///< f_s(x) - m, its mean
  std::vector<Fitted> fitted;

  Matrix known;  ///< the source's covariance at x

  State(const GaussianProcess& model, const Matrix& points, const Vector& values);
  Fitted fit(const TaskRelation& r) const {
    Matrix c = r.scale * r.scale * known +
               r.own_variance * prior_correlation(source, x, x, r.length_factors);
    c.diagonal().array() += r.noise_variance;
    return Fitted(c, y.array() - mean - r.scale * source_part.array(), r.shift_deviation);
  }
  void keep(const std::vector<TaskRelation>& kept) {
    relations = kept;
    for (const TaskRelation& r : relations) {
      fitted.push_back(fit(r));
      if (!fitted.back().possible)
        throw NumericalError("the covariance of the target's rows is singular");
    }
  }
};

namespace {

/// Law of total variance, one relation after another.
struct Mixture {
  Vector mean, square, noise;

  explicit Mixture(Eigen::Index m)
      : mean(Vector::Zero(m)), square(Vector::Zero(m)), noise(Vector::Zero(m)) {}
  void add(double weight, const Vector& m, const Vector& variance, double noise_variance) {
    mean += weight * m;
    square += weight * (variance + m.cwiseAbs2());
    noise.array() += weight * noise_variance;
  }
  Predictions predictions() const {
    const Vector function = (square - mean.cwiseAbs2()).cwiseMax(0.0);
    return {mean, function, function + noise};
  }
};

}  // namespace

CoregionalisedProcess::State::State(const GaussianProcess& model, const Matrix& points,
                                    const Vector& values)
    : source(model), x(points), y(values) {
  if (source.response_scale() != ResponseScale::linear)
    throw InputError(
        fmt::format("the source models the {} of the response; coregionalisation "
                    "needs one that models the response itself",
                    to_string(source.response_scale())));
  check_points(source.inputs(), x);
  if (x.rows() == 0 || y.size() != x.rows() || !y.allFinite())
    throw InputError(
        fmt::format("{} rows of inputs for {} responses of the target; there must be "
                    "one finite response for each, and a row",
                    x.rows(), y.size()));
  mean = means(source.predict_rows(source.points())).mean();
  source_part = means(source.predict_rows(x)).array() - mean;
  known = source.covariance(x, x);
}

CoregionalisedProcess CoregionalisedProcess::fit(const GaussianProcess& source, const Matrix& x,
                                                 const Vector& y) {
  const auto state = std::make_shared<State>(source, x, y);
  // where the source has no noise, or the target no variance, what rounding may leave
  const double variance = (y.array() - y.mean()).square().mean() + 1e-12 * y.cwiseAbs2().mean();
  const double least = std::max(1e-8 * variance + 1e-10 * source.hyperparameters().process_variance,
                                std::numeric_limits<double>::min());
  std::vector<TaskRelation> relations = possible_relations(
      source, std::max(source.noise_variance(), least), std::max(variance, 1e8 * least));
  Vector weights(kPriorPoints);
  for (Eigen::Index k = 0; k < kPriorPoints; ++k) {
    const Fitted f = state->fit(relations[static_cast<std::size_t>(k)]);
    weights[k] = f.possible ? f.log_likelihood : -std::numeric_limits<double>::infinity();
  }
  normalise(weights);
  if (!weights.allFinite())
    throw NumericalError(
        "no relation of the target to the source could be evaluated; are all responses the same?");
  for (Eigen::Index k = 0; k < kPriorPoints; ++k)
    relations[static_cast<std::size_t>(k)].weight = weights[k];
  state->keep(probable(relations));
  return CoregionalisedProcess(state);
}

CoregionalisedProcess CoregionalisedProcess::with_relations(
    const GaussianProcess& source, const Matrix& x, const Vector& y,
    const std::vector<TaskRelation>& relations) {
  const auto state = std::make_shared<State>(source, x, y);
  state->keep(relations);
  return CoregionalisedProcess(state);
}

Vector CoregionalisedProcess::predict(const Matrix& x) const {
  return predict_with_variances(x).mean;
}

Predictions CoregionalisedProcess::predict_with_variances(const Matrix& x) const {
  const State& s = *state_;
  check_points(s.source.inputs(), x);
  const Eigen::Index m = x.rows();
  Predictions result{Vector(m), Vector(m), Vector(m)};
  for (Eigen::Index begin = 0; begin < m; begin += kBlock) {
    const Eigen::Index size = std::min(kBlock, m - begin);
    const Matrix q = x.middleRows(begin, size);
    const std::vector<Gaussian> source = s.source.predict_rows(q);
    const Vector source_part = means(source).array() - s.mean;
    Vector source_variance(size);
    for (Eigen::Index i = 0; i < size; ++i)
      source_variance[i] = source[static_cast<std::size_t>(i)].variance;
    const Matrix known = s.source.covariance(s.x, q);
    Mixture mixture(size);
    for (std::size_t k = 0; k < s.relations.size(); ++k) {
      const TaskRelation& r = s.relations[k];
      const Fitted& f = s.fitted[k];
      Matrix c = r.scale * r.scale * known +
                 r.own_variance * prior_correlation(s.source, s.x, q, r.length_factors);
      const Vector mean =
          (s.mean + f.shift + r.scale * source_part.array()).matrix() + c.transpose() * f.weights;
      f.l.triangularView<Eigen::Lower>().solveInPlace(c);
      const Vector of_shift = 1.0 - (c.transpose() * f.l_one).array();
      const Vector variance = (r.scale * r.scale * source_variance).array() + r.own_variance -
                              c.colwise().squaredNorm().transpose().array() +
                              of_shift.array().square() / f.precision;
      mixture.add(r.weight, mean, variance.cwiseMax(0.0), r.noise_variance);
    }
    const Predictions block = mixture.predictions();
    result.mean.segment(begin, size) = block.mean;
    result.function_variance.segment(begin, size) = block.function_variance;
    result.observation_variance.segment(begin, size) = block.observation_variance;
  }
  return result;
}

/// With the weight of a relation divided by the density it gave the group, and of all relations
/// the prediction from the other rows.
Predictions CoregionalisedProcess::leave_groups_out(std::span<const Eigen::Index> groups) const {
  const State& s = *state_;
  const Eigen::Index n = s.x.rows();
  if (static_cast<Eigen::Index>(groups.size()) != n)
    throw InputError(fmt::format("{} groups for {} rows", groups.size(), n));
  const auto by_group = rows_by_group(groups);
  Predictions result{Vector::Constant(n, kNaN), Vector::Constant(n, kNaN),
                     Vector::Constant(n, kNaN)};
  if (by_group.size() < 2) return result;
  const auto relations = static_cast<Eigen::Index>(s.relations.size());
  std::vector<Vector> log_weights(by_group.size(), Vector(relations));
  Matrix mean(n, relations), variance(n, relations);
  Vector noise(relations);
  for (Eigen::Index k = 0; k < relations; ++k) {
    const Fitted& f = s.fitted[static_cast<std::size_t>(k)];
    noise[k] = s.relations[static_cast<std::size_t>(k)].noise_variance;
    const Matrix inverse = f.l.triangularView<Eigen::Lower>().solve(Matrix::Identity(n, n));
    const Vector c_one = inverse.transpose() * f.l_one;
    const Matrix q = inverse.transpose() * inverse - c_one * c_one.transpose() / f.precision;
    for (std::size_t g = 0; g < by_group.size(); ++g) {
      const Omitted omitted(q, f.weights, by_group[g]);
      log_weights[g][k] =
          std::log(s.relations[static_cast<std::size_t>(k)].weight) - omitted.log_density;
      if (!std::isfinite(omitted.log_density)) {
        log_weights[g][k] = -std::numeric_limits<double>::infinity();
        mean(by_group[g], k).setZero();
        variance(by_group[g], k).setZero();
        continue;
      }
      mean(by_group[g], k) = s.y(by_group[g]) - omitted.residual;
      variance(by_group[g], k) = omitted.covariance.diagonal();
    }
  }
  for (std::size_t g = 0; g < by_group.size(); ++g) {
    normalise(log_weights[g]);
    for (const Eigen::Index i : by_group[g]) {
      const Vector m = mean.row(i), v = variance.row(i);
      const Vector& weights = log_weights[g];
      result.mean[i] = weights.dot(m);
      result.observation_variance[i] =
          weights.dot(v + m.cwiseAbs2()) - result.mean[i] * result.mean[i];
      result.function_variance[i] =
          std::max(0.0, result.observation_variance[i] - weights.dot(noise));
    }
  }
  return result;
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

const std::vector<Input>& CoregionalisedProcess::inputs() const {
  return state_->source.inputs();
}
const std::vector<TaskRelation>& CoregionalisedProcess::relations() const {
  return state_->relations;
}
const GaussianProcess& CoregionalisedProcess::source() const {
  return state_->source;
}
const Matrix& CoregionalisedProcess::points() const {
  return state_->x;
}
const Vector& CoregionalisedProcess::values() const {
  return state_->y;
}

Gaussian CoregionalisedProcess::correlation() const {
  double mean = 0.0, square = 0.0;
  for (const TaskRelation& r : state_->relations) {
    mean += r.weight * r.correlation;
    square += r.weight * r.correlation * r.correlation;
  }
  return {mean, std::max(0.0, square - mean * mean)};
}

std::string CoregionalisedProcess::describe() const {
  const Gaussian rho = correlation();
  return fmt::format(
      "coregionalised with {} rows of a source, {} of the target, correlation "
      "{:.2f} ± {:.2f}",
      state_->source.rows(), state_->x.rows(), rho.mean, rho.standard_deviation());
}

}  // namespace repose::surrogate

#include "repose/surrogate/coregionalised_process.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include "prior_covariance.hpp"
#include "repose/base/error.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "task_relations.hpp"

namespace repose::surrogate {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kImprobable = 1e-3;
constexpr double kSumTolerance = 1e-9;  // of weights
constexpr Eigen::Index kBlock = 256;    // rows predicted at once

/// The target's data under one relation: C = L L^T at known b, precision 1^T C^-1 1 + 1/t^2.
struct Fitted {
  bool possible = false;
  Matrix l;
  Vector l_one;                        ///< L^-1 1
  double precision = 0;                ///< of b
  double shift = 0;                    ///< its mean
  Vector weights;                      ///< C^-1 (rest - shift)
  double log_likelihood = -kInfinity;  ///< b integrated out

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
  double log_density = -kInfinity;

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

/// Each row by the rows of the other groups, of one relation after another; a relation's weight is
/// the likelihood that it gives those other rows.
class LeftOutRows {
 public:
  LeftOutRows(std::span<const Eigen::Index> groups, Eigen::Index relations)
      : rows_(static_cast<Eigen::Index>(groups.size())), groups_(rows_by_group(groups)) {
    if (groups_.size() < 2) groups_.clear();
    log_weights_.assign(groups_.size(), Vector::Constant(relations, -kInfinity));
    mean_ = variance_ = Matrix::Zero(groups_.empty() ? 0 : rows_, relations);
    noise_ = Vector::Zero(relations);
  }

  void add(Eigen::Index k, const Fitted& f, const Vector& y, double noise_variance) {
    if (groups_.empty()) return;
    noise_[k] = noise_variance;
    const Matrix inverse = f.l.triangularView<Eigen::Lower>().solve(Matrix::Identity(rows_, rows_));
    const Vector c_one = inverse.transpose() * f.l_one;
    const Matrix q = inverse.transpose() * inverse - c_one * c_one.transpose() / f.precision;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const Omitted omitted(q, f.weights, groups_[g]);
      if (!std::isfinite(omitted.log_density)) continue;
      log_weights_[g][k] = f.log_likelihood - omitted.log_density;
      mean_(groups_[g], k) = y(groups_[g]) - omitted.residual;
      variance_(groups_[g], k) = omitted.covariance.diagonal();
    }
  }

  Predictions predictions() {
    const Vector unknown = Vector::Constant(rows_, kNaN);
    Predictions result{unknown, unknown, unknown};
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      Vector& weights = log_weights_[g];
      normalise(weights);
      for (const Eigen::Index i : groups_[g]) {
        const Vector m = mean_.row(i), v = variance_.row(i);
        result.mean[i] = weights.dot(m);
        result.observation_variance[i] =
            weights.dot(v + (m.array() - result.mean[i]).square().matrix());
        result.function_variance[i] =
            std::max(0.0, result.observation_variance[i] - weights.dot(noise_));
      }
    }
    return result;
  }

 private:
  Eigen::Index rows_;
  std::vector<std::vector<Eigen::Index>> groups_;
  std::vector<Vector> log_weights_;  ///< of each group, by relation
  Matrix mean_, variance_;           ///< row by relation; of observations
  Vector noise_;
};

/// Throws InputError naming the first that is impossible.
void check_relations(const std::vector<TaskRelation>& relations, Eigen::Index scales) {
  if (relations.empty())
    throw InputError("no relation of the target to the source; there must be one at least");
  double sum = 0.0;
  for (std::size_t k = 0; k < relations.size(); ++k) {
    const TaskRelation& r = relations[k];
    const auto require = [k](bool holds, const char* what, double value, const char* allowed) {
      if (!holds)
        throw InputError(
            fmt::format("relation {}: {} is {}; it must be {}", k + 1, what, value, allowed));
    };
    const auto finite = [](double v) { return v < kInfinity; };  // of positive ones, false for NaN
    require(std::abs(r.correlation) <= 1.0, "correlation", r.correlation, "in [-1, 1]");
    require(finite(std::abs(r.scale)), "scale", r.scale, "finite");
    require(r.own_variance >= 0.0 && finite(r.own_variance), "own_variance", r.own_variance,
            "0 or positive");
    require(r.shift_deviation > 0.0 && finite(r.shift_deviation), "shift_deviation",
            r.shift_deviation, "positive");
    require(r.noise_variance > 0.0 && finite(r.noise_variance), "noise_variance", r.noise_variance,
            "positive");
    require(r.weight >= 0.0 && r.weight <= 1.0 + kSumTolerance, "weight", r.weight, "in [0, 1]");
    if (r.length_factors.size() != scales)
      throw InputError(
          fmt::format("relation {} has {} length factors; the source has {} length "
                      "scales",
                      k + 1, r.length_factors.size(), scales));
    for (const double factor : r.length_factors)
      require(factor > 0.0 && finite(factor), "a length factor", factor, "positive");
    sum += r.weight;
  }
  if (!(std::abs(sum - 1.0) <= kSumTolerance))
    throw InputError(
        fmt::format("weights of {} relations sum to {}; it must be 1", relations.size(), sum));
}

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
        throw NumericalError(fmt::format(
            "the covariance of the target's {} rows is singular at a noise variance of {:.4g}",
            x.rows(), r.noise_variance));
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
        fmt::format("{} rows of inputs for {} responses of the target, of which {} are finite; "
                    "there must be one finite response for each, and a row",
                    x.rows(), y.size(), y.array().isFinite().count()));
  const GaussianProcessRegressor function(source);
  mean = function.predict(source.points()).mean();
  source_part = function.predict(x).array() - mean;
  known = source.covariance(x, x);
}

CoregionalisedProcess CoregionalisedProcess::fit(const GaussianProcess& source, const Matrix& x,
                                                 const Vector& y) {
  return fit_and_leave_out(source, x, y, {}).process;
}

CoregionalisedProcess::Judged CoregionalisedProcess::fit_and_leave_out(
    const GaussianProcess& source, const Matrix& x, const Vector& y,
    std::span<const Eigen::Index> groups) {
  const auto state = std::make_shared<State>(source, x, y);
  if (!groups.empty() && static_cast<Eigen::Index>(groups.size()) != x.rows())
    throw InputError(fmt::format("{} numbers of groups for {} rows; there must be one for each",
                                 groups.size(), x.rows()));
  // where the source has no noise, or the target no variance, what rounding may leave
  const double variance = (y.array() - y.mean()).square().mean() + 1e-12 * y.cwiseAbs2().mean();
  const double least = std::max(1e-8 * variance + 1e-10 * source.hyperparameters().process_variance,
                                std::numeric_limits<double>::min());
  std::vector<TaskRelation> relations = possible_relations(
      source, std::max(source.noise_variance(), least), std::max(variance, 1e8 * least));
  LeftOutRows left_out(groups, static_cast<Eigen::Index>(relations.size()));
  Vector weights(static_cast<Eigen::Index>(relations.size()));
  for (Eigen::Index k = 0; k < weights.size(); ++k) {
    const TaskRelation& r = relations[static_cast<std::size_t>(k)];
    const Fitted f = state->fit(r);
    weights[k] = f.log_likelihood;
    if (f.possible) left_out.add(k, f, y, r.noise_variance);
  }
  normalise(weights);
  if (!weights.allFinite())
    throw NumericalError(
        fmt::format("no relation of the target to the source has a finite likelihood: the target's "
                    "{} responses are from {:.4g} to {:.4g}, the source's mean is {:.4g}; give "
                    "both a smaller unit",
                    y.size(), y.minCoeff(), y.maxCoeff(), state->mean));
  for (Eigen::Index k = 0; k < weights.size(); ++k)
    relations[static_cast<std::size_t>(k)].weight = weights[k];
  state->keep(probable(relations));
  return {CoregionalisedProcess(state), left_out.predictions()};
}

CoregionalisedProcess CoregionalisedProcess::with_relations(
    const GaussianProcess& source, const Matrix& x, const Vector& y,
    const std::vector<TaskRelation>& relations) {
  check_relations(relations, source.hyperparameters().length_scales.size());
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
    Vector source_part(size), source_variance(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      source_part[i] = source[static_cast<std::size_t>(i)].mean - s.mean;
      source_variance[i] = source[static_cast<std::size_t>(i)].variance;
    }
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

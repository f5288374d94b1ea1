#include "repose/surrogate/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "posterior.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/composite.hpp"
#include "repose/surrogate/gaussian_process_regressor.hpp"
#include "response.hpp"

namespace repose::surrogate {
namespace {

using State = ModelAccess::State;

constexpr double kLeftOver = 1e-6;  // of the trace
constexpr Eigen::Index kMostColumns = 1000;
constexpr double kNormal95 = 1.959964;

/// Low-rank factor of the posterior covariance, covariance ~ F F^T + diag(rest).
struct LowRank {
  Matrix f;
  Vector rest;
};

/// Pivoted Cholesky: the column of largest remaining variance next [Harbrecht2012].
LowRank pivoted_cholesky(const State& s, const Posterior& posterior) {
  LowRank result;
  result.rest = posterior.variance().cwiseMax(0.0);
  const double enough = kLeftOver * result.rest.sum();
  const Eigen::Index most = std::min(kMostColumns, result.rest.size());
  result.f.resize(result.rest.size(), most);
  Eigen::Index k = 0;
  for (; k < most && result.rest.sum() > enough; ++k) {
    Eigen::Index pivot = 0;
    const double largest = result.rest.maxCoeff(&pivot);
    Vector column = posterior.covariance_with(s, pivot);
    column.noalias() -= result.f.leftCols(k) * result.f.row(pivot).head(k).transpose();
    column /= std::sqrt(largest);
    column[pivot] = std::sqrt(largest);
    result.rest = (result.rest - column.cwiseAbs2()).cwiseMax(0.0);
    result.rest[pivot] = 0.0;
    result.f.col(k) = column;
  }
  result.f.conservativeResize(Eigen::NoChange, k);
  return result;
}

/// An input's value at a fraction of its range, on its scale.
double natural_value(const Input& input, double fraction) {
  if (input.is_categorical()) {
    const auto levels = static_cast<double>(input.levels.size());
    return std::min(std::floor(fraction * levels), levels - 1.0);
  }
  if (input.scale == Scale::log) {
    const double lower = std::log(input.lower);
    return std::exp(lower + fraction * (std::log(input.upper) - lower));
  }
  return input.lower + fraction * (input.upper - input.lower);
}

Matrix natural_points(const std::vector<Input>& inputs, const Matrix& fractions) {
  Matrix x(fractions.rows(), fractions.cols());
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      x(i, k) = natural_value(inputs[static_cast<std::size_t>(k)], fractions(i, k));
  return x;
}

/// Blocks of N rows: A, B, then A with column k of B for each input.
Matrix pick_freeze_design(const std::vector<Input>& inputs, Eigen::Index n, std::uint64_t seed) {
  const auto d = static_cast<Eigen::Index>(inputs.size());
  const Matrix both = opt::scrambled_uniforms(n, 2 * d, seed);
  Matrix design(n * (d + 2), d);
  design.topRows(n) = both.leftCols(d);
  design.middleRows(n, n) = both.rightCols(d);
  for (Eigen::Index k = 0; k < d; ++k) {
    auto mixed = design.middleRows(n * (k + 2), n);
    mixed = both.leftCols(d);
    mixed.col(k) = both.col(d + k);
  }
  return natural_points(inputs, design);
}

struct Shares {
  double first = 0.0;
  double total = 0.0;
};

/// Of one realisation f (N (d + 2) values), over a bootstrap sample of the rows.
Shares shares_of(const Vector& f, Eigen::Index n, Eigen::Index input,
                 const std::vector<Eigen::Index>& rows) {
  double mean = 0.0;
  double square = 0.0;
  double product = 0.0;
  double difference = 0.0;
  double spread = 0.0;
  double centre = 0.0;
  for (const Eigen::Index i : rows) centre += 0.5 * (f[i] + f[n + i]);
  centre /= static_cast<double>(rows.size());
  double mean_ab = 0.0;
  for (const Eigen::Index i : rows) {
    const double a = f[i] - centre;
    const double b = f[n + i] - centre;
    const double mixed = f[n * (input + 2) + i] - centre;
    mean += 0.5 * (b + mixed);
    square += 0.5 * (b * b + mixed * mixed);
    product += b * mixed;
    difference += (a - mixed) * (a - mixed);
    spread += 0.5 * (a * a + b * b);
    mean_ab += 0.5 * (a + b);
  }
  const auto m = static_cast<double>(rows.size());
  mean /= m;
  mean_ab /= m;
  return {(product / m - mean * mean) / (square / m - mean * mean),
          0.5 * difference / m / (spread / m - mean_ab * mean_ab)};
}

SobolIndex summary(std::vector<double> values) {
  SobolIndex index;
  for (const double v : values) index.value += v / static_cast<double>(values.size());
  std::sort(values.begin(), values.end());
  const auto quantile = [&values](double p) {
    const double at = p * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
  };
  index.lower = quantile(0.025);
  index.upper = quantile(0.975);
  return index;
}

bool varies(const Matrix& f) {
  return f.size() > 0 &&
         (f.array() - f(0, 0)).abs().maxCoeff() > 1e-12 * std::max(1e-300, f.cwiseAbs().maxCoeff());
}

/// Of realisations of the function, one a column, at the rows of a pick-freeze design; each
/// bootstrap takes the next of them.
std::vector<InputSensitivity> indices_of(const Matrix& f, Eigen::Index inputs,
                                         const SensitivityOptions& options) {
  std::vector<InputSensitivity> result(static_cast<std::size_t>(inputs));
  if (!varies(f)) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    for (InputSensitivity& r : result) r = {{kNaN, kNaN, kNaN}, {kNaN, kNaN, kNaN}};
    return result;
  }
  std::vector<std::vector<double>> first(result.size());
  std::vector<std::vector<double>> total(result.size());
  const Eigen::Index n = options.points;
  std::vector<Eigen::Index> rows(static_cast<std::size_t>(n));
  for (Eigen::Index j = 0; j < options.draws; ++j) {
    RandomStream random(options.seed, static_cast<std::uint64_t>(options.draws + j));
    for (Eigen::Index& row : rows)
      row = static_cast<Eigen::Index>(random.below(static_cast<std::uint64_t>(n)));
    for (Eigen::Index k = 0; k < inputs; ++k) {
      const Shares shares = shares_of(f.col(j % f.cols()), n, k, rows);
      first[static_cast<std::size_t>(k)].push_back(shares.first);
      total[static_cast<std::size_t>(k)].push_back(shares.total);
    }
  }
  for (std::size_t k = 0; k < result.size(); ++k)
    result[k] = {summary(std::move(first[k])), summary(std::move(total[k]))};
  return result;
}

void check(const SensitivityOptions& options) {
  if (options.points < 8)
    throw InputError(fmt::format("{} base points; there must be at least 8", options.points));
  if (options.draws < 1)
    throw InputError(fmt::format("{} draws; there must be at least 1", options.draws));
}

/// Points over the other inputs, and where this one is set in turn.
struct DependenceDesign {
  Matrix points;
  std::vector<double> values;
};

DependenceDesign dependence_design(const std::vector<Input>& inputs, Eigen::Index input,
                                   const PartialDependenceOptions& options) {
  const auto d = static_cast<Eigen::Index>(inputs.size());
  if (input < 0 || input >= d)
    throw InputError(fmt::format("partial dependence on input {} of {}", input + 1, d));
  if (options.points < 1 || options.grid < 2)
    throw InputError(fmt::format("{} points and a grid of {}; at least 1 and 2 are needed",
                                 options.points, options.grid));
  const Input& what = inputs[static_cast<std::size_t>(input)];
  const Eigen::Index grid =
      what.is_categorical() ? static_cast<Eigen::Index>(what.levels.size()) : options.grid;
  DependenceDesign design{
      .points = natural_points(inputs, opt::scrambled_uniforms(options.points, d, options.seed))};
  for (Eigen::Index g = 0; g < grid; ++g)
    design.values.push_back(
        what.is_categorical()
            ? static_cast<double>(g)
            : natural_value(what, static_cast<double>(g) / static_cast<double>(grid - 1)));
  return design;
}

}  // namespace

Matrix joint_sample(const GaussianProcess& model, const Matrix& x, Eigen::Index draws,
                    std::uint64_t seed) {
  const State& s = ModelAccess::state(model);
  if (draws < 1) throw InputError(fmt::format("{} draws; there must be at least 1", draws));
  const Posterior posterior(s, x);
  const LowRank covariance = pivoted_cholesky(s, posterior);
  const double sd = std::sqrt(s.amplitude * s.parameters.variance_factor);
  const Vector rest = covariance.rest.cwiseSqrt();
  Matrix z(covariance.f.cols(), draws);
  Matrix f(x.rows(), draws);
  for (Eigen::Index j = 0; j < draws; ++j) {
    RandomStream random(seed, static_cast<std::uint64_t>(j));
    for (double& value : z.col(j)) value = random.normal();
    for (Eigen::Index i = 0; i < x.rows(); ++i) f(i, j) = rest[i] * random.normal();
  }
  f.noalias() += covariance.f * z;
  f = ((sd * f).colwise() + posterior.mean).eval();
  for (double& value : f.reshaped())
    value = unmodelled(s.data.response_scale, s.data.shift + s.data.scale * value);
  return f;
}

std::vector<InputSensitivity> sobol_indices(const GaussianProcess& model,
                                            const SensitivityOptions& options) {
  check(options);
  const Matrix f =
      joint_sample(model, pick_freeze_design(model.inputs(), options.points, options.seed),
                   options.draws, options.seed);
  return indices_of(f, model.dimension(), options);
}

std::vector<InputSensitivity> sobol_indices(const Regressor& model,
                                            const SensitivityOptions& options) {
  if (const GaussianProcess* process = gaussian_process(model))
    return sobol_indices(*process, options);
  check(options);
  const Vector f = model.predict(pick_freeze_design(model.inputs(), options.points, options.seed));
  return indices_of(f, model.dimension(), options);
}

PartialDependence partial_dependence(const GaussianProcess& model, Eigen::Index input,
                                     const PartialDependenceOptions& options) {
  const State& s = ModelAccess::state(model);
  auto [x, values] = dependence_design(model.inputs(), input, options);
  const auto natural = [&s](double standardised) {
    return unmodelled(s.data.response_scale, s.data.shift + s.data.scale * standardised);
  };
  PartialDependence result{.x = values};
  for (const double at : values) {
    x.col(input).setConstant(at);
    const Posterior p(s, x);
    const double prior =
        cross_correlation(s.covariance.correlator(s.data.encoding), p.at, p.at).mean();
    const double variance = prior - p.v.rowwise().mean().squaredNorm() +
                            p.t.rowwise().mean().squaredNorm() + p.e.rowwise().mean().squaredNorm();
    const double mean = p.mean.mean();
    const double half =
        kNormal95 * std::sqrt(s.amplitude * s.parameters.variance_factor * std::max(0.0, variance));
    result.mean.push_back(natural(mean));
    result.lower.push_back(natural(mean - half));
    result.upper.push_back(natural(mean + half));
  }
  return result;
}

PartialDependence partial_dependence(const Regressor& model, Eigen::Index input,
                                     const PartialDependenceOptions& options) {
  if (const GaussianProcess* process = gaussian_process(model))
    return partial_dependence(*process, input, options);
  auto [x, values] = dependence_design(model.inputs(), input, options);
  PartialDependence result{.x = values};
  for (const double at : values) {
    x.col(input).setConstant(at);
    result.mean.push_back(model.predict(x).mean());
  }
  return result;
}

}  // namespace repose::surrogate

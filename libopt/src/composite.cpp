#include "repose/opt/composite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "repose/base/error.hpp"
#include "soft_improvement.hpp"

namespace repose::opt {
namespace {

double scale_of(const Target& target) {
  return target.scale > 0.0 ? target.scale : std::abs(target.value);
}

/// Mean and variance of |X|, X ~ N(delta, variance).
Gaussian folded_normal(double delta, double variance) {
  if (variance <= 0.0) return {std::abs(delta), 0.0};
  const double mean =
      std::sqrt(2.0 * variance / std::numbers::pi) * std::exp(-0.5 * delta * delta / variance) +
      delta * std::erf(delta / std::sqrt(2.0 * variance));
  return {mean, std::max(0.0, delta * delta + variance - mean * mean)};
}

/// weight/scale, or weight/scale^2.
double factor_of(const Target& target) {
  const double scale = scale_of(target);
  return target.weight / (target.penalty == Penalty::squared ? scale * scale : scale);
}

/// Mean and variance of |X| or X^2, X ~ N(delta, variance).
Gaussian penalty_of(Penalty penalty, double delta, double variance) {
  if (penalty == Penalty::absolute) return folded_normal(delta, variance);
  const double square = delta * delta;
  return {square + variance, 2.0 * variance * (variance + 2.0 * square)};
}

double error_of(double value, const Target& target) {
  const double deviation = target.standard_deviation;
  return factor_of(target) *
         penalty_of(target.penalty, value - target.value, deviation * deviation).mean;
}

/// d error_of/d value.
double error_slope(double value, const Target& target) {
  const double delta = value - target.value;
  if (target.penalty == Penalty::squared) return 2.0 * factor_of(target) * delta;
  const double deviation = target.standard_deviation;
  const double sign = deviation > 0.0 ? std::erf(delta / (std::numbers::sqrt2 * deviation))
                                      : static_cast<double>((delta > 0.0) - (delta < 0.0));
  return factor_of(target) * sign;
}

void check_sizes(std::size_t kpis, std::size_t targets) {
  if (kpis != targets)
    throw InputError(
        fmt::format("{} quantities for {} targets; there must be one for each", kpis, targets));
}

[[noreturn]] void refuse(const Target& target, const char* what, double value,
                         const char* allowed) {
  throw InputError(
      fmt::format("target '{}': {} is {}; it must be {}", target.name, what, value, allowed));
}

/// The objective g at each draw.
std::vector<double> drawn_errors(std::span<const Gaussian> kpis, std::span<const Target> targets,
                                 const Matrix& normals) {
  check_sizes(kpis.size(), targets.size());
  if (normals.rows() < 1 || normals.cols() != static_cast<Eigen::Index>(kpis.size()))
    throw InputError(
        fmt::format("draws are {} x {}; they must have one column for each of {} quantities",
                    normals.rows(), normals.cols(), kpis.size()));
  std::vector<double> g(static_cast<std::size_t>(normals.rows()), 0.0);
  for (std::size_t j = 0; j < kpis.size(); ++j) {
    const double* z = normals.col(static_cast<Eigen::Index>(j)).data();
    const double sigma = kpis[j].standard_deviation();
    for (std::size_t m = 0; m < g.size(); ++m)
      g[m] += error_of(kpis[j].mean + sigma * z[m], targets[j]);
  }
  return g;
}

double smoothing_width(double best) {
  return 1e-6 * std::max(std::abs(best), 1e-12);
}

}  // namespace

double soft_improvement(double u, double best) {
  const double tau = smoothing_width(best);
  const double s = u / tau;
  const double softplus = s > 0.0 ? s + std::log1p(std::exp(-s)) : std::log1p(std::exp(s));
  return tau * (softplus + 0.1 / (1.0 + s * s));
}

double soft_improvement_slope(double u, double best) {
  const double s = u / smoothing_width(best);
  const double q = 1.0 + s * s;
  return 1.0 / (1.0 + std::exp(-s)) - 0.2 * s / (q * q);
}

const char* to_string(Penalty penalty) {
  return penalty == Penalty::squared ? "squared" : "absolute";
}

void check_targets(std::span<const Target> targets) {
  if (targets.empty()) throw InputError("no targets; a calibration needs at least one");
  double total = 0.0;
  for (const Target& t : targets) {
    if (!std::isfinite(t.value)) refuse(t, "its value", t.value, "finite");
    if (!(t.weight >= 0.0) || !std::isfinite(t.weight)) refuse(t, "its weight", t.weight, ">= 0");
    if (!(t.scale >= 0.0) || !std::isfinite(t.scale))
      refuse(t, "its scale", t.scale, "positive, or 0 for |value|");
    if (!(t.standard_deviation >= 0.0) || !std::isfinite(t.standard_deviation))
      refuse(t, "its standard deviation", t.standard_deviation, ">= 0");
    if (scale_of(t) == 0.0)
      refuse(t, "its value", t.value,
             "other than 0 for a relative error, or have a scale of its own");
    total += t.weight;
  }
  if (total <= 0.0)
    throw InputError("the weights of all targets are 0; at least one must be positive");
}

double weighted_error(std::span<const double> kpis, std::span<const Target> targets) {
  check_sizes(kpis.size(), targets.size());
  double sum = 0.0;
  for (std::size_t j = 0; j < kpis.size(); ++j) sum += error_of(kpis[j], targets[j]);
  return sum;
}

Gaussian weighted_error(std::span<const Gaussian> kpis, std::span<const Target> targets) {
  check_sizes(kpis.size(), targets.size());
  Gaussian sum;
  for (std::size_t j = 0; j < kpis.size(); ++j) {
    const double deviation = targets[j].standard_deviation;
    const Gaussian error = penalty_of(targets[j].penalty, kpis[j].mean - targets[j].value,
                                      kpis[j].variance + deviation * deviation);
    const double factor = factor_of(targets[j]);
    sum.mean += factor * error.mean;
    sum.variance += factor * factor * error.variance;
  }
  return sum;
}

double composite_expected_improvement(std::span<const Gaussian> kpis,
                                      std::span<const Target> targets, double best,
                                      const Matrix& normals) {
  double sum = 0.0;
  for (const double g : drawn_errors(kpis, targets, normals)) sum += std::max(0.0, best - g);
  return sum / static_cast<double>(normals.rows());
}

double log_composite_expected_improvement(std::span<const Gaussian> kpis,
                                          std::span<const Target> targets, double best,
                                          const Matrix& normals) {
  double sum = 0.0;
  for (const double g : drawn_errors(kpis, targets, normals))
    sum += soft_improvement(best - g, best);
  return std::log(sum / static_cast<double>(normals.rows()));
}

CompositeGradient log_composite_expected_improvement_gradient(std::span<const Gaussian> kpis,
                                                              std::span<const Target> targets,
                                                              double best, const Matrix& normals) {
  const std::vector<double> g = drawn_errors(kpis, targets, normals);
  std::vector<double> slope(g.size());
  double sum = 0.0;
  for (std::size_t m = 0; m < g.size(); ++m) {
    sum += soft_improvement(best - g[m], best);
    slope[m] = soft_improvement_slope(best - g[m], best);
  }
  const auto k = static_cast<Eigen::Index>(kpis.size());
  CompositeGradient result{.value = std::log(sum / static_cast<double>(g.size())),
                           .by_mean = Vector::Zero(k),
                           .by_standard_deviation = Vector::Zero(k)};
  for (std::size_t j = 0; j < kpis.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    const double sigma = kpis[j].standard_deviation();
    for (std::size_t m = 0; m < g.size(); ++m) {
      const double z = normals(static_cast<Eigen::Index>(m), column);
      const double by_h = -slope[m] * error_slope(kpis[j].mean + sigma * z, targets[j]);
      result.by_mean[column] += by_h;
      result.by_standard_deviation[column] += by_h * z;
    }
  }
  result.by_mean /= sum;
  result.by_standard_deviation /= sum;
  return result;
}

}  // namespace repose::opt

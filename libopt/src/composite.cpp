#include "repose/opt/composite.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "repose/base/error.hpp"

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

double error_of(double value, const Target& target) {
  const double deviation = target.standard_deviation;
  return target.weight / scale_of(target) *
         folded_normal(value - target.value, deviation * deviation).mean;
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

/// tau (softplus(u/tau) + 0.1/(1 + (u/tau)^2)): max(0, u) with a tail that never vanishes.
double fat_softplus(double u, double tau) {
  const double s = u / tau;
  const double softplus = s > 0.0 ? s + std::log1p(std::exp(-s)) : std::log1p(std::exp(s));
  return tau * (softplus + 0.1 / (1.0 + s * s));
}

/// Mean over the draws of merit(best - g).
template <class Merit>
double mean_over_draws(std::span<const Gaussian> kpis, std::span<const Target> targets,
                       const Matrix& normals, double best, const Merit& merit) {
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
  double sum = 0.0;
  for (const double value : g) sum += merit(best - value);
  return sum / static_cast<double>(g.size());
}

}  // namespace

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
    const Gaussian error =
        folded_normal(kpis[j].mean - targets[j].value, kpis[j].variance + deviation * deviation);
    const double factor = targets[j].weight / scale_of(targets[j]);
    sum.mean += factor * error.mean;
    sum.variance += factor * factor * error.variance;
  }
  return sum;
}

double composite_expected_improvement(std::span<const Gaussian> kpis,
                                      std::span<const Target> targets, double best,
                                      const Matrix& normals) {
  return mean_over_draws(kpis, targets, normals, best, [](double u) { return std::max(0.0, u); });
}

double log_composite_expected_improvement(std::span<const Gaussian> kpis,
                                          std::span<const Target> targets, double best,
                                          const Matrix& normals) {
  const double tau = 1e-6 * std::max(std::abs(best), 1e-12);
  return std::log(mean_over_draws(kpis, targets, normals, best,
                                  [tau](double u) { return fat_softplus(u, tau); }));
}

}  // namespace repose::opt

// Calibration's objective, a weighted sum of relative errors of several quantities, each predicted
// by its own model.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "repose/base/gaussian.hpp"
#include "repose/base/parameter_space.hpp"

namespace repose::opt {

/// What being off costs, u = (h - value) / scale.
enum class Penalty {
  absolute,  ///< |u|
  squared    ///< u^2: large errors count more than many small ones
};
const char* to_string(Penalty penalty);

/// What one quantity (KPI) should be: it contributes weight |h - value| / scale to the objective,
/// or weight times the square.
struct Target {
  std::string name;
  double value = 0.0;
  double weight = 1.0;
  double scale = 0.0;  ///< 0: |value|
  /// Of the measurement of `value`, in its unit. The objective is then the expectation over the
  /// true value, N(value, standard_deviation^2).
  double standard_deviation = 0.0;
  Penalty penalty = Penalty::absolute;
};

/// Throws InputError, naming the target, on no targets, numbers that are not finite, a negative
/// weight, scale or standard deviation, no positive weight at all, or value = 0 without a scale.
void check_targets(std::span<const Target> targets);

/// g(h) = sum_j w_j E|h_j - t_j| / s_j (or E(h_j - t_j)^2 / s_j^2) at known values h; without
/// measurement deviations the plain weighted sum of relative errors.
double weighted_error(std::span<const double> kpis, std::span<const Target> targets);

/// Mean and variance of sum_j w_j |h_j - t_j| / s_j over independent h_j ~ kpis[j] and t_j: |h_j -
/// t_j| is a folded normal [Leone1961], with Delta = mu - t and v = sigma^2 + s_t^2
///   E = sqrt(2 v/pi) exp(-Delta^2/2v) + Delta erf(Delta/sqrt(2 v)),  Var = Delta^2 + v - E^2,
/// (h_j - t_j)^2 / v a noncentral chi-squared variable:
///   E = Delta^2 + v,  Var = 2 v^2 + 4 Delta^2 v.
Gaussian weighted_error(std::span<const Gaussian> kpis, std::span<const Target> targets);

/// m x k standard normals from a scrambled quasi-random sequence: rows are draws.
Matrix scrambled_normals(Eigen::Index draws, Eigen::Index dimension, std::uint64_t seed);
/// The same before inversion: m x k numbers in (0, 1), Sobol' with a random digital shift.
Matrix scrambled_uniforms(Eigen::Index draws, Eigen::Index dimension, std::uint64_t seed);

/// E max(0, best - g(h)) over independent h_j ~ kpis[j], the mean over the rows z of `normals` (m x
/// k) with h_j = mu_j + sigma_j z_j [Astudillo2019]. Fixed draws make it a smooth
/// function of x.
double composite_expected_improvement(std::span<const Gaussian> kpis,
                                      std::span<const Target> targets, double best,
                                      const Matrix& normals);

/// The logarithm of a smoothed form that is never -infinity, so that points without any improving
/// draw are still ordered: max(0, u) is replaced by tau (softplus(u/tau) + 0.1/(1 + (u/tau)^2))
/// with tau = 1e-6 max(|best|, 1e-12) [Ament2023].
double log_composite_expected_improvement(std::span<const Gaussian> kpis,
                                          std::span<const Target> targets, double best,
                                          const Matrix& normals);

/// A value with its derivatives in the means and standard deviations of the k predictions.
struct CompositeGradient {
  double value = 0.0;
  Vector by_mean;
  Vector by_standard_deviation;
};

/// log_composite_expected_improvement, exact for these draws; where a draw of a quantity hits its
/// target exactly, that draw counts as flat.
CompositeGradient log_composite_expected_improvement_gradient(std::span<const Gaussian> kpis,
                                                              std::span<const Target> targets,
                                                              double best, const Matrix& normals);

}  // namespace repose::opt

#include "repose/opt/acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace repose::opt {
namespace {

constexpr double kHalfLogTwoPi = 0.91893853320467274178;
/// Below, the continued fraction; above, phi + z Phi loses less than a digit.
constexpr double kTail = -2.5;
/// Enough for a truncation error below 1e-20 at |z| = 2.5.
constexpr int kFractionTerms = 60;

double normal_density(double z) {
  return std::exp(-0.5 * z * z - kHalfLogTwoPi);
}
double normal_probability(double z) {
  return 0.5 * std::erfc(-z / std::numbers::sqrt2);
}

/// t of Mills' ratio m(a) = Phi(-a)/phi(a) = 1/(a + t), t = 1/(a + 2/(a + 3/(a + ...))).
double mills_fraction(double a) {
  double t = 0.0;
  for (int k = kFractionTerms; k >= 1; --k) t = k / (a + t);
  return t;
}

/// h(z)/phi(z) = 1 - |z| m(|z|) for z < 0.
double one_minus_z_mills(double z) {
  const double t = mills_fraction(-z);
  return t / (t - z);
}

double improvement_integral(double z) {
  if (z < kTail) return normal_density(z) * one_minus_z_mills(z);
  return normal_density(z) + z * normal_probability(z);
}

}  // namespace

double log_improvement_integral(double z) {
  if (z < kTail) return -0.5 * z * z - kHalfLogTwoPi + std::log(one_minus_z_mills(z));
  return std::log(improvement_integral(z));
}

double expected_improvement(const Gaussian& prediction, double best) {
  const double gain = best - prediction.mean;
  if (prediction.variance <= 0.0) return std::max(0.0, gain);
  const double sigma = prediction.standard_deviation();
  return sigma * improvement_integral(gain / sigma);
}

double log_expected_improvement(const Gaussian& prediction, double best) {
  const double gain = best - prediction.mean;
  if (prediction.variance <= 0.0)
    return gain > 0.0 ? std::log(gain) : -std::numeric_limits<double>::infinity();
  const double sigma = prediction.standard_deviation();
  return std::log(sigma) + log_improvement_integral(gain / sigma);
}

AcquisitionGradient log_expected_improvement_gradient(const Gaussian& prediction, double best) {
  AcquisitionGradient result{.value = log_expected_improvement(prediction, best)};
  const double gain = best - prediction.mean;
  if (prediction.variance <= 0.0) {
    if (gain > 0.0) result.by_mean = -1.0 / gain;
    return result;
  }
  const double sigma = prediction.standard_deviation();
  const double z = gain / sigma;
  if (z < kTail) {  // Phi/h = 1/t and phi/h = (|z| + t)/t
    const double t = mills_fraction(-z);
    result.by_mean = -1.0 / (sigma * t);
    result.by_standard_deviation = (t - z) / (sigma * t);
  } else {
    const double h = improvement_integral(z);
    result.by_mean = -normal_probability(z) / (sigma * h);
    result.by_standard_deviation = normal_density(z) / (sigma * h);
  }
  return result;
}

double lower_confidence_bound(const Gaussian& prediction, double kappa) {
  return prediction.mean - kappa * prediction.standard_deviation();
}

}  // namespace repose::opt

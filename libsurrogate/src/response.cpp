#include "response.hpp"

#include <cmath>
#include <limits>

namespace repose::surrogate {
namespace {

double logistic(double z) {
  return z >= 0.0 ? 1.0 / (1.0 + std::exp(-z)) : std::exp(z) / (1.0 + std::exp(z));
}

/// With m = E[y] = exp(mu + v/2), Var[y] = m^2 (e^v - 1).
Moments log_normal(const Gaussian& g) {
  const double mean = std::exp(g.mean + 0.5 * g.variance);
  const double excess = std::expm1(g.variance);
  const double square = mean * mean;
  return {{mean, square * excess},
          mean,
          0.5 * mean,
          2.0 * square * excess,
          square * (excess + std::exp(g.variance))};
}

/// y = s(z), s' = s (1 - s), s'' = s' (1 - 2 s); d/dmu E[f] = E[f'], d/dv E[f] = E[f'']/2.
Moments logit_normal(const Gaussian& g) {
  constexpr int kNodes = 128;  // on each side
  constexpr double kStep = 1.0 / 16.0;
  const double sd = g.standard_deviation();
  double weights = 0.0;
  double first = 0.0;
  double second = 0.0;
  double d_first = 0.0;
  double dd_first = 0.0;
  double d_second = 0.0;
  double dd_second = 0.0;
  const double centre = logistic(g.mean);
  for (int i = -kNodes; i <= kNodes; ++i) {
    const double t = kStep * i;
    const double w = std::exp(-0.5 * t * t);
    const double s = logistic(g.mean + sd * t);
    const double ds = s * (1.0 - s);
    const double dds = ds * (1.0 - 2.0 * s);
    const double deviation = s - centre;  // no cancellation where the variance is small
    weights += w;
    first += w * deviation;
    second += w * deviation * deviation;
    d_first += w * ds;
    dd_first += w * dds;
    d_second += w * 2.0 * deviation * ds;
    dd_second += w * 2.0 * (ds * ds + deviation * dds);
  }
  for (double* sum : {&first, &second, &d_first, &dd_first, &d_second, &dd_second}) *sum /= weights;
  return {{centre + first, second - first * first},
          d_first,
          0.5 * dd_first,
          d_second - 2.0 * first * d_first,
          0.5 * dd_second - first * dd_first};
}

}  // namespace

double modelled(ResponseScale scale, double y) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  switch (scale) {
    case ResponseScale::linear:
      return y;
    case ResponseScale::log:
      return y > 0.0 ? std::log(y) : kNaN;
    case ResponseScale::logit:
      return y > 0.0 && y < 1.0 ? std::log(y) - std::log1p(-y) : kNaN;
  }
  return kNaN;
}

double unmodelled(ResponseScale scale, double value) {
  switch (scale) {
    case ResponseScale::linear:
      return value;
    case ResponseScale::log:
      return std::exp(value);
    case ResponseScale::logit:
      return logistic(value);
  }
  return value;
}

double log_jacobian(ResponseScale scale, double y) {
  switch (scale) {
    case ResponseScale::linear:
      return 0.0;
    case ResponseScale::log:
      return -std::log(y);
    case ResponseScale::logit:
      return -std::log(y) - std::log1p(-y);
  }
  return 0.0;
}

Moments moments(ResponseScale scale, const Gaussian& g) {
  switch (scale) {
    case ResponseScale::linear:
      return {.y = g};
    case ResponseScale::log:
      return log_normal(g);
    case ResponseScale::logit:
      return logit_normal(g);
  }
  return {.y = g};
}

}  // namespace repose::surrogate

// Responses that are modelled on another scale than their own.
#pragma once

#include "repose/base/gaussian.hpp"
#include "repose/surrogate/gaussian_process_options.hpp"

namespace repose::surrogate {

/// g(y): y, log y or log(y/(1-y)); not a number where y is not allowed.
double modelled(ResponseScale scale, double y);
/// y of g(y).
double unmodelled(ResponseScale scale, double value);
/// log |g'(y)|.
double log_jacobian(ResponseScale scale, double y);

/// Mean and variance of y where g(y) is normal, with their derivatives in mean and variance of
/// g(y). Log: the log-normal's. Logit: integrals by the trapezoidal rule, 1e-12 relative.
struct Moments {
  Gaussian y;
  double mean_by_mean = 1.0;
  double mean_by_variance = 0.0;
  double variance_by_mean = 0.0;
  double variance_by_variance = 1.0;
};
Moments moments(ResponseScale scale, const Gaussian& modelled);

}  // namespace repose::surrogate

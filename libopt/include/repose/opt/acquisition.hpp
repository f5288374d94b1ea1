// How much a new point promises, as pure functions of a prediction. Minimisation throughout.
#pragma once

#include "repose/base/gaussian.hpp"

namespace repose::opt {

/// E max(0, best - f), f ~ prediction [Jones1998, Eq. 15]: (best - mu) Phi(z) + sigma phi(z) with
/// z = (best - mu)/sigma; max(0, best - mu) where the variance is 0. Relative error 1e-14 down to
/// where the result underflows (z about -38).
double expected_improvement(const Gaussian& prediction, double best);

/// Its natural logarithm, finite wherever sigma > 0 (z down to -1e150) [Ament2023, Eq. 9 and
/// appendix]; -infinity where the variance is 0 and mu >= best.
double log_expected_improvement(const Gaussian& prediction, double best);

/// log(phi(z) + z Phi(z)), relative error below 1e-14 for z < -1, 1e-15 absolute near its zero at z
/// = 0.9.
double log_improvement_integral(double z);

/// Scaled complementary error function exp(x^2) erfc(x) for x >= -5; relative error below 1e-14.
double erfcx(double x);

}  // namespace repose::opt

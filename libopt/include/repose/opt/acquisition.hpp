// How much a new point promises, as pure functions of a prediction. Minimisation throughout.
#pragma once

#include "repose/base/gaussian.hpp"

namespace repose::opt {

/// E max(0, best - f), f ~ prediction [Jones1998, Eq. 15; thesis Eq. 17]: sigma h(z) with h(z) =
/// phi(z) + z Phi(z) and z = (best - mu)/sigma; max(0, best - mu) where the variance is 0. Relative
/// error below 2e-13 down to where the result underflows (z = -38).
double expected_improvement(const Gaussian& prediction, double best);

/// Its natural logarithm, finite wherever sigma > 0 (z down to -1e150) [Ament2023];
/// -infinity where the variance is 0 and mu >= best.
double log_expected_improvement(const Gaussian& prediction, double best);

/// A value with its derivatives in the mean and the standard deviation of the prediction.
struct AcquisitionGradient {
  double value = 0.0;
  double by_mean = 0.0;
  double by_standard_deviation = 0.0;
};

/// log_expected_improvement with d/d mu = -Phi/(sigma h) and d/d sigma = phi/(sigma h), finite and
/// to 1e-14 relative however far in the tail. Where the variance is 0: -1/(best - mu) and 0, both 0
/// where the value is -infinity.
AcquisitionGradient log_expected_improvement_gradient(const Gaussian& prediction, double best);

/// log h(z) = log(phi(z) + z Phi(z)). Below z = -2.5 by the continued fraction of Mills' ratio,
/// free of cancellation: h = phi t/(|z| + t), t = 1/(|z| + 2/(|z| + 3/...)). Relative error below
/// 1e-14, absolute below 1e-15 around its zero at z = 0.9.
double log_improvement_integral(double z);

/// mu - kappa sigma: what the function may be at best; the point where it is smallest is worth a
/// run [Cox1992].
double lower_confidence_bound(const Gaussian& prediction, double kappa);

}  // namespace repose::opt

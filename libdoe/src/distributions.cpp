// Tails of F and t through the incomplete beta function.
#include "repose/doe/distributions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"

namespace repose::doe {
namespace {

using Policy = boost::math::policies::policy<
    boost::math::policies::underflow_error<boost::math::policies::ignore_error>>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

void check_test(double df, double alpha) {
  if (!(alpha > 0.0 && alpha < 1.0))
    throw InputError(fmt::format("t test: a level of {} is not in (0, 1)", alpha));
  if (!(df >= 1.0))
    throw InputError(fmt::format("t test: {} degrees of freedom; at least 1 is needed", df));
}

}  // namespace

double f_upper_tail(double f, double df1, double df2) {
  if (std::isnan(f) || !(df1 > 0.0) || !(df2 > 0.0)) return kNaN;
  if (f <= 0.0) return 1.0;
  if (std::isinf(f)) return 0.0;
  // P(F > f) = I_x(df2/2, df1/2), x = df2/(df2 + df1 f) [Abramowitz1964, 26.6.2]; when x is close
  // to 1 the complement of I is taken at 1 - x, which is then known exactly.
  const double ratio = df1 * f / df2;
  if (ratio < 1.0)
    return boost::math::ibetac(0.5 * df1, 0.5 * df2, ratio / (1.0 + ratio), Policy());
  return boost::math::ibeta(0.5 * df2, 0.5 * df1, 1.0 / (1.0 + ratio), Policy());
}

double t_two_sided(double t, double df) {
  return f_upper_tail(t * t, 1.0, df);
}

double t_critical(double alpha, double df) {
  check_test(df, alpha);
  return quantile(complement(boost::math::students_t_distribution<double>(df), 0.5 * alpha));
}

double t_test_power(double effect, double df, double alpha) {
  check_test(df, alpha);
  if (!std::isfinite(effect))
    throw InputError(fmt::format("t test: an effect of {} is not finite", effect));
  effect = std::abs(effect);
  const double critical = t_critical(alpha, df);
  // The estimated deviation is never 40 times the true one (probability below 1e-300).
  if (effect > 40.0 * (critical + 1.0)) return 1.0;
  if (effect == 0.0) return alpha;
  const boost::math::non_central_t_distribution<double> estimated(df, effect);
  return std::clamp(cdf(complement(estimated, critical)) + cdf(estimated, -critical), 0.0, 1.0);
}

Vector half_normal_quantiles(int count) {
  if (count < 0) throw InputError(fmt::format("half-normal quantiles: a count of {}", count));
  Vector quantiles(count);
  for (int i = 0; i < count; ++i)  // Phi^-1(1/2 + p/2) = sqrt(2) erf^-1(p)
    quantiles(i) = std::sqrt(2.0) * boost::math::erf_inv((i + 0.5) / count);
  return quantiles;
}

}  // namespace repose::doe

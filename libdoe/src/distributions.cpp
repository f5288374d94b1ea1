// Tails of F and t through the incomplete beta function.
#include "repose/doe/distributions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/math/special_functions/beta.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "repose/base/error.hpp"

namespace repose::doe {
namespace {

using Policy = boost::math::policies::policy<
    boost::math::policies::underflow_error<boost::math::policies::ignore_error>>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double normal_cdf(double z) {
  return 0.5 * std::erfc(-z / std::sqrt(2.0));
}

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
  // s = (estimated/true standard deviation) has the density of sqrt(chi^2_df/df); given s the
  // estimate, normal about `effect`, must lie outside -+ critical s. Beyond ten deviations of s
  // there is less than 1e-20.
  const double log_norm =
      std::log(2.0) + 0.5 * df * std::log(0.5 * df) - boost::math::lgamma(0.5 * df, Policy());
  const auto integrand = [&](double s) {
    if (s <= 0.0) return df == 1.0 ? std::exp(log_norm) : 0.0;
    const double density = std::exp(log_norm + (df - 1.0) * std::log(s) - 0.5 * df * s * s);
    return density * (normal_cdf(effect - critical * s) + normal_cdf(-effect - critical * s));
  };
  const double width = 10.0 / std::sqrt(df);
  const double low = std::max(0.0, 1.0 - width), high = 1.0 + width;
  const double step = effect / critical;  // where the probability falls from 1 to 0
  std::vector<double> nodes{low};
  for (const double node : {step - 8.0 / critical, step, step + 8.0 / critical, 1.0})
    if (node > low && node < high) nodes.push_back(node);
  nodes.push_back(high);
  std::sort(nodes.begin(), nodes.end());
  double power = 0.0;
  for (std::size_t i = 1; i < nodes.size(); ++i)
    if (nodes[i] > nodes[i - 1])
      power += boost::math::quadrature::gauss_kronrod<double, 61>::integrate(
          integrand, nodes[i - 1], nodes[i], 10, 1e-12);
  return std::clamp(power, 0.0, 1.0);
}

Vector half_normal_quantiles(int count) {
  if (count < 0) throw InputError(fmt::format("half-normal quantiles: a count of {}", count));
  Vector quantiles(count);
  for (int i = 0; i < count; ++i)  // Phi^-1(1/2 + p/2) = sqrt(2) erf^-1(p)
    quantiles(i) = std::sqrt(2.0) * boost::math::erf_inv((i + 0.5) / count);
  return quantiles;
}

}  // namespace repose::doe

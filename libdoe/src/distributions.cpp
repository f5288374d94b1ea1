// Tails of F and t through the incomplete beta function.
#include "repose/doe/distributions.hpp"

#include <boost/math/special_functions/beta.hpp>
#include <cmath>
#include <limits>

namespace repose::doe {
namespace {

using Policy = boost::math::policies::policy<
    boost::math::policies::underflow_error<boost::math::policies::ignore_error>>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

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

}  // namespace repose::doe

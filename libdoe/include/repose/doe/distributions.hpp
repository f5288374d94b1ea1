// Tail probabilities of the tests, accurate far into the tail, and the power of the t test.
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// P(F > f) for Fisher's F with (df1, df2) degrees of freedom; relative error below 1e-12 down to
/// 1e-300. 1 for f <= 0, 0 for f = infinity, NaN if f is NaN or a df is not positive.
double f_upper_tail(double f, double df1, double df2);

/// P(|T| > |t|) for Student's t; relative error as above. NaN if t is NaN or df is not positive.
double t_two_sided(double t, double df);

/// The t with t_two_sided(t, df) = alpha. Throws InputError unless 0 < alpha < 1 and df >= 1.
double t_critical(double alpha, double df);

/// Probability that a coefficient is found significant at level alpha in a two-sided t test when it
/// truly is `effect` of its standard errors, by the noncentral t distribution. Error below 1e-9.
/// Throws InputError unless 0 < alpha < 1, df >= 1 and `effect` is finite.
double t_test_power(double effect, double df, double alpha);

/// Where the absolute values of `count` normal numbers of deviation 1 lie when sorted, for a
/// half-normal plot: Phi^-1(1/2 + (i - 1/2)/(2 count)), i = 1 ... count [Daniel1959]. Throws
/// InputError if count < 0.
Vector half_normal_quantiles(int count);

}  // namespace repose::doe

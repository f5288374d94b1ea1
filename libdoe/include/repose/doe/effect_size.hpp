// How large is a difference or a dependence, beside whether it is significant?
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// (mean a - mean b) / sqrt((s_a^2 + s_b^2)/2) with sample variances [Hadi2026, Eqs. 3.7, 3.8];
/// about 0.2 is called small, 0.5 medium, 0.8 large [Cohen1988]. NaN if both are constant and
/// equal, infinite if constant and different. Throws InputError for fewer than two values of either
/// or a value that is not finite.
double cohens_d(const Vector& a, const Vector& b);

/// Standard deviation over |mean|; infinite for a mean of 0. `sample` divides squares by n - 1,
/// `population` by n. The two differ by a factor sqrt(n/(n-1)), 12 % for n = 5, and papers seldom
/// say which.
struct CoefficientOfVariation {
  double sample = 0.0;
  double population = 0.0;
};
/// Throws InputError as cohens_d().
CoefficientOfVariation coefficient_of_variation(const Vector& values);

struct Correlation {
  double pearson = 0.0;
  double p = 0.0;         ///< two-sided, of no correlation; NaN for fewer than three values
  double spearman = 0.0;  ///< of ranks, ties sharing the mean of theirs
};
/// NaN if either is constant. Throws InputError for different lengths, fewer than two values or a
/// value that is not finite.
Correlation correlation(const Vector& a, const Vector& b);

/// alpha = sd(means of the runs) / mean(sd of each run's repetitions) [Hadi2026, Eq. 3.5]: large if
/// what was varied matters more than repeating. Runs alone give no 0 but the floor.
struct SignalToRepetition {
  double alpha = 0.0;  ///< infinite if repetitions agree exactly
  /// What alpha tends to in pure noise, many runs: 1 / (sqrt(R) c4(R)), 0.651 for R = 3. NaN if
  /// runs have different numbers of repetitions.
  double floor = 0.0;
};
/// `values` is runs x repetitions; NaN is a missing value, runs with fewer than two values are left
/// out. Throws InputError if fewer than two runs remain or a value is infinite.
SignalToRepetition signal_to_repetition(const Matrix& values);

/// Expected sample standard deviation of n normal numbers of deviation 1:
/// sqrt(2/(n-1)) Gamma(n/2) / Gamma((n-1)/2). Throws InputError if n < 2.
double c4(int n);

}  // namespace repose::doe

// How much of a response's variance comes from the parameters and how much from repeating a run.
#pragma once

#include "repose/base/parameter_space.hpp"

namespace repose::doe {

/// One-way analysis of variance of runs with repetitions. Shares are fractions, not percent.
struct VarianceDecomposition {
  int runs = 0;          ///< with at least one value
  int observations = 0;  ///< values that are not missing
  double between_ss = 0.0;
  double within_ss = 0.0;
  double parameter_share = 0.0;  ///< P = between / total [Hadi2026, Eq. 5.5]; NaN if nothing varies
  double stochastic_share = 0.0;  ///< S = 1 - P [Hadi2026, Eq. 5.6]
  /// What P is on average when parameters have no effect at all: (runs - 1)/(observations - 1).
  double noise_floor = 0.0;
  double within_ms = 0.0;          ///< repetition variance; NaN without repetitions
  double unbiased_variance = 0.0;  ///< (MSB - MSW)/R, of the runs; may be negative
  double unbiased_share = 0.0;     ///< unbiased_variance / (unbiased_variance + MSW), not below 0
  double f = 0.0;                  ///< MSB/MSW
  double p_value = 0.0;
};

/// `values` is runs x repetitions; NaN is a missing value. With unequal numbers of repetitions R is
/// replaced by (N - sum n_i^2 / N)/(runs - 1). Deviations are taken from the first value, then from
/// the means. Throws InputError if fewer than two runs have a value or a value is infinite.
VarianceDecomposition decompose_variance(const Matrix& values);

}  // namespace repose::doe

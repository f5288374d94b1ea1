// The search for the hyper-parameters of a Gaussian process.
#pragma once

#include <string>
#include <vector>

#include "likelihood.hpp"
#include "repose/surrogate/fit_report.hpp"

namespace repose::surrogate {

/// A log parameter this close to a bound sits on it.
inline constexpr double kAtBound = 1e-3;

/// The hyper-parameters of a fit, in the order of NegativeLogPosterior.
struct SearchSpace {
  std::vector<std::string> names;
  Vector unit;  ///< natural value = unit exp(log parameter)
  opt::Bounds bounds;
};

/// Whether the process variance must be searched for.
Amplitude amplitude_of(const GaussianProcessOptions& options);

/// Throws InputError naming a bounded parameter that does not exist or whose bounds are not
/// positive and in order.
SearchSpace make_search_space(const NegativeLogPosterior& objective, const Dataset& data,
                              const GaussianProcessOptions& options);

/// The best of a grid and of the minima found from there and around it, over the parameters that
/// are not fixed. Evaluations of the grid are counted.
opt::Minimum search(const NegativeLogPosterior& objective, const SearchSpace& space,
                    const Dataset& data, const GaussianProcessOptions& options);

/// The log parameters that a fit without any search has: long scales, little noise.
Vector default_parameters(const NegativeLogPosterior& objective, const SearchSpace& space);

/// What to say of each parameter at log parameters p.
std::vector<FittedParameter> describe(const Vector& p, const SearchSpace& space,
                                      const NegativeLogPosterior& objective, const Dataset& data);

}  // namespace repose::surrogate

// Gaussian processes for Bayesian optimisation.
#pragma once

#include "repose/opt/bayesian_optimizer.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

/// What a model has to know of parameters: ranges, scales and categories.
std::vector<Input> inputs_of(const ParameterSpace& parameters);

/// Fits a Gaussian process with `options` to each response, for an opt::BayesianOptimizer over the
/// free parameters of `parameters`.
opt::SurrogateFitter gaussian_process_fitter(const ParameterSpace& parameters,
                                             const GaussianProcessOptions& options = {});

}  // namespace repose::surrogate

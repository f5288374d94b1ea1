// What a Gaussian process holds; shared by its implementation and by model files.
#pragma once

#include "factor.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

struct GaussianProcess::State {
  Dataset data = {};
  Covariance covariance = {};
  double amplitude = 0.0;  ///< process variance in squared units of the standardised response
  Noise noise = Noise::estimated;
  Estimator estimator = Estimator::reml;
  Factor factor = {};
  FitReport report = {};
};

struct ModelAccess {
  using State = GaussianProcess::State;
  static const State& state(const GaussianProcess& model) { return *model.state_; }
  static GaussianProcess make(State state) {
    return GaussianProcess(std::make_shared<const State>(std::move(state)));
  }
};

}  // namespace repose::surrogate

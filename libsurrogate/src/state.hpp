// What a Gaussian process holds; shared by its implementation and by model files.
#pragma once

#include "factor.hpp"

namespace repose::surrogate {

struct GaussianProcess::State {
  Dataset data = {};
  Covariance covariance = {};  ///< length scales in units of the declared range
  double amplitude = 0.0;      ///< in squared units of the standardised response
  Noise noise = Noise::estimated;
  Basis basis = Basis::constant;
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

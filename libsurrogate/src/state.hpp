// What a Gaussian process holds; shared by its implementation and by model files.
#pragma once

#include <cmath>

#include "parameter_uncertainty.hpp"
#include "repose/surrogate/gaussian_process.hpp"

namespace repose::surrogate {

struct GaussianProcess::State {
  Dataset data = {};
  Covariance covariance = {};
  double amplitude = 0.0;  ///< process variance in squared units of the standardised response
  Noise noise = Noise::estimated;
  Estimator estimator = Estimator::reml;
  Factor factor = {};
  ParameterPosterior parameters = {};
  MeanSensitivity sensitivity = {};  ///< by `parameters`; empty where these are taken as known
  FitReport report = {};

  /// In squared units of the modelled response, as predictions have it.
  double predicted_amplitude() const {
    return data.scale * data.scale * amplitude * parameters.variance_factor;
  }
  /// Once data, covariance, amplitude, factor and parameters are there.
  void find_sensitivity() {
    sensitivity =
        parameters.root.size() == 0 || amplitude == 0.0
            ? MeanSensitivity()
            : MeanSensitivity(data, covariance, factor, parameters.root, std::sqrt(amplitude));
  }
};

struct ModelAccess {
  using State = GaussianProcess::State;
  static const State& state(const GaussianProcess& model) { return *model.state_; }
  static GaussianProcess make(State state) {
    return GaussianProcess(std::make_shared<const State>(std::move(state)));
  }
};

}  // namespace repose::surrogate

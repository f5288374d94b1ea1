#include "repose/surrogate/fitter.hpp"

namespace repose::surrogate {

std::vector<Input> inputs_of(const ParameterSpace& parameters) {
  std::vector<Input> inputs;
  for (const Parameter& p : parameters.parameters())
    inputs.push_back(
        {.lower = p.lower, .upper = p.upper, .scale = p.scale, .levels = p.categories});
  return inputs;
}

opt::SurrogateFitter gaussian_process_fitter(const ParameterSpace& parameters,
                                             const GaussianProcessOptions& options) {
  return [inputs = inputs_of(parameters), options](const Matrix& x, const Matrix& y) {
    std::vector<opt::Surrogate> models;
    for (const auto& response : y.colwise())
      models.emplace_back(GaussianProcess::fit(x, response, inputs, options));
    return models;
  };
}

}  // namespace repose::surrogate

#include "repose/surrogate/gaussian_process_regressor.hpp"

#include <fmt/format.h>

#include "repose/base/error.hpp"

namespace repose::surrogate {

GaussianProcessRegressor::GaussianProcessRegressor(GaussianProcess process)
    : process_(std::move(process)) {}

Vector GaussianProcessRegressor::predict(const Matrix& x) const {
  const std::vector<Gaussian> rows = process_.predict_rows(x);
  Vector mean(x.rows());
  for (Eigen::Index i = 0; i < mean.size(); ++i) mean[i] = rows[static_cast<std::size_t>(i)].mean;
  return mean;
}

Predictions GaussianProcessRegressor::predict_with_variances(const Matrix& x) const {
  const Eigen::Index m = x.rows();
  Predictions result{Vector(m), Vector(m), Vector(m)};
  Eigen::Index i = 0;
  for (const Prediction& p : process_.predictions(x)) {
    result.mean[i] = p.function.mean;
    result.function_variance[i] = p.function.variance;
    result.observation_variance[i++] = p.observation_variance;
  }
  return result;
}

std::string GaussianProcessRegressor::describe() const {
  const Hyperparameters h = process_.hyperparameters();
  return fmt::format("Gaussian process, {}, basis {}, standard deviation of the noise {:.4g}",
                     to_string(process_.kernel()), to_string(process_.basis()),
                     std::sqrt(h.noise_variance));
}

const GaussianProcess* gaussian_process(const Regressor& model) {
  const auto* found = model.target<GaussianProcessRegressor>();
  return found == nullptr ? nullptr : &found->process();
}

void refuse_weights(const TrainingSet& data) {
  if (data.weights.size() > 0)
    throw InputError("a Gaussian process takes no weights; repeat rows or leave them out");
}

Trainer gaussian_process_trainer(std::string name, const GaussianProcessOptions& options) {
  if (options.noise == Noise::known)
    throw InputError(
        "known noise variances belong to rows and cannot be settings of a trainer; let the noise "
        "be "
        "estimated or by point");
  return {std::move(name), [options](const TrainingSet& data, std::uint64_t seed) -> Regressor {
            check(data);
            refuse_weights(data);
            GaussianProcessOptions o = options;
            o.seed = seed;
            return GaussianProcessRegressor(GaussianProcess::fit(data.x, data.y, data.inputs, o));
          }};
}

}  // namespace repose::surrogate

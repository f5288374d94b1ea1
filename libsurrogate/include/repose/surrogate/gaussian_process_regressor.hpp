// Gaussian processes among the other models.
#pragma once

#include <string>

#include "repose/surrogate/gaussian_process.hpp"
#include "repose/surrogate/regressor.hpp"

namespace repose::surrogate {

/// A Gaussian process as a RegressorLike.
class GaussianProcessRegressor {
 public:
  explicit GaussianProcessRegressor(GaussianProcess process);
  const GaussianProcess& process() const { return process_; }

  Vector predict(const Matrix& x) const;
  Predictions predict_with_variances(const Matrix& x) const;
  const std::vector<Input>& inputs() const { return process_.inputs(); }
  std::string describe() const;  ///< "Gaussian process, ard-matern52, basis constant, ..."

 private:
  GaussianProcess process_;
};

/// The Gaussian process that a model is, else nullptr.
const GaussianProcess* gaussian_process(const Regressor& model);

/// Throws InputError where rows have weights, which a Gaussian process does not take.
void refuse_weights(const TrainingSet& data);

/// GaussianProcess::fit with these options and the seed of each fit. Refuses weights and, as they
/// belong to rows, known noise variances.
Trainer gaussian_process_trainer(std::string name, const GaussianProcessOptions& options = {});

}  // namespace repose::surrogate

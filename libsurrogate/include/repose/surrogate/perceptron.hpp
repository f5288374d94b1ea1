// Multilayer perceptrons: piecewise linear functions from layers of rectified neurons.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "repose/surrogate/regressor.hpp"
#include "repose/surrogate/standardisation.hpp"

namespace repose::surrogate {

struct PerceptronOptions {
  std::vector<int> layers = {10};  ///< neurons of each hidden layer, 1 to 1000; one to three layers
  /// lambda in the loss sum w (f - y)^2 / (2 sum w) + lambda/2 sum W^2 over weights W, not biases,
  /// y standardised; >= 0.
  double penalty = 0.0;
  /// Trained from weights of their own by chance; the prediction is their mean. >= 1.
  int networks = 3;
  Standardisation standardisation = Standardisation::standard_deviation;
  int max_evaluations = 1000;  ///< of the loss for each network, by L-BFGS; >= 1
};

/// How the training of one network ended.
struct PerceptronTraining {
  double loss = 0.0;
  int evaluations = 0;
  bool converged = false;  ///< else evaluations were used up; the best weights are kept
};

/// A fitted model; never unfitted. Cheap to copy, safe to use from several threads.
class Perceptron {
 public:
  /// Weights start uniform in +-sqrt(6/(fan-in + fan-out)) [GlorotBengio2010], biases at 0; the
  /// loss goes down by L-BFGS. A category has an indicator for each level (one number where it is
  /// coded by label). A constant y gives that constant. Throws InputError as check(TrainingSet),
  /// and on options out of their range.
  static Perceptron fit(const TrainingSet& data, std::uint64_t seed,
                        const PerceptronOptions& options = {});

  const std::vector<Input>& inputs() const;
  std::string describe() const;  ///< "neural network, 10-10 rectified neurons, mean of 3 networks"
  const std::vector<PerceptronTraining>& training() const;  ///< of each network

  /// At the rows of x (m x d), natural units.
  Vector predict(const Matrix& x) const;

 private:
  struct State;
  explicit Perceptron(std::shared_ptr<const State> state);
  friend struct PerceptronAccess;  // reads and rebuilds the state for model files
  std::shared_ptr<const State> state_;
};

/// Perceptron::fit with these options and the seed of each fit.
Trainer perceptron_trainer(std::string name, const PerceptronOptions& options = {});

}  // namespace repose::surrogate

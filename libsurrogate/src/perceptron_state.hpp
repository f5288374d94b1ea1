// What a perceptron holds; shared by its implementation and by model files.
#pragma once

#include "perceptron_network.hpp"
#include "repose/surrogate/perceptron.hpp"
#include "standardised.hpp"

namespace repose::surrogate {

/// y = shift + scale * mean over networks of their output.
struct Perceptron::State {
  StandardisedColumns columns = {};
  std::vector<int> layers = {};
  double shift = 0.0;
  double scale = 0.0;                   ///< 0 of a constant response, which has no network
  std::vector<Vector> parameters = {};  ///< of each network
  std::vector<PerceptronTraining> training = {};

  Network network() const { return {columns.count(), layers}; }
};

struct PerceptronAccess {
  using State = Perceptron::State;
  static const State& state(const Perceptron& model) { return *model.state_; }
  static Perceptron make(State state) {
    return Perceptron(std::make_shared<const State>(std::move(state)));
  }
};

}  // namespace repose::surrogate

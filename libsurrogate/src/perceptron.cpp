#include "repose/surrogate/perceptron.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "perceptron_state.hpp"
#include "repose/base/error.hpp"
#include "repose/opt/minimizer.hpp"

namespace repose::surrogate {
namespace {

/// Far beyond any weight of standardised data.
constexpr double kLargestWeight = 1e3;

void check_options(const PerceptronOptions& o) {
  if (o.layers.empty() || o.layers.size() > 3)
    throw InputError(fmt::format("a neural network of {} hidden layers; it must have one to three",
                                 o.layers.size()));
  for (const int size : o.layers)
    if (size < 1 || size > 1000)
      throw InputError(
          fmt::format("a neural network with a layer of {} neurons; 1 to 1000 are allowed", size));
  if (!(o.penalty >= 0.0) || !std::isfinite(o.penalty))
    throw InputError(
        fmt::format("the penalty of a neural network is {}; it must be 0 or positive", o.penalty));
  if (o.networks < 1 || o.max_evaluations < 1)
    throw InputError(fmt::format("{} neural networks of {} evaluations; both must be at least 1",
                                 o.networks, o.max_evaluations));
}

/// Trains one network from start number `stream` and appends it.
void train(PerceptronAccess::State& s, const Matrix& z, const Vector& target, const Vector& weights,
           const PerceptronOptions& options, std::uint64_t seed, std::uint64_t stream) {
  const Network network = s.network();
  const opt::Objective loss = [&](const Vector& parameters, Vector* gradient) {
    return network.loss(z, target, weights, options.penalty, parameters, gradient);
  };
  const Eigen::Index n = network.parameters();
  const opt::Minimum minimum =
      opt::minimize(loss, network.start(seed, stream),
                    {Vector::Constant(n, -kLargestWeight), Vector::Constant(n, kLargestWeight)},
                    {.relative_x_tolerance = 1e-7,
                     .absolute_x_tolerance = 0.0,
                     .relative_f_tolerance = 1e-7,
                     .max_evaluations = options.max_evaluations,
                     .initial_curvature = 1.0,
                     .fallback = opt::Fallback::none});
  s.parameters.push_back(minimum.x);
  s.training.push_back({.loss = minimum.value,
                        .evaluations = minimum.evaluations,
                        .converged = minimum.termination != opt::Termination::budget});
}

}  // namespace

Perceptron::Perceptron(std::shared_ptr<const State> state) : state_(std::move(state)) {}

Perceptron Perceptron::fit(const TrainingSet& data, std::uint64_t seed,
                           const PerceptronOptions& options) {
  check(data);
  check_options(options);
  const Vector& y = data.y;
  const Vector weights = data.weights.size() > 0 ? data.weights : Vector(Vector::Ones(data.rows()));
  State s{.columns = options.standardisation == Standardisation::none
                         ? StandardisedColumns::none(data.inputs)
                         : StandardisedColumns::of(data),
          .layers = options.layers,
          .shift = y[0]};
  if (y.minCoeff() < y.maxCoeff()) {
    s.shift = y.dot(weights) / weights.sum();
    s.scale = std::sqrt((y.array() - s.shift).square().matrix().dot(weights) / weights.sum());
    const Matrix z = s.columns.columns(data.x);
    const Vector target = (y.array() - s.shift) / s.scale;
    for (int i = 0; i < options.networks; ++i)
      train(s, z, target, weights, options, seed, static_cast<std::uint64_t>(i));
  }
  return Perceptron(std::make_shared<const State>(std::move(s)));
}

const std::vector<Input>& Perceptron::inputs() const {
  return state_->columns.inputs();
}

std::string Perceptron::describe() const {
  const std::size_t networks = state_->parameters.size();
  return fmt::format("neural network, {} rectified neurons{}", fmt::join(state_->layers, "-"),
                     networks > 1 ? fmt::format(", mean of {} networks", networks) : "");
}

const std::vector<PerceptronTraining>& Perceptron::training() const {
  return state_->training;
}

Vector Perceptron::predict(const Matrix& x) const {
  const State& s = *state_;
  const Matrix z = s.columns.columns(x);
  const Network network = s.network();
  Vector sum = Vector::Zero(x.rows());
  for (const Vector& parameters : s.parameters) sum += network.output(z, parameters);
  const auto networks = static_cast<double>(std::max<std::size_t>(s.parameters.size(), 1));
  return s.shift + s.scale / networks * sum.array();
}

Trainer perceptron_trainer(std::string name, const PerceptronOptions& options) {
  return {.name = std::move(name), .fit = [options](const TrainingSet& data, std::uint64_t seed) {
            return Regressor(Perceptron::fit(data, seed, options));
          }};
}

}  // namespace repose::surrogate

// Functions of two inputs that are alike or not, and rows of them.
#pragma once

#include <cmath>
#include <functional>

#include "repose/base/random.hpp"
#include "repose/surrogate/training_set.hpp"

namespace repose::surrogate::test {

using Function = std::function<double(const Vector&)>;

inline double bumps(const Vector& x) {
  return std::sin(5.0 * x[0]) + 0.8 * std::cos(3.0 * x[1] + x[0]);
}

/// Uniform in the unit square, with noise of this standard deviation.
inline TrainingSet sampled(const Function& f, Eigen::Index rows, double noise, std::uint64_t seed) {
  RandomStream random(seed);
  TrainingSet data{.x = Matrix(rows, 2), .y = Vector(rows), .inputs = std::vector<Input>(2)};
  for (double& u : data.x.reshaped()) u = random.uniform();
  for (Eigen::Index i = 0; i < rows; ++i) data.y[i] = f(data.x.row(i)) + noise * random.normal();
  return data;
}

}  // namespace repose::surrogate::test

// Functions of two inputs that are alike or not, and rows of them.
#pragma once

#include <cmath>
#include <functional>

#include "repose/base/random.hpp"
#include "repose/surrogate/transfer.hpp"

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

/// bumps() with another level, another scale and a part of its own.
inline double altered(const Vector& x) {
  return 1.0 + 1.5 * bumps(x) + 0.2 * std::cos(4.0 * x[0]);
}

/// A source of 40 rows of bumps() and a target of a few.
struct TransferCase {
  TrainingSet source = sampled(bumps, 40, 0.05, 1);
  PretrainedModel model = pretrained("gpr", source, 1);
  TrainingSet target;
  explicit TransferCase(const Function& f = altered, Eigen::Index rows = 8)
      : target(sampled(f, rows, 0.05, 2)) {}
  Transfer by(TransferMethod method) const {
    return transfer(model, source, target, {.method = method});
  }
};

}  // namespace repose::surrogate::test

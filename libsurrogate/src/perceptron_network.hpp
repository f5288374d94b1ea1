// One network of rectified neurons: its output, its loss and the gradient of that.
#pragma once

#include <cstdint>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::surrogate {

/// Layer l maps a_(l-1) (n x sizes[l-1]) to a_l = max(0, a_(l-1) W_l + b_l), the last one without
/// the maximum to one output. All weights stand in one vector, layer by layer: W_l by columns, b_l.
class Network {
 public:
  Network() = default;
  Network(Eigen::Index inputs, const std::vector<int>& hidden);

  Eigen::Index parameters() const { return parameters_; }
  const std::vector<Eigen::Index>& sizes() const { return sizes_; }
  /// Weights by chance [GlorotBengio2010], biases 0.
  Vector start(std::uint64_t seed, std::uint64_t stream) const;
  /// n outputs of n x p inputs.
  Vector output(const Matrix& z, const Vector& parameters) const;
  /// sum w (f - t)^2 / (2 sum w) + penalty/2 sum W^2; fills in the gradient where it is not null.
  double loss(const Matrix& z, const Vector& target, const Vector& weights, double penalty,
              const Vector& parameters, Vector* gradient) const;

 private:
  std::size_t layers() const { return sizes_.size() - 1; }
  Eigen::Map<const Matrix> weight(const Vector& parameters, std::size_t layer) const;
  Eigen::Map<const Vector> bias(const Vector& parameters, std::size_t layer) const;

  std::vector<Eigen::Index> sizes_;   // inputs, hidden layers, 1
  std::vector<Eigen::Index> offset_;  // of each layer's W in the parameters
  Eigen::Index parameters_ = 0;
};

}  // namespace repose::surrogate

#include "perceptron_network.hpp"

#include <cmath>

#include "repose/base/random.hpp"

namespace repose::surrogate {

Network::Network(Eigen::Index inputs, const std::vector<int>& hidden) {
  sizes_.push_back(inputs);
  for (const int size : hidden) sizes_.push_back(size);
  sizes_.push_back(1);
  for (std::size_t l = 0; l < layers(); ++l) {
    offset_.push_back(parameters_);
    parameters_ += (sizes_[l] + 1) * sizes_[l + 1];
  }
}

Eigen::Map<const Matrix> Network::weight(const Vector& parameters, std::size_t layer) const {
  return {parameters.data() + offset_[layer], sizes_[layer], sizes_[layer + 1]};
}

Eigen::Map<const Vector> Network::bias(const Vector& parameters, std::size_t layer) const {
  return {parameters.data() + offset_[layer] + sizes_[layer] * sizes_[layer + 1],
          sizes_[layer + 1]};
}

Vector Network::start(std::uint64_t seed, std::uint64_t stream) const {
  RandomStream random(seed, stream);
  Vector parameters = Vector::Zero(parameters_);
  for (std::size_t l = 0; l < layers(); ++l) {
    const double limit = std::sqrt(6.0 / static_cast<double>(sizes_[l] + sizes_[l + 1]));
    for (double& w : parameters.segment(offset_[l], sizes_[l] * sizes_[l + 1]))
      w = random.uniform(-limit, limit);
  }
  return parameters;
}

Vector Network::output(const Matrix& z, const Vector& parameters) const {
  Matrix a = z;
  for (std::size_t l = 0; l < layers(); ++l) {
    Matrix next = (a * weight(parameters, l)).rowwise() + bias(parameters, l).transpose();
    if (l + 1 < layers()) next = next.cwiseMax(0.0);
    a = std::move(next);
  }
  return a.col(0);
}

double Network::loss(const Matrix& z, const Vector& target, const Vector& weights, double penalty,
                     const Vector& parameters, Vector* gradient) const {
  std::vector<Matrix> a{z};
  for (std::size_t l = 0; l < layers(); ++l) {
    Matrix next = (a[l] * weight(parameters, l)).rowwise() + bias(parameters, l).transpose();
    if (l + 1 < layers()) next = next.cwiseMax(0.0);
    a.push_back(std::move(next));
  }
  const Vector residual = a.back().col(0) - target;
  const Vector share = weights / weights.sum();
  double value = 0.5 * share.dot(residual.cwiseAbs2());
  for (std::size_t l = 0; l < layers(); ++l)
    value += 0.5 * penalty * weight(parameters, l).squaredNorm();
  if (gradient == nullptr) return value;
  Matrix slope = share.cwiseProduct(residual);  // of the loss, in what each layer gives
  for (std::size_t l = layers(); l-- > 0;) {
    if (l + 1 < layers()) slope = (a[l + 1].array() > 0.0).select(slope, 0.0);
    const Matrix by_weight = a[l].transpose() * slope + penalty * weight(parameters, l);
    gradient->segment(offset_[l], by_weight.size()) = by_weight.reshaped();
    gradient->segment(offset_[l] + by_weight.size(), slope.cols()) = slope.colwise().sum();
    if (l > 0) slope = slope * weight(parameters, l).transpose();
  }
  return value;
}

}  // namespace repose::surrogate

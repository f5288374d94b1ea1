#include "standardised.hpp"

#include <cmath>

namespace repose::surrogate {

StandardisedColumns::StandardisedColumns(std::vector<Input> inputs, Vector shift, Vector factor)
    : encoding_(std::move(inputs), LengthScales::one_per_input),
      shift_(std::move(shift)),
      factor_(std::move(factor)) {}

StandardisedColumns StandardisedColumns::none(const std::vector<Input>& inputs) {
  const Eigen::Index p = Encoding(inputs, LengthScales::one_per_input).coordinates();
  return {inputs, Vector::Zero(p), Vector::Ones(p)};
}

StandardisedColumns StandardisedColumns::of(const TrainingSet& data) {
  const Matrix u = Encoding(data.inputs, LengthScales::one_per_input).encode(data.x);
  const Vector weights = data.weights.size() > 0 ? data.weights : Vector(Vector::Ones(data.rows()));
  const double total = weights.sum();
  const double free = 1.0 - 1.0 / static_cast<double>(data.rows());  // (n - 1)/n
  const Vector shift = u.transpose() * weights / total;
  Vector factor = Vector::Zero(u.cols());
  for (Eigen::Index k = 0; k < u.cols(); ++k) {
    const double square = (u.col(k).array() - shift[k]).square().matrix().dot(weights) / total;
    if (u.col(k).maxCoeff() > u.col(k).minCoeff() && square > 0.0)
      factor[k] = std::sqrt(free / square);
  }
  return {data.inputs, shift, factor};
}

Matrix StandardisedColumns::columns(const Matrix& natural) const {
  const Matrix u = encoding_.encode(natural);
  return (u.rowwise() - shift_.transpose()) * factor_.asDiagonal();
}

}  // namespace repose::surrogate

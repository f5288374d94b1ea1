#include "encoding.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace repose::surrogate {
namespace {

double log_range(const Input& input) {
  return std::log(input.upper) - std::log(input.lower);
}

double unit_value(const Input& input, double x) {
  if (input.scale == Scale::log) return (std::log(x) - std::log(input.lower)) / log_range(input);
  return (x - input.lower) / (input.upper - input.lower);
}

}  // namespace

Encoding::Encoding(std::vector<Input> inputs, LengthScales length_scales)
    : inputs_(std::move(inputs)), length_scales_(length_scales) {
  check_inputs(inputs_);
  for (std::size_t k = 0; k < inputs_.size(); ++k) {
    const Input& input = inputs_[k];
    const auto index = static_cast<Eigen::Index>(k);
    const std::string name = fmt::format("length_scale_{}", k + 1);
    if (!input.is_categorical()) {
      add(index, name, input.scale == Scale::log ? log_range(input) : input.upper - input.lower);
    } else if (input.coding == Coding::label) {
      add(index, name, 1.0);
    } else {
      for (std::size_t l = 0; l < input.levels.size(); ++l)
        add(index, input.coding == Coding::one_hot ? fmt::format("{}_{}", name, l + 1) : name, 1.0);
    }
  }
}

void Encoding::add(Eigen::Index input, const std::string& scale_name, double unit) {
  const bool shared = length_scales_ == LengthScales::shared;
  const std::string name = shared ? "length_scale" : scale_name;
  if (scale_names_.empty() || scale_names_.back() != name) {
    scale_names_.push_back(name);
    scale_units_.conservativeResize(scales());
    scale_units_[scales() - 1] = shared ? 1.0 : unit;
  }
  input_.push_back(input);
  scale_.push_back(scales() - 1);
}

Matrix Encoding::encode(const Matrix& natural) const {
  check_points(inputs_, natural);
  Matrix u = Matrix::Zero(natural.rows(), coordinates());
  Eigen::Index p = 0;
  for (Eigen::Index k = 0; k < dimension(); ++k) {
    const Input& input = inputs_[static_cast<std::size_t>(k)];
    const auto levels = static_cast<Eigen::Index>(input.levels.size());
    if (!input.is_categorical()) {
      for (Eigen::Index i = 0; i < natural.rows(); ++i) u(i, p) = unit_value(input, natural(i, k));
    } else if (input.coding == Coding::label) {
      u.col(p) = natural.col(k) / static_cast<double>(levels - 1);
    } else {
      const double one = input.coding == Coding::one_hot ? 1.0 : 1.0 / std::numbers::sqrt2;
      for (Eigen::Index i = 0; i < natural.rows(); ++i)
        u(i, p + static_cast<Eigen::Index>(natural(i, k))) = one;
      p += levels - 1;
    }
    ++p;
  }
  return u;
}

Vector Encoding::weights(const Vector& length_scales) const {
  Vector w(coordinates());
  for (Eigen::Index p = 0; p < w.size(); ++p)
    w[p] = 1.0 / (length_scales[scale_of(p)] * length_scales[scale_of(p)]);
  return w;
}

double Encoding::derivative(Eigen::Index input, double natural) const {
  const Input& i = inputs_[static_cast<std::size_t>(input)];
  if (i.is_categorical()) return 0.0;
  return i.scale == Scale::log ? 1.0 / (natural * log_range(i)) : 1.0 / (i.upper - i.lower);
}

bool Encoding::outside(Eigen::Index input, double natural) const {
  const Input& i = inputs_[static_cast<std::size_t>(input)];
  return !i.is_categorical() && (natural < i.lower || natural > i.upper);
}

}  // namespace repose::surrogate

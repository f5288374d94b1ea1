#include "linear_terms.hpp"

#include <fmt/format.h>

namespace repose::surrogate {
namespace {

bool has_indicators(const Input& input) {
  return input.is_categorical() && input.coding != Coding::label;
}

const Input& input_of(const Encoding& encoding, Eigen::Index coordinate) {
  return encoding.inputs()[static_cast<std::size_t>(encoding.input_of(coordinate))];
}

bool is_first_of_its_input(const Encoding& encoding, Eigen::Index coordinate) {
  return coordinate == 0 || encoding.input_of(coordinate) != encoding.input_of(coordinate - 1);
}

}  // namespace

CodedColumns::CodedColumns(std::vector<Input> inputs)
    : encoding_(std::move(inputs), LengthScales::one_per_input) {
  for (Eigen::Index p = 0; p < encoding_.coordinates(); ++p)
    if (!(has_indicators(input_of(encoding_, p)) && is_first_of_its_input(encoding_, p)))
      coordinate_.push_back(p);
}

Matrix CodedColumns::coded(const Matrix& natural) const {
  const Matrix u = encoding_.encode(natural);
  Matrix c(u.rows(), count());
  for (Eigen::Index k = 0; k < count(); ++k) {
    const Eigen::Index p = coordinate_[static_cast<std::size_t>(k)];
    if (has_indicators(input_of(encoding_, p)))
      c.col(k) = (u.col(p).array() > 0.0).cast<double>();
    else
      c.col(k) = 2.0 * u.col(p).array() - 1.0;
  }
  return c;
}

std::vector<doe::Term> CodedColumns::terms(LinearTerms which) const {
  std::vector<doe::Term> terms;
  const int n = static_cast<int>(count());
  for (int i = 0; i < n; ++i) terms.push_back(doe::main_effect(i));
  if (which == LinearTerms::linear) return terms;
  const auto input = [this](int column) {
    return encoding_.input_of(coordinate_[static_cast<std::size_t>(column)]);
  };
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j)
      if (input(i) != input(j)) terms.push_back(doe::interaction(i, j));
  return terms;
}

std::vector<std::string> CodedColumns::names(const std::vector<std::string>& inputs) const {
  std::vector<std::string> names;
  for (const Eigen::Index p : coordinate_) {
    const auto k = static_cast<std::size_t>(encoding_.input_of(p));
    Eigen::Index first = p;
    while (!is_first_of_its_input(encoding_, first)) --first;
    names.push_back(
        has_indicators(input_of(encoding_, p))
            ? fmt::format("{}={}", inputs[k],
                          encoding_.inputs()[k].levels[static_cast<std::size_t>(p - first)])
            : inputs[k]);
  }
  return names;
}

}  // namespace repose::surrogate

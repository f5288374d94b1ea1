// From inputs in natural units to the coordinates in which distances are measured.
#pragma once

#include <string>
#include <vector>

#include "repose/surrogate/input.hpp"
#include "repose/surrogate/kernel.hpp"

namespace repose::surrogate {

/// d inputs become p coordinates: a number one, u = (x - lower)/(upper - lower) or the same of its
/// logarithm; a category with L levels u = index/(L-1) (label) or L indicators, of 1 (one-hot) or
/// 1/sqrt2 (exchangeable, so that two levels are 1 apart). Each coordinate has a length scale,
/// which it may share.
class Encoding {
 public:
  Encoding() = default;
  /// Throws InputError on an empty range, a range on a log scale that is not positive, one level.
  Encoding(std::vector<Input> inputs, LengthScales length_scales);

  /// m x p from m x d. Throws InputError naming row and input on a value that is not finite, not
  /// positive on a log scale, or no level.
  Matrix encode(const Matrix& natural) const;

  const std::vector<Input>& inputs() const { return inputs_; }
  Eigen::Index dimension() const { return static_cast<Eigen::Index>(inputs_.size()); }
  Eigen::Index coordinates() const { return static_cast<Eigen::Index>(input_.size()); }
  Eigen::Index scales() const { return static_cast<Eigen::Index>(scale_names_.size()); }
  Eigen::Index input_of(Eigen::Index coordinate) const { return at(input_, coordinate); }
  Eigen::Index scale_of(Eigen::Index coordinate) const { return at(scale_, coordinate); }
  LengthScales length_scales() const { return length_scales_; }
  /// 1/l^2 for each coordinate, from the length scales in units of the coordinates.
  Vector weights(const Vector& length_scales) const;
  const std::vector<std::string>& scale_names() const { return scale_names_; }
  /// Natural unit of each length scale.
  const Vector& scale_units() const { return scale_units_; }
  /// du/dx of a number at x; 0 for a category.
  double derivative(Eigen::Index input, double natural) const;
  /// Whether a number lies outside of its range.
  bool outside(Eigen::Index input, double natural) const;

 private:
  static Eigen::Index at(const std::vector<Eigen::Index>& v, Eigen::Index i) {
    return v[static_cast<std::size_t>(i)];
  }
  void add(Eigen::Index input, const std::string& scale_name, double unit);

  std::vector<Input> inputs_;
  LengthScales length_scales_ = LengthScales::one_per_input;
  std::vector<Eigen::Index> input_;  // of each coordinate
  std::vector<Eigen::Index> scale_;
  std::vector<std::string> scale_names_;
  Vector scale_units_;
};

}  // namespace repose::surrogate

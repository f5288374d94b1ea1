// What a model has to know about an input besides its values: range, scale, categories.
#pragma once

#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"
#include "repose/opt/objective.hpp"

namespace repose::surrogate {

/// How two levels of a category differ.
enum class Coding {
  label,        ///< as their numbers do: levels are equidistant points of a line, in order
  one_hot,      ///< by a length scale for each of the two: levels may be more or less alike
  exchangeable  ///< all pairs alike, by one length scale
};
const char* to_string(Coding coding);

/// A column of x. Numbers are scaled by their declared range, not by the data, so that a model does
/// not depend on which part of the range was sampled; they may lie outside of it.
struct Input {
  double lower = 0.0;
  double upper = 1.0;           ///< > lower
  Scale scale = Scale::linear;  ///< log: distances are ratios; lower > 0
  /// At least two for a categorical input, whose column holds 0, 1, ... in their order and whose
  /// range and scale are ignored; empty for a number.
  std::vector<std::string> levels = {};
  Coding coding = Coding::exchangeable;

  bool is_categorical() const { return !levels.empty(); }
};

/// Throw InputError naming input and row. An input: an empty range, one that is not positive on a
/// log scale, a single level. Points (m x d, natural units): another number of columns, a value
/// that is not finite, not positive on a log scale, or no level.
void check_inputs(const std::vector<Input>& inputs);
void check_points(const std::vector<Input>& inputs, const Matrix& x);

/// Numbers on linear scales.
std::vector<Input> linear_inputs(const opt::Bounds& declared);

}  // namespace repose::surrogate

#include "repose/surrogate/input.hpp"

#include <fmt/format.h>

#include <cmath>

#include "repose/base/error.hpp"

namespace repose::surrogate {
namespace {

void check_input(const Input& input, std::size_t number) {
  if (input.is_categorical()) {
    if (input.levels.size() < 2)
      throw InputError(fmt::format(
          "input {} has the single level '{}'; nothing can be learnt from it: leave it out", number,
          input.levels[0]));
    return;
  }
  if (!std::isfinite(input.lower) || !std::isfinite(input.upper) || !(input.lower < input.upper))
    throw InputError(fmt::format("the declared range of input {} is [{}, {}]; it must not be empty",
                                 number, input.lower, input.upper));
  if (input.scale == Scale::log && !(input.lower > 0.0))
    throw InputError(fmt::format("input {} has a log scale from {}; its range must be positive",
                                 number, input.lower));
}

/// Throws where the value of a row is none that the input can have.
void check_value(const Input& input, double x, Eigen::Index row, Eigen::Index column) {
  if (!std::isfinite(x))
    throw InputError(
        fmt::format("row {}, input {} is {}; it must be finite: drop or repair the row", row + 1,
                    column + 1, x));
  if (input.is_categorical()) {
    const auto levels = static_cast<double>(input.levels.size());
    if (x < 0.0 || x >= levels || x != std::floor(x))
      throw InputError(fmt::format("row {}, input {} is {}; its levels are 0 to {}", row + 1,
                                   column + 1, x, levels - 1.0));
  } else if (input.scale == Scale::log && !(x > 0.0)) {
    throw InputError(fmt::format("row {}, input {} is {}; on a log scale it must be positive",
                                 row + 1, column + 1, x));
  }
}

}  // namespace

void check_inputs(const std::vector<Input>& inputs) {
  for (std::size_t k = 0; k < inputs.size(); ++k) check_input(inputs[k], k + 1);
}

void check_points(const std::vector<Input>& inputs, const Matrix& x) {
  if (x.cols() != static_cast<Eigen::Index>(inputs.size()))
    throw InputError(fmt::format("points have {} columns for {} inputs", x.cols(), inputs.size()));
  for (Eigen::Index k = 0; k < x.cols(); ++k)
    for (Eigen::Index i = 0; i < x.rows(); ++i)
      check_value(inputs[static_cast<std::size_t>(k)], x(i, k), i, k);
}

std::vector<Input> linear_inputs(const opt::Bounds& declared) {
  opt::check_bounds(declared);
  std::vector<Input> inputs;
  for (Eigen::Index k = 0; k < declared.lower.size(); ++k)
    inputs.push_back({.lower = declared.lower[k], .upper = declared.upper[k]});
  return inputs;
}

}  // namespace repose::surrogate

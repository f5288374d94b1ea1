// A normal distribution, the currency between surrogates and acquisition functions.
#pragma once

#include <cmath>

namespace repose {

struct Gaussian {
  double mean = 0.0;
  double variance = 0.0;  ///< >= 0
  double standard_deviation() const { return std::sqrt(variance); }
};

}  // namespace repose

// Correlation functions of a Gaussian process: five shapes, each with one length scale for all
// inputs or one for each.
#pragma once

#include <string_view>
#include <vector>

namespace repose::surrogate {

/// R as a function of r, r^2 = sum_k (dx_k/l_k)^2: radial, not a product of 1-d functions
/// [Rasmussen2006, section 4.2].
enum class Correlation {
  exponential,          ///< exp(-r): continuous, nowhere smooth
  matern32,             ///< (1 + sqrt3 r) exp(-sqrt3 r): once differentiable
  matern52,             ///< (1 + sqrt5 r + 5 r^2/3) exp(-sqrt5 r): twice differentiable
  squared_exponential,  ///< exp(-r^2/2): analytic
  rational_quadratic    ///< (1 + r^2/(2 alpha))^-alpha: a mixture of the above over scales
};

enum class LengthScales {
  shared,        ///< one, in units of the declared ranges
  one_per_input  ///< "ard": automatic relevance determination
};

struct Kernel {
  Correlation correlation = Correlation::matern52;
  LengthScales length_scales = LengthScales::one_per_input;
  bool operator==(const Kernel&) const = default;
};

/// "matern52", with one length scale for each input "ard-matern52".
const char* to_string(Kernel kernel);
/// Throws InputError listing the names.
Kernel kernel_named(std::string_view name);
/// All ten: shared scales first, each in order of the enumeration.
const std::vector<Kernel>& all_kernels();

}  // namespace repose::surrogate

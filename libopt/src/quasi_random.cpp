#include <boost/math/special_functions/erf.hpp>
#include <numbers>

#include "repose/doe/space_filling.hpp"
#include "repose/opt/composite.hpp"

namespace repose::opt {

Matrix scrambled_uniforms(Eigen::Index draws, Eigen::Index dimension, std::uint64_t seed) {
  return doe::sobol_points(
      draws, dimension, {.scrambling = doe::SobolOptions::Scrambling::digital_shift, .seed = seed});
}

Matrix scrambled_normals(Eigen::Index draws, Eigen::Index dimension, std::uint64_t seed) {
  Matrix points = scrambled_uniforms(draws, dimension, seed);
  for (double& u : points.reshaped()) u = -std::numbers::sqrt2 * boost::math::erfc_inv(2.0 * u);
  return points;
}

}  // namespace repose::opt

#include <fmt/format.h>

#include <boost/math/special_functions/erf.hpp>
#include <boost/random/sobol.hpp>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/opt/composite.hpp"

namespace repose::opt {

Matrix scrambled_uniforms(Eigen::Index draws, Eigen::Index dimension, std::uint64_t seed) {
  if (draws < 0 || dimension < 1 || dimension > 3667)  // the largest of Boost's direction numbers
    throw InputError(fmt::format(
        "{} quasi-random points in {} dimensions; there may be any number in 1 to 3667 dimensions",
        draws, dimension));
  RandomStream random(seed);
  std::vector<std::uint64_t> shift(static_cast<std::size_t>(dimension));
  for (std::uint64_t& s : shift) s = random.next_u64();
  boost::random::sobol sequence(static_cast<std::size_t>(dimension));
  Matrix points(draws, dimension);
  for (Eigen::Index i = 0; i < draws; ++i)
    for (Eigen::Index k = 0; k < dimension; ++k) {
      const std::uint64_t sobol = i == 0 ? 0 : sequence();  // Boost leaves out the origin
      const std::uint64_t bits = sobol ^ shift[static_cast<std::size_t>(k)];
      points(i, k) = (static_cast<double>(bits >> 12) + 0.5) * 0x1p-52;
    }
  return points;
}

Matrix scrambled_normals(Eigen::Index draws, Eigen::Index dimension, std::uint64_t seed) {
  Matrix points = scrambled_uniforms(draws, dimension, seed);
  for (double& u : points.reshaped()) u = -std::numbers::sqrt2 * boost::math::erfc_inv(2.0 * u);
  return points;
}

}  // namespace repose::opt

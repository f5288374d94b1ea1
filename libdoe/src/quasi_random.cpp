// Sobol' and Halton sequences and their scrambling.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/random/sobol.hpp>
#include <numeric>
#include <utility>

#include "point_filter.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/doe/space_filling.hpp"

namespace repose::doe {
namespace {

constexpr Eigen::Index kMostSobol = 3667;  // dimensions of Boost's direction numbers
constexpr Eigen::Index kMostHalton = 1000;

void check_size(const char* sequence, Eigen::Index points, Eigen::Index dimensions,
                Eigen::Index most) {
  if (points < 0 || dimensions < 1 || dimensions > most)
    throw InputError(fmt::format(
        "{} sequence: {} points in {} dimensions; there may be any number in 1 to {} dimensions",
        sequence, points, dimensions, most));
}

/// The middle of the cell of size 2^-52 that the leading binary digits name.
double inside(std::uint64_t bits) {
  return (static_cast<double>(bits >> 12) + 0.5) * 0x1p-52;
}

/// Nested uniform scrambling [Owen1995] of 64 binary digits: whether a digit is flipped is a random
/// bit of the digits before it. No two points share more than 32 leading digits, unless they share
/// them all: what follows is random.
std::uint64_t owen_scrambled(std::uint64_t bits, std::uint32_t dimension, std::uint64_t seed) {
  const std::array<std::uint32_t, 2> key{static_cast<std::uint32_t>(seed),
                                         static_cast<std::uint32_t>(seed >> 32)};
  std::uint64_t scrambled = 0;
  for (std::uint32_t digit = 0; digit < 32; ++digit) {
    const auto before = static_cast<std::uint32_t>(digit == 0 ? 0 : bits >> (64 - digit));
    const std::uint64_t flip = philox4x32({before, digit, dimension, 0x0e51U}, key)[0] & 1U;
    scrambled |= (((bits >> (63 - digit)) & 1U) ^ flip) << (63 - digit);
  }
  const auto rest =
      philox4x32({static_cast<std::uint32_t>(bits >> 32), 32U, dimension, 0x0e51U}, key)[0];
  return scrambled | rest;
}

class Sobol {
 public:
  Sobol(Eigen::Index dimensions, const SobolOptions& options)
      : options_(options),
        sequence_(static_cast<std::size_t>(dimensions)),
        shift_(static_cast<std::size_t>(dimensions)) {
    RandomStream random(options.seed);
    for (std::uint64_t& s : shift_) s = random.next_u64();
  }
  Vector next() {
    Vector point(static_cast<Eigen::Index>(shift_.size()));
    for (Eigen::Index k = 0; k < point.size(); ++k)
      point[k] = coordinate(first_ ? 0 : sequence_(), k);  // Boost leaves out the origin
    first_ = false;
    return point;
  }

 private:
  double coordinate(std::uint64_t bits, Eigen::Index k) const {
    switch (options_.scrambling) {
      case SobolOptions::Scrambling::none:
        return static_cast<double>(bits >> 12) * 0x1p-52;
      case SobolOptions::Scrambling::digital_shift:
        return inside(bits ^ shift_[static_cast<std::size_t>(k)]);
      case SobolOptions::Scrambling::owen:
        return inside(owen_scrambled(bits, static_cast<std::uint32_t>(k), options_.seed));
    }
    return 0.0;
  }

  SobolOptions options_;
  boost::random::sobol sequence_;
  std::vector<std::uint64_t> shift_;
  bool first_ = true;
};

std::vector<int> first_primes(Eigen::Index count) {
  std::vector<int> primes;
  for (int n = 2; static_cast<Eigen::Index>(primes.size()) < count; ++n)
    if (std::none_of(primes.begin(), primes.end(), [n](int p) { return p * p <= n && n % p == 0; }))
      primes.push_back(n);
  return primes;
}

/// One column of Halton's sequence: a base and a permutation for each digit that a double holds.
class RadicalInverse {
 public:
  RadicalInverse(int base, const HaltonOptions& options, std::uint64_t column) : base_(base) {
    RandomStream random(options.seed, column);
    for (double weight = 1.0; weight > 0x1p-52; weight /= base) {
      std::vector<int> digits(static_cast<std::size_t>(base));
      std::iota(digits.begin(), digits.end(), 0);
      if (options.scrambling == HaltonOptions::Scrambling::permuted) random.shuffle(digits);
      permutations_.push_back(std::move(digits));
    }
  }
  double of(std::uint64_t index) const {
    double value = 0.0, weight = 1.0;
    const auto base = static_cast<std::uint64_t>(base_);
    for (const auto& permutation : permutations_) {
      weight /= base_;
      value += weight * permutation[static_cast<std::size_t>(index % base)];
      index /= base;
    }
    return std::min(value, 1.0 - 0x1p-53);
  }

 private:
  int base_;
  std::vector<std::vector<int>> permutations_;
};

}  // namespace

Matrix sobol_points(Eigen::Index points, Eigen::Index dimensions, const SobolOptions& options) {
  check_size("Sobol'", points, dimensions, kMostSobol);
  Sobol sequence(dimensions, options);
  return first_allowed(points, dimensions, options.allowed, [&] { return sequence.next(); });
}

Matrix halton_points(Eigen::Index points, Eigen::Index dimensions, const HaltonOptions& options) {
  check_size("Halton", points, dimensions, kMostHalton);
  std::vector<RadicalInverse> columns;
  for (const int base : first_primes(dimensions))
    columns.emplace_back(base, options, columns.size());
  std::uint64_t index = options.scrambling == HaltonOptions::Scrambling::none ? 1 : 0;
  return first_allowed(points, dimensions, options.allowed, [&] {
    Vector point(dimensions);
    for (Eigen::Index k = 0; k < dimensions; ++k)
      point[k] = columns[static_cast<std::size_t>(k)].of(index);
    ++index;
    return point;
  });
}

}  // namespace repose::doe

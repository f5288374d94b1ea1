// Counter-based random numbers: the same (seed, stream, position) gives the same bits everywhere.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace repose {

/// Philox4x32-10 of [Salmon2011]: ten rounds, four 32-bit words of output a block.
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key);

/// A stream of random numbers, numbered by (seed, stream); streams are independent of each other
/// and of the order in which they are used. Nothing but IEEE arithmetic and libm is used, so a
/// build gives the same numbers in every run.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed, std::uint64_t stream = 0);

  std::uint64_t next_u64();
  /// Uniform in [0, 1), 53 bits.
  double uniform();
  double uniform(double lower, double upper) { return lower + (upper - lower) * uniform(); }
  /// Standard normal, by the method of Box and Muller.
  double normal();
  /// Uniform in {0, ..., n-1} without bias; n >= 1.
  std::uint64_t below(std::uint64_t n);

  /// Fisher–Yates.
  template <class T>
  void shuffle(std::vector<T>& values) {
    for (std::size_t i = values.size(); i > 1; --i)
      std::swap(values[i - 1], values[static_cast<std::size_t>(below(i))]);
  }

 private:
  std::array<std::uint32_t, 2> key_;
  std::uint64_t stream_;
  std::uint64_t block_ = 0;
  std::array<std::uint32_t, 4> words_{};
  int used_ = 4;
  bool has_spare_ = false;
  double spare_ = 0.0;
};

/// A seed derived from another and a number, for runs and repetitions: well mixed, never negative
/// as a 63-bit integer, so that it survives TOML and HDF5.
std::uint64_t derive_seed(std::uint64_t seed, std::uint64_t number);

}  // namespace repose

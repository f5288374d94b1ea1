// Sums that do not depend on the order of what is added.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>

#include "repose/dem/contact_energies.hpp"
#include "repose/dem/contact_law.hpp"

namespace repose::dem {

/// An integer of 128 bits in units of 2^-80. What is added is cut to whole units, which depends on
/// itself alone; the rest is integer arithmetic. So sums over any parts, in any order and on any
/// number of processes, are the same bits. Resolution 8e-25, range 7e13; a sum
/// beyond it, a term of 1.1e12 or more, or one that is no number, makes the sum not a number.
class ExactSum {
 public:
  /// The two halves of the integer, to be stored or sent.
  struct Parts {
    std::int64_t high = 0;
    std::uint64_t low = 0;
  };

  ExactSum() = default;
  explicit ExactSum(const Parts& parts)
      : units_(static_cast<Int>(parts.high) * kHigh + static_cast<Int>(parts.low)) {}

  void add(double term) { add_units(units_of(term)); }
  void add(const ExactSum& other) { add_units(other.units_); }
  double value() const {
    if (units_ == kBroken) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(units_) / kUnitsOfOne;
  }
  Parts parts() const {
    return {static_cast<std::int64_t>(units_ >> 64), static_cast<std::uint64_t>(units_)};
  }

 private:
  __extension__ typedef __int128 Int;
  static constexpr double kUnitsOfOne = 0x1p80;
  static constexpr int kLargestExponent = 40;
  static constexpr Int kHigh = static_cast<Int>(1) << 64;
  static constexpr Int kMost = static_cast<Int>(1) << 126;
  static constexpr Int kBroken = -kMost * 2;

  /// A double is mantissa * 2^(exponent - 1075) with an exponent of 11 bits; below 2^-1022, and
  /// where all is shifted out, nothing is left.
  static Int units_of(double term) {
    const auto bits = std::bit_cast<std::uint64_t>(term);
    const int exponent = static_cast<int>(bits >> 52 & 0x7ff);
    if (exponent >= 1023 + kLargestExponent) return kBroken;
    const std::uint64_t mantissa = (bits & 0xfffffffffffff) | 0x10000000000000;
    const int shift = exponent - 1075 + 80;
    const Int size = shift >= 0    ? static_cast<Int>(mantissa) << shift
                     : shift > -64 ? static_cast<Int>(mantissa >> -shift)
                                   : 0;
    return bits >> 63 != 0 ? -size : size;
  }

  void add_units(Int units) {
    if (units == kBroken || units_ == kBroken) {
      units_ = kBroken;
      return;
    }
    units_ += units;
    if (units_ > kMost || units_ < -kMost) units_ = kBroken;
  }

  Int units_ = 0;
};

struct ExactVectorSum {
  ExactSum x, y, z;

  void add(const Vec3& v) {
    x.add(v.x());
    y.add(v.y());
    z.add(v.z());
  }
  void add(const ExactVectorSum& other) {
    x.add(other.x);
    y.add(other.y);
    z.add(other.z);
  }
  Vec3 value() const { return {x.value(), y.value(), z.value()}; }
};

/// Of the energies of contacts.
struct ExactEnergies {
  ExactSum normal_j, tangential_j, rolling_j;
  ExactSum normal_damping_w, tangential_damping_w, sliding_w, rolling_w, stiffness_change_w;

  void add(const ContactEnergies& one) {
    normal_j.add(one.normal_j);
    tangential_j.add(one.tangential_j);
    rolling_j.add(one.rolling_j);
    normal_damping_w.add(one.normal_damping_w);
    tangential_damping_w.add(one.tangential_damping_w);
    sliding_w.add(one.sliding_w);
    rolling_w.add(one.rolling_w);
    stiffness_change_w.add(one.stiffness_change_w);
  }
  ContactEnergies value() const {
    return {normal_j.value(),         tangential_j.value(),         rolling_j.value(),
            normal_damping_w.value(), tangential_damping_w.value(), sliding_w.value(),
            rolling_w.value(),        stiffness_change_w.value()};
  }
};

}  // namespace repose::dem

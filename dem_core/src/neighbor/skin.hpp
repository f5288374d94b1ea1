// How far beyond touching neighbor lists reach.
#pragma once

#include <cstdint>

namespace repose::dem {

/// Chooses the skin of the next lists from the pace at which the last ones wore out. A wide skin
/// costs the test of many pairs in each step, a narrow one many rebuilds: with pairs growing as
/// (D + s)^3 and a rebuild every s/(2u) steps, u the way of the fastest sphere in a step, the sum
/// is least where s (1 + s/D) = sqrt(2 q u D). q is the cost of a rebuild for one sphere over that
/// of testing its pairs of a narrow list three times, about 15 wherever measured.
class Skin {
 public:
  Skin(double smallest_radius, double fixed_in_radii)
      : diameter_(2.0 * smallest_radius),
        fixed_(fixed_in_radii > 0.0),
        width_((fixed_ ? fixed_in_radii : kFirst) * smallest_radius) {}

  double width() const { return width_; }
  /// Lists are built anew after `steps` in which the fastest sphere went as far as `moved`.
  void adapt(double moved, std::int64_t steps);

 private:
  static constexpr double kFirst = 0.1;  // smallest radii, before anything is known
  static constexpr double kNarrowest = 0.05;
  static constexpr double kWidest = 2.0;
  static constexpr double kRebuildCost = 15.0;

  double diameter_;
  bool fixed_;
  double width_;
};

}  // namespace repose::dem

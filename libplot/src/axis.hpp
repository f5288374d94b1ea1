// Axes: limits, ticks at round numbers, and the way from values to pixels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "repose/plot/figure.hpp"

namespace repose::plot {

/// The smallest and largest value that an axis has to show.
class Extent {
 public:
  /// Values that are not finite are ignored.
  void include(double value);
  bool is_empty() const { return lower_ > upper_; }
  double lower() const { return lower_; }
  double upper() const { return upper_; }

 private:
  double lower_ = 1.0;
  double upper_ = -1.0;
};

struct Tick {
  double value = 0.0;
  std::string text;         ///< "0.5"; "10" before a superscript
  std::string superscript;  ///< "-3" in 10^-3
};

struct AxisPlan {
  double lower = 0.0;
  double upper = 1.0;
  Scale scale = Scale::linear;
  std::vector<Tick> ticks;
  std::vector<double> minor_ticks;  ///< on log axes
  int exponent = 0;                 ///< ticks read in units of 10^exponent
};

/// How the limits that a user left open follow the data.
enum class Limits {
  round,  ///< the round numbers around the data
  exact,  ///< the data themselves
};

/// Limits and about `count` ticks for data on an axis. Defined for any extent: data that are all
/// equal lie in the middle, without data the axis goes from 0 to 1 (1 to 10 on a log scale).
AxisPlan plan_axis(const Axis& axis, Extent data, Limits limits, int count);

/// Category i of n spans i to i + 1.
AxisPlan plan_categories(const std::vector<std::string>& categories);

/// From values to pixels; `start` and `end` are where the limits of the plan lie.
class PixelMap {
 public:
  PixelMap(const AxisPlan& plan, double start, double end);
  double operator()(double value) const;
  /// Within the limits, half a pixel of rounding allowed; false for values that cannot be shown.
  bool shows(double value) const;

 private:
  double coordinate(double value) const;
  Scale scale_;
  double lower_;
  double upper_;
  double start_;
  double end_;
};

}  // namespace repose::plot

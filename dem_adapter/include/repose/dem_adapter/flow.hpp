// Mass flow of a discharge from the mass that is left, as of a load cell under the container.
#pragma once

#include <variant>
#include <vector>

namespace repose::dem_adapter {

/// Mass in a container over time; times increase.
struct MassCurve {
  std::vector<double> time_s;
  std::vector<double> mass_kg;
};

/// The curve and its slope after a Gaussian filter.
struct FilteredCurve {
  std::vector<double> mass_kg;
  std::vector<double> rate_kg_s;  ///< of what flows out: minus the slope
};

/// At each time the straight line through the points, weighted by a Gaussian of standard deviation
/// `deviation_s` cut off at four of them: its value and slope. Far from the ends of an evenly
/// spaced curve that is the Gaussian filter of [Hadi2026, section 5.2.3] and its derivative; at the
/// ends it is not bent towards the mean as that is, and a straight curve stays as it is. Where
/// fewer than two points have weight, the slope is 0. Time O(n w), w points in eight deviations.
FilteredCurve gaussian_filtered(const MassCurve& curve, double deviation_s);

/// Between two shares of what is finally discharged.
struct ShareWindow {
  double from = 0.15, to = 0.65;
};
/// Between two times on the curve, as in the thesis (0.5 and 2.0 s).
struct TimeWindow {
  double from_s = 0.0, to_s = 0.0;
};
/// Found: from the first to the last time at which the filtered rate is at least 1 - tolerance
/// times the median rate by mass, at which half of what flows out flows faster.
struct SteadyWindow {
  double tolerance = 0.2;
};

struct FlowOptions {
  double filter_s = 0.05;  ///< standard deviation of the Gaussian filter; 0: none
  std::variant<SteadyWindow, TimeWindow, ShareWindow> window = SteadyWindow{};
};

/// NaN where it is undefined: nothing flowed, fewer than two points lie in the window, or the curve
/// has fewer than three.
struct Flow {
  double rate_kg_s = 0.0;  ///< least-squares slope of the curve as it was given, in the window
  double from_s = 0.0;     ///< the window
  double to_s = 0.0;
  double discharged_kg = 0.0;  ///< first mass less last mass of the filtered curve
  double time_98_s = 0.0;      ///< when 98 % of it were out
  /// Root mean square deviation of the filtered rate in the window from rate_kg_s, relative.
  double unsteadiness = 0.0;
};

/// The curve is the discharge alone, from the opening of the outlet on. Throws InputError if its
/// vectors differ in length, times do not increase, or options make no sense.
Flow discharge_flow(const MassCurve& curve, const FlowOptions& options = {});

}  // namespace repose::dem_adapter

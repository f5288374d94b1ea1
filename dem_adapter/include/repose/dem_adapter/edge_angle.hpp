// Angles of the edge of a heap or of the slopes beside an outlet, by lines fitted to a profile
// [Hadi2026, section 5.2.3]. Particles and photographs are measured by this one code.
#pragma once

#include <limits>

#include "repose/dem_adapter/silhouette.hpp"

namespace repose::dem_adapter {

/// How a line is fitted to an edge.
enum class LineFit {
  /// through all columns, as the thesis does
  least_squares,
  /// Theil-Sen [Sen1968], then least squares without the columns that lie more than four robust
  /// standard deviations (1.4826 times the median distance) off, until none comes or goes; columns
  /// within half a column's width always count. Up to a quarter of outliers is survived.
  robust
};

struct FittedLine {
  double slope = 0.0;
  double intercept_m = 0.0;
  int points = 0;       ///< columns used; fewer than two leave slope and intercept NaN
  int outliers = 0;     ///< columns with an edge that were left out
  double from_m = 0.0;  ///< the columns lie in [from, to]
  double to_m = 0.0;
  double rms_m = 0.0;        ///< of the vertical distances of the columns used
  double angle_deg() const;  ///< of |slope|
};

/// The line through the columns with centres in [from, to] and edge in [lowest, highest]; empty
/// columns are skipped.
FittedLine fit_line(const Profile& profile, double from_m, double to_m,
                    LineFit fit = LineFit::least_squares,
                    double lowest_m = -std::numeric_limits<double>::infinity(),
                    double highest_m = std::numeric_limits<double>::infinity());

/// Both sides of a profile. Angles are negative where the edge slopes the wrong way, NaN where it
/// has fewer than two columns.
struct EdgeAngles {
  FittedLine left, right;
  double left_deg = 0.0, right_deg = 0.0;
  double mean_deg() const { return 0.5 * (left_deg + right_deg); }
};

struct HeapOptions {
  double axis_m = 0.0;   ///< divides the heap
  double floor_m = 0.0;  ///< that it stands on
  /// A half ends with the first empty column or the first one lower than this above the floor, so
  /// that single grains that rolled away are left out.
  double toe_m = 0.0;
  double reach_m = std::numeric_limits<double>::infinity();  ///< of the walls, from the axis
  /// The part of the edge used, as fractions of the heap's height. The thesis uses the whole
  /// profile, "because there is no clear rule for determining the extent of the flattened portion";
  /// others leave out toe and summit.
  double from = 0.0, to = 1.0;
  LineFit fit = LineFit::least_squares;
};

struct HeapAngles : EdgeAngles {
  double left_end_m = 0.0;  ///< distances of the ends from the axis, at most HeapOptions::reach_m
  double right_end_m = 0.0;
  double height_m = 0.0;  ///< of the highest column between the ends, above the floor
};

/// The angle of repose: a line through each half of the heap's edge, rising to the axis.
HeapAngles heap_angles(const Profile& profile, const HeapOptions& options);

/// Where the heap's axis is if nobody says: in the middle of its base, which reaches from the
/// highest column to both sides as in HeapOptions. NaN if the profile is empty.
double heap_axis_m(const Profile& profile, double floor_m, double toe_m);

/// The shear angle: a line through the edge on each side of an outlet, falling to it. Columns in
/// [lower, outlet_left] and [outlet_right, upper].
EdgeAngles slope_angles(const Profile& profile, double lower_m, double outlet_left_m,
                        double outlet_right_m, double upper_m,
                        LineFit fit = LineFit::least_squares);

}  // namespace repose::dem_adapter

// The angle of repose or the shear angle of a view, with a picture to check it by.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "repose/dem_adapter/edge_angle.hpp"
#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/view.hpp"

namespace repose::dem_adapter {

/// What the edge of a view is: a heap, the two slopes beside an outlet, or one slope from side to
/// side of the view, as the surface of what flows in a drum.
enum class EdgeShape { heap, slopes, surface };

/// Lengths in m, or pixels where the view has no scale; places as x and z of the view.
struct EdgeOptions {
  EdgeShape shape = EdgeShape::heap;
  std::optional<double> axis_m{};  ///< heap; default heap_axis_m()
  /// Default: the lowest pixel that is not background. For slopes it is drawn only.
  std::optional<double> floor_m{};
  /// Heap: HeapOptions::toe_m; default: the largest grain, or a fiftieth of the height if unknown.
  std::optional<double> toe_m{};
  /// Slopes: left and right end of the outlet between them; needed.
  std::optional<std::pair<double, double>> outlet_m{};
  double from = 0.0, to = 1.0;  ///< as in HeapOptions; heap only
  LineFit fit = LineFit::robust;
};

struct ViewAngle {
  /// `angle_of_repose_deg`, `shear_angle_deg` or `surface_angle_deg`; details are the angle of each
  /// side, its columns left out as outliers and the root mean square distance from its line, and
  /// for heaps height and half base (the mean of both sides).
  Measurement measurement;
  EdgeAngles angles;  ///< of a surface both sides are the one line
  double floor_m = 0.0;
};

/// Throws InputError if an option lies outside the view (a floor: farther below than it is high) or
/// is not one of the shape, if the outlet's ends are not in order, or if a side has fewer than ten
/// columns.
ViewAngle measure_angle(const View& view, const EdgeOptions& options = {});

/// An SVG picture: the view with the edge found, the lines fitted and their angles. It shows
/// nothing that was not used, so that a wrong crop, threshold or floor meets the eye.
std::string audit_svg(const View& view, const ViewAngle& angle, const std::string& title);

}  // namespace repose::dem_adapter

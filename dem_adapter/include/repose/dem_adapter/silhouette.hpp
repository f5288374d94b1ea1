// The upper edge of what a camera in front of a heap sees, from particles; a photograph gives the
// same (view.hpp).
#pragma once

#include <span>
#include <vector>

namespace repose::dem_adapter {

/// A particle in front view, m.
struct Disc {
  double x_m = 0.0;
  double z_m = 0.0;
  double radius_m = 0.0;
};

/// The upper edge of a silhouette in columns of equal width; NaN where a column is empty.
struct Profile {
  double first_x_m = 0.0;  ///< centre of the first column
  double column_m = 0.0;
  std::vector<double> top_m;
  double x_m(std::size_t column) const {
    return first_x_m + column_m * static_cast<double>(column);
  }
};

/// Upper edge of the union of discs between lower and upper, sampled at column centres: what
/// binarising a picture and extracting its edge gives [Hadi2026, section 5.2.3].
Profile silhouette(std::span<const Disc> discs, double lower_m, double upper_m, double column_m);

}  // namespace repose::dem_adapter

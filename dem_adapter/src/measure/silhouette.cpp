#include "repose/dem_adapter/silhouette.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {

Profile silhouette(std::span<const Disc> discs, double lower_m, double upper_m, double column_m) {
  REPOSE_ASSERT(upper_m > lower_m && column_m > 0.0,
                fmt::format("{} {} {}", lower_m, upper_m, column_m));
  Profile profile;
  profile.column_m = column_m;
  profile.first_x_m = lower_m + 0.5 * column_m;
  const auto columns = static_cast<std::size_t>(std::floor((upper_m - lower_m) / column_m + 1e-9));
  profile.top_m.assign(std::max<std::size_t>(columns, 1), std::numeric_limits<double>::quiet_NaN());
  const auto last = static_cast<double>(profile.top_m.size() - 1);
  for (const Disc& disc : discs) {
    const double from = std::ceil((disc.x_m - disc.radius_m - profile.first_x_m) / column_m);
    const double to = std::floor((disc.x_m + disc.radius_m - profile.first_x_m) / column_m);
    if (to < 0.0 || from > last) continue;
    for (auto c = static_cast<std::size_t>(std::max(from, 0.0));
         c <= static_cast<std::size_t>(std::min(to, last)); ++c) {
      const double offset = profile.x_m(c) - disc.x_m;
      const double rise = disc.radius_m * disc.radius_m - offset * offset;
      if (rise < 0.0) continue;
      const double top = disc.z_m + std::sqrt(rise);
      if (!(profile.top_m[c] >= top)) profile.top_m[c] = top;
    }
  }
  return profile;
}

}  // namespace repose::dem_adapter

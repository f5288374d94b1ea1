#include "repose/dem_adapter/silhouette.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "repose/base/error.hpp"

namespace repose::dem_adapter {

double FittedLine::angle_deg() const {
  return std::atan(std::abs(slope)) * 180.0 / std::numbers::pi;
}

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

FittedLine fit_line(const Profile& profile, double from_m, double to_m) {
  double n = 0.0, mean_x = 0.0, mean_z = 0.0;
  const auto for_each_point = [&](auto&& use) {
    for (std::size_t c = 0; c < profile.top_m.size(); ++c) {
      const double x = profile.x_m(c);
      if (x >= from_m && x <= to_m && !std::isnan(profile.top_m[c])) use(x, profile.top_m[c]);
    }
  };
  for_each_point([&](double x, double z) {
    n += 1.0;
    mean_x += x;
    mean_z += z;
  });
  FittedLine line;
  line.points = static_cast<int>(n);
  if (n < 2.0) {
    line.slope = line.intercept_m = std::numeric_limits<double>::quiet_NaN();
    return line;
  }
  mean_x /= n;
  mean_z /= n;
  double sxx = 0.0, sxz = 0.0;
  for_each_point([&](double x, double z) {
    sxx += (x - mean_x) * (x - mean_x);
    sxz += (x - mean_x) * (z - mean_z);
  });
  line.slope = sxz / sxx;
  line.intercept_m = mean_z - line.slope * mean_x;
  return line;
}

}  // namespace repose::dem_adapter

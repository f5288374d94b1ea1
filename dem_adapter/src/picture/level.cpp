// A photograph from a camera that was not level, put right.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/dem_adapter/picture.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kLeastColumns = 16.0;  // a pixel of error is then 3.6 degrees already
constexpr double kMostTilt_deg = 20.0;

/// The colour at a place, linear between the centres of the four pixels around it.
Rgb color_at(const Picture& picture, double x, double y) {
  const double column = std::clamp(x - 0.5, 0.0, picture.width - 1.0);
  const double row = std::clamp(y - 0.5, 0.0, picture.height - 1.0);
  const int left = static_cast<int>(column), top = static_cast<int>(row);
  const int right = std::min(left + 1, picture.width - 1);
  const int bottom = std::min(top + 1, picture.height - 1);
  const double u = column - left, v = row - top;
  Rgb color{};
  for (std::size_t c = 0; c < 3; ++c)
    color[c] = static_cast<std::uint8_t>(std::lround(
        (1.0 - v) * ((1.0 - u) * picture.at(left, top)[c] + u * picture.at(right, top)[c]) +
        v * ((1.0 - u) * picture.at(left, bottom)[c] + u * picture.at(right, bottom)[c])));
  return color;
}

}  // namespace

double tilt_deg(const PixelPoint& first, const PixelPoint& second) {
  const double across = second.column - first.column, down = second.row - first.row;
  if (!(std::abs(across) >= kLeastColumns))
    throw InputError(
        fmt::format("the two points that should be level are {:.4g} columns apart; give some at "
                    "least {} apart, "
                    "far left and far right",
                    std::abs(across), kLeastColumns));
  const double tilt = std::atan(down / across) * 180.0 / std::numbers::pi;
  if (!(std::abs(tilt) <= kMostTilt_deg))
    throw InputError(fmt::format(
        "the two points that should be level lie on a line of {:.4g} degrees; at most {} "
        "are a tilted camera",
        tilt, kMostTilt_deg));
  return tilt;
}

Picture leveled(const Picture& picture, double tilt_deg) {
  const double c = std::cos(tilt_deg * std::numbers::pi / 180.0);
  const double s = std::sin(tilt_deg * std::numbers::pi / 180.0);
  const double middle_x = 0.5 * picture.width, middle_y = 0.5 * picture.height;
  Picture level(picture.width, picture.height);
  for (int row = 0; row < level.height; ++row)
    for (int column = 0; column < level.width; ++column) {
      const double x = column + 0.5 - middle_x, y = row + 0.5 - middle_y;
      level.at(column, row) = color_at(picture, middle_x + c * x - s * y, middle_y + s * x + c * y);
    }
  return level;
}

}  // namespace repose::dem_adapter

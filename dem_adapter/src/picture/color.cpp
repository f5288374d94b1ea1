#include <array>
#include <cmath>

#include "repose/dem_adapter/picture.hpp"

namespace repose::dem_adapter {
namespace {

/// Linear light of an sRGB value [IEC61966-2-1].
double linear(std::uint8_t value) {
  static const auto kTable = [] {
    std::array<double, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double v = static_cast<double>(i) / 255.0;
      table[i] = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    }
    return table;
  }();
  return kTable[value];
}

/// The cube root with a straight foot that CIELAB is made of.
double lab_root(double t) {
  constexpr double kDelta = 6.0 / 29.0;
  return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
}

}  // namespace

Lab lab_of(Rgb color) {
  const double r = linear(color[0]), g = linear(color[1]), b = linear(color[2]);
  // sRGB primaries; each row is divided by its sum, the white of D65, so that white is (100, 0, 0).
  const double x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
  const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  const double z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.0890;
  const double fx = lab_root(x), fy = lab_root(y), fz = lab_root(z);
  return {.l = 116.0 * fy - 16.0, .a = 500.0 * (fx - fy), .b = 200.0 * (fy - fz)};
}

double color_difference(const Lab& first, const Lab& second) {
  return std::sqrt((first.l - second.l) * (first.l - second.l) +
                   (first.a - second.a) * (first.a - second.a) +
                   (first.b - second.b) * (first.b - second.b));
}

}  // namespace repose::dem_adapter

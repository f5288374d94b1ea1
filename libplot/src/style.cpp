#include "style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace repose::plot {
namespace {

constexpr std::array<const char*, kPaletteSize> kPalette = {
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555", "#8c4a00"};
constexpr std::array<const char*, 3> kBands = {"#bdbdbd", "#f3cf80", "#a9d8f2"};

constexpr std::array<Color, 9> kViridis = {{{68, 1, 84},
                                            {71, 45, 123},
                                            {59, 82, 139},
                                            {44, 114, 142},
                                            {33, 145, 140},
                                            {40, 174, 128},
                                            {94, 201, 98},
                                            {173, 220, 48},
                                            {253, 231, 37}}};
constexpr std::array<Color, 3> kDiverging = {{{0, 114, 178}, {247, 247, 247}, {213, 94, 0}}};

template <std::size_t N>
Color interpolate(const std::array<Color, N>& colors, double position) {
  const double scaled = std::clamp(position, 0.0, 1.0) * static_cast<double>(N - 1);
  const auto low = std::min(static_cast<std::size_t>(scaled), N - 2);
  const double weight = scaled - static_cast<double>(low);
  const auto mix = [&](int a, int b) {
    return static_cast<int>(std::lround((1.0 - weight) * a + weight * b));
  };
  const Color& a = colors[low];
  const Color& b = colors[low + 1];
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

double linear_light(int channel) {
  const double c = channel / 255.0;
  return c <= 0.03928 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

}  // namespace

const char* series_color(std::size_t i) {
  return kPalette[i % kPaletteSize];
}
const char* band_color(std::size_t i) {
  return kBands[i % kBands.size()];
}

std::string Color::text() const {
  return fmt::format("#{:02x}{:02x}{:02x}", red, green, blue);
}

bool Color::is_light() const {
  const double luminance =
      0.2126 * linear_light(red) + 0.7152 * linear_light(green) + 0.0722 * linear_light(blue);
  return luminance > 0.179;  // where black and white have the same contrast
}

Color map_color(ColorScale scale, double position) {
  return scale == ColorScale::diverging ? interpolate(kDiverging, position)
                                        : interpolate(kViridis, position);
}

}  // namespace repose::plot

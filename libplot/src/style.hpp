// How figures look: colours, sizes, the same in every figure.
#pragma once

#include <cstddef>
#include <string>

#include "repose/plot/figure.hpp"

namespace repose::plot {

inline constexpr double kTitleSize = 14.0;
inline constexpr double kLabelSize = 12.5;
inline constexpr double kTickSize = 11.5;
inline constexpr double kLegendSize = 11.5;
inline constexpr double kCellTextSize = 10.5;

inline constexpr const char* kInk = "#222222";
inline constexpr const char* kGrid = "#e4e4e4";
inline constexpr const char* kReferenceInk = "#444444";
inline constexpr const char* kNoValue = "#e9e9e9";

inline constexpr std::size_t kPaletteSize = 8;

/// Colour of series i, for all kinds of colour vision [Okabe & Ito 2008], the yellow replaced by
/// grey: it cannot be seen on white.
const char* series_color(std::size_t i);
/// Shade of the i-th labelled band.
const char* band_color(std::size_t i);

struct Color {
  int red;
  int green;
  int blue;
  std::string text() const;  ///< "#0072b2"
  /// Whether black on it reads better than white [WCAG 2.1, relative luminance].
  bool is_light() const;
};

/// `position` in [0, 1]. Sequential is viridis [Smith & van der Walt 2015, CC0], diverging blue -
/// white - vermilion.
Color map_color(ColorScale scale, double position);

}  // namespace repose::plot

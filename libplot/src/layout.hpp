// Where everything stands: limits from the data, margins from the text.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "axis.hpp"
#include "content.hpp"
#include "svg.hpp"

namespace repose::plot {

inline constexpr double kMargin = 12.0;
inline constexpr double kTickLength = 5.0;
inline constexpr double kTickGap = 4.0;
inline constexpr double kWideSwatch = 22.0;    ///< of a line in the legend
inline constexpr double kNarrowSwatch = 12.0;  ///< of a marker or a bar
inline constexpr double kSlant_deg = -35.0;    ///< of category names that do not fit side by side

struct LegendPlace {
  Point at;       ///< left end of the glyph, baseline of the text
  double swatch;  ///< width of the glyph
  std::string label;
  const LegendEntry* entry;
};

struct Layout {
  Rectangle plot;
  AxisPlan x, y;
  std::string x_title, y_title;
  bool x_labels_slanted = false;
  double title_baseline = 0.0;
  double x_title_baseline = 0.0;
  double y_title_baseline = 0.0;  ///< an x coordinate: the title is turned
  std::vector<LegendPlace> legend;

  struct ColorBar {
    AxisPlan plan;
    Rectangle area;
  };
  std::optional<ColorBar> color_bar;

  PixelMap x_map() const { return {x, plot.left, plot.right()}; }
  /// Upwards for numbers, downwards for categories.
  PixelMap y_map() const;
  bool y_is_categories = false;
};

/// The layout refers to `content`.
Layout lay_out(const FigureContent& content);

}  // namespace repose::plot

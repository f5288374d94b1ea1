// What a figure shows, as its user said it.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "repose/plot/figure.hpp"

namespace repose::plot {

enum class Direction { horizontal, vertical };

struct Points {
  std::vector<double> x, y;
  std::vector<double> error_x, error_y;  ///< empty or as long as x
  std::size_t series;                    ///< chooses colour and marker
};

struct Curve {
  std::vector<double> x, y;
  LineStyle style;
  std::size_t series;
};

struct Ribbon {
  std::vector<double> x, lower, upper;
  std::size_t series;
};

struct Bars {
  std::vector<double> values;
  std::vector<double> errors;  ///< empty or as long as values
  std::size_t series;
};

struct Boxes {
  std::vector<std::vector<double>> samples;
  std::size_t series;
};

struct HeatMap {
  std::vector<double> x_edges, y_edges;  ///< of categories: 0, 1, ...
  Matrix values;
  Axis color;
  ColorScale colors;
  CellText text;
};

/// A horizontal band lies between two values of y.
struct Band {
  Direction direction;
  double lower, upper;
  const char* color;
};

/// A straight line through the whole plot; `value` belongs to no direction for the diagonal.
struct Rule {
  Direction direction;
  double value;
};

enum class Glyph { marker, line, ribbon, bar, box, band, rule, diagonal };

struct LegendGlyph {
  Glyph glyph;
  std::string color;
  std::size_t series = 0;
  LineStyle style = LineStyle::solid;
};

struct LegendEntry {
  std::string label;
  std::vector<LegendGlyph> glyphs;
};

struct FigureContent {
  std::string title;
  Axis x, y;
  Size size;
  std::vector<std::string> x_categories, y_categories;  ///< empty for an axis of numbers

  std::vector<Points> points;
  std::vector<Curve> curves;
  std::vector<Ribbon> ribbons;
  std::vector<Bars> bars;
  std::vector<Boxes> boxes;
  std::optional<HeatMap> heat_map;
  std::vector<Band> bands;
  std::vector<Rule> rules;
  bool has_diagonal = false;
  std::vector<std::string> notes;

  std::vector<LegendEntry> legend;
  std::vector<std::string> series_labels;  ///< the label of each series, maybe empty
};

/// Of sorted values, p in [0, 1], linear between order statistics ([Hyndman & Fan 1996], type 7).
double quantile(const std::vector<double>& sorted, double p);

}  // namespace repose::plot

// Figures as self-contained SVG text: no scripts, no external fonts, the same text for the same
// input.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "repose/base/parameter_space.hpp"

namespace repose::plot {

/// One axis. Limits that are not given are chosen so that round numbers enclose the data; data
/// outside given limits are not shown. The label reads "Mass flow (kg/s)"; unit "1" or "" is not
/// shown, "deg" is shown as °, "m3" as m³.
struct Axis {
  std::string label = {};
  std::string unit = "1";
  std::optional<double> lower = std::nullopt;
  std::optional<double> upper = std::nullopt;
  Scale scale = Scale::linear;
};

/// In pixels of a screen, at least 160 x 120.
struct Size {
  int width = 640;
  int height = 420;
};

/// Half lengths, one a point; empty where there are none.
struct ErrorBars {
  std::span<const double> x = {};
  std::span<const double> y = {};
};

enum class LineStyle { solid, dashed, dotted };

/// Sequential from the smallest to the largest value, or diverging around zero.
enum class ColorScale { sequential, diverging };

/// Whether the cells of a heat map show their value.
enum class CellText { hidden, shown };

struct FigureContent;

/// Builds one figure. Series take the next of eight colours that colour-blind readers can tell
/// apart; series with the same label share a colour and an entry of the legend, an empty label has
/// none. Points that are not finite (or not positive on a log scale) are skipped, and lines have
/// gaps there. Every function throws InputError if its arguments do not fit together.
class Figure {
 public:
  Figure(std::string title, Axis x, Axis y, Size size = {});
  ~Figure();
  Figure(Figure&&) noexcept;
  Figure& operator=(Figure&&) noexcept;

  Figure& scatter(std::span<const double> x, std::span<const double> y, std::string label = {},
                  ErrorBars errors = {});
  Figure& lines(std::span<const double> x, std::span<const double> y, std::string label = {},
                LineStyle style = LineStyle::solid);
  /// The area between two curves: a confidence band around a line.
  Figure& ribbon(std::span<const double> x, std::span<const double> lower,
                 std::span<const double> upper, std::string label = {});

  /// One bar a category, upwards from zero; further calls with the same categories stand beside it.
  Figure& bars(const std::vector<std::string>& categories, std::span<const double> values,
               std::string label = {}, std::span<const double> errors = {});
  /// The same with the categories on the y axis, the first on top: room for long names.
  Figure& horizontal_bars(const std::vector<std::string>& categories,
                          std::span<const double> values, std::string label = {},
                          std::span<const double> errors = {});
  /// Box plots, one a category: quartiles (linear between order statistics), whiskers to the
  /// farthest value within 1.5 interquartile ranges, circles beyond [Tukey1977]. A category may
  /// have no values.
  Figure& box(const std::vector<std::string>& categories,
              const std::vector<std::vector<double>>& samples, std::string label = {});

  /// Cell (i, j) of `values` spans y_edges[i..i+1] and x_edges[j..j+1]; `label` names the colour
  /// bar.
  Figure& heat_map(std::span<const double> x_edges, std::span<const double> y_edges,
                   const Matrix& values, Axis color, ColorScale colors = ColorScale::sequential);
  /// The same with a category for each column and row; the first row is on top.
  Figure& heat_map(const std::vector<std::string>& columns, const std::vector<std::string>& rows,
                   const Matrix& values, Axis color, ColorScale colors = ColorScale::sequential,
                   CellText text = CellText::shown);

  /// Shaded between two values of y (a target and its tolerance) or of x.
  Figure& band(double lower, double upper, std::string label = {});
  Figure& vertical_band(double lower, double upper, std::string label = {});
  Figure& horizontal_line(double y, std::string label = {});
  Figure& vertical_line(double x, std::string label = {});
  /// y = x, as in a plot of predictions against observations.
  Figure& diagonal(std::string label = {});
  /// A line of text in the upper left corner of the plot.
  Figure& note(std::string text);

  /// The figure as the text of an SVG file, ending in a line end; it can also stand inside HTML.
  std::string svg() const;

 private:
  std::unique_ptr<FigureContent> content_;
};

}  // namespace repose::plot

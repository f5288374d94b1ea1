#include "layout.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "style.hpp"
#include "text.hpp"

namespace repose::plot {
namespace {

constexpr double kLegendRow = 18.0;
constexpr double kLegendGap = 18.0;
constexpr double kSmallestPlot = 40.0;
constexpr double kLongestSlantedLabel = 150.0;

// ---- what the axes have to show

/// Extents of both axes; zero and negative values have no place on a log axis.
class Extents {
 public:
  explicit Extents(const FigureContent& content) : content_(content) {}
  Extent x, y;

  void include_x(double value) { include(x, content_.x, value); }
  void include_y(double value) { include(y, content_.y, value); }
  void include_x(const std::vector<double>& values) {
    for (const double value : values) include_x(value);
  }
  void include_y(const std::vector<double>& values) {
    for (const double value : values) include_y(value);
  }

 private:
  static void include(Extent& extent, const Axis& axis, double value) {
    if (axis.scale == Scale::linear || value > 0.0) extent.include(value);
  }
  const FigureContent& content_;
};

void include_points(const Points& points, Extents& extents) {
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    // A point counts only if it can be shown as a whole.
    if (!std::isfinite(points.x[i]) || !std::isfinite(points.y[i])) continue;
    const auto error = [i](const std::vector<double>& e) {
      return e.empty() || !std::isfinite(e[i]) ? 0.0 : e[i];
    };
    for (const double sign : {-1.0, 1.0}) {
      extents.include_x(points.x[i] + sign * error(points.error_x));
      extents.include_y(points.y[i] + sign * error(points.error_y));
    }
  }
}

void include_bars(const FigureContent& content, Extents& extents) {
  const bool is_horizontal = !content.y_categories.empty();
  const auto include = [&](double value) {
    is_horizontal ? extents.include_x(value) : extents.include_y(value);
  };
  for (const Bars& bars : content.bars) {
    include(0.0);
    for (std::size_t i = 0; i < bars.values.size(); ++i) {
      const double error =
          bars.errors.empty() || !std::isfinite(bars.errors[i]) ? 0.0 : bars.errors[i];
      include(bars.values[i] - error);
      include(bars.values[i] + error);
    }
  }
}

void include_reference(const FigureContent& content, Extents& extents) {
  for (const Band& band : content.bands)
    for (const double value : {band.lower, band.upper})
      band.direction == Direction::horizontal ? extents.include_y(value) : extents.include_x(value);
  for (const Rule& rule : content.rules)
    rule.direction == Direction::horizontal ? extents.include_y(rule.value)
                                            : extents.include_x(rule.value);
}

Extents extents_of(const FigureContent& content) {
  Extents extents(content);
  for (const Points& points : content.points) include_points(points, extents);
  for (const Curve& curve : content.curves) {
    extents.include_x(curve.x);
    extents.include_y(curve.y);
  }
  for (const Ribbon& ribbon : content.ribbons) {
    extents.include_x(ribbon.x);
    extents.include_y(ribbon.lower);
    extents.include_y(ribbon.upper);
  }
  include_bars(content, extents);
  for (const Boxes& boxes : content.boxes)
    for (const auto& sample : boxes.samples) extents.include_y(sample);
  if (content.heat_map) {
    extents.include_x(content.heat_map->x_edges);
    extents.include_y(content.heat_map->y_edges);
  }
  include_reference(content, extents);
  if (content.has_diagonal) {  // both axes show the same
    const Extent x = extents.x;
    for (const double value : {extents.y.lower(), extents.y.upper()})
      if (!extents.y.is_empty()) extents.include_x(value);
    for (const double value : {x.lower(), x.upper()})
      if (!x.is_empty()) extents.include_y(value);
  }
  return extents;
}

Limits limits_of(const FigureContent& content) {
  return content.heat_map ? Limits::exact : Limits::round;
}

// ---- how much room text takes

double widest_label(const AxisPlan& plan) {
  double widest = 0.0;
  for (const Tick& tick : plan.ticks)
    widest = std::max(widest, text_width(pretty_number(tick.text), kTickSize) +
                                  text_width(tick.superscript, 0.72 * kTickSize));
  return widest;
}

/// Categories that get no more than `width_px` each.
AxisPlan shortened_categories(const std::vector<std::string>& categories, double width_px) {
  std::vector<std::string> names;
  for (const std::string& name : categories) names.push_back(shortened(name, kTickSize, width_px));
  return plan_categories(names);
}

bool labels_fit(const AxisPlan& plan, double width_px) {
  return (widest_label(plan) + 10.0) * static_cast<double>(plan.ticks.size()) <= width_px;
}

/// As many ticks as their labels leave room for; those of y if both axes share a diagonal.
AxisPlan plan_x(const FigureContent& content, const Extents& extents, const AxisPlan& y,
                double width_px) {
  if (!content.x_categories.empty())
    return shortened_categories(content.x_categories, kLongestSlantedLabel);
  Axis axis = content.x;
  if (content.has_diagonal && !axis.lower && !axis.upper) {
    if (labels_fit(y, width_px)) return y;
    axis.lower = y.lower;
    axis.upper = y.upper;
  }
  AxisPlan plan;
  for (int count = std::max(2, static_cast<int>(width_px / 75.0)); count >= 1; --count) {
    plan = plan_axis(axis, extents.x, limits_of(content), count);
    if (labels_fit(plan, width_px)) break;
  }
  return plan;
}

AxisPlan plan_y(const FigureContent& content, const Extents& extents, double height_px) {
  if (!content.y_categories.empty())
    return shortened_categories(content.y_categories, 0.45 * content.size.width);
  const int count = std::max(2, static_cast<int>(height_px / 48.0));
  return plan_axis(content.y, extents.y, limits_of(content), count);
}

/// Values of colours: symmetrical around zero if diverging.
AxisPlan plan_colors(const HeatMap& map, double height_px) {
  Extent extent;
  for (const double value : map.values.reshaped()) {
    if (map.color.scale == Scale::linear || value > 0.0) extent.include(value);
    if (map.colors == ColorScale::diverging) extent.include(-value);
  }
  return plan_axis(map.color, extent, Limits::exact,
                   std::max(2, static_cast<int>(height_px / 48.0)));
}

double swatch_width(const LegendEntry& entry) {
  const auto is_narrow = [](const LegendGlyph& g) {
    return g.glyph == Glyph::marker || g.glyph == Glyph::bar || g.glyph == Glyph::box;
  };
  return std::all_of(entry.glyphs.begin(), entry.glyphs.end(), is_narrow) ? kNarrowSwatch
                                                                          : kWideSwatch;
}

/// Places the entries in rows from the left; returns the lower end.
double place_legend(const FigureContent& content, double top, Layout& layout) {
  const double right = content.size.width - kMargin;
  double x = kMargin;
  double row_top = top;
  for (const LegendEntry& entry : content.legend) {
    const double swatch = swatch_width(entry);
    const std::string label = shortened(entry.label, kLegendSize, right - kMargin - swatch - 6.0);
    const double width = swatch + 6.0 + 1.05 * text_width(label, kLegendSize);
    if (x > kMargin && x + width > right) {
      x = kMargin;
      row_top += kLegendRow;
    }
    layout.legend.push_back({{x, row_top + 13.0}, swatch, label, &entry});
    x += width + kLegendGap;
  }
  return layout.legend.empty() ? top : row_top + kLegendRow;
}

/// Height of the tick labels below the plot, and whether they are slanted.
double x_label_height(const FigureContent& content, Layout& layout) {
  const double widest = widest_label(layout.x);
  const double slot = layout.plot.width / std::max(1.0, static_cast<double>(layout.x.ticks.size()));
  layout.x_labels_slanted = !content.x_categories.empty() && widest > 0.92 * slot;
  if (!layout.x_labels_slanted) return kTickSize;
  const double slant = -kSlant_deg * std::numbers::pi / 180.0;
  return widest * std::sin(slant) + kTickSize * std::cos(slant);
}

/// Slanted labels reach to the left of their tick.
double slanted_overhang(const Layout& layout) {
  if (!layout.x_labels_slanted) return 0.0;
  const double slant = -kSlant_deg * std::numbers::pi / 180.0;
  const double slot = layout.plot.width / static_cast<double>(layout.x.ticks.size());
  double overhang = 0.0;
  for (std::size_t i = 0; i < layout.x.ticks.size(); ++i)
    overhang = std::max(overhang, text_width(layout.x.ticks[i].text, kTickSize) * std::cos(slant) -
                                      (static_cast<double>(i) + 0.5) * slot);
  return overhang;
}

double color_bar_width(const Layout& layout) {
  return layout.color_bar ? 16.0 + 14.0 + kTickLength + kTickGap +
                                widest_label(layout.color_bar->plan) + 6.0 + kLabelSize
                          : 0.0;
}

}  // namespace

PixelMap Layout::y_map() const {
  return y_is_categories ? PixelMap(y, plot.top, plot.bottom())
                         : PixelMap(y, plot.bottom(), plot.top);
}

Layout lay_out(const FigureContent& content) {
  Layout layout;
  const Extents extents = extents_of(content);
  layout.y_is_categories = !content.y_categories.empty();

  double top = kMargin;
  if (!content.title.empty()) {
    layout.title_baseline = kMargin + kTitleSize - 2.0;
    top = layout.title_baseline + 9.0;
  }
  layout.plot.top = place_legend(content, top, layout) + (content.legend.empty() ? 7.0 : 10.0);
  const double x_title_height = content.x.label.empty() ? 0.0 : kLabelSize + 6.0;
  const double below_labels = x_title_height + kMargin;
  const double expected_height =
      content.size.height - layout.plot.top - kTickLength - kTickGap - kTickSize - below_labels;
  layout.y = plan_y(content, extents, expected_height);
  if (content.heat_map)
    layout.color_bar = Layout::ColorBar{plan_colors(*content.heat_map, expected_height), {}};

  const double y_title_width = content.y.label.empty() ? 0.0 : kLabelSize + 7.0;
  layout.y_title_baseline = kMargin + kLabelSize - 3.0;
  layout.plot.left =
      kMargin + y_title_width + 1.06 * widest_label(layout.y) + kTickGap + kTickLength;
  const double right_margin = kMargin + 8.0 + color_bar_width(layout);
  const auto fit_width = [&] {
    layout.plot.width =
        std::max(kSmallestPlot, content.size.width - layout.plot.left - right_margin);
  };
  fit_width();
  layout.x = plan_x(content, extents, layout.y, layout.plot.width);
  double label_height = x_label_height(content, layout);
  const double lacking = slanted_overhang(layout) + kMargin - layout.plot.left;
  if (lacking > 0.0) {
    layout.plot.left += lacking;
    fit_width();
    label_height = x_label_height(content, layout);
  }
  layout.plot.height = std::max(kSmallestPlot, content.size.height - layout.plot.top - kTickLength -
                                                   kTickGap - label_height - below_labels);
  layout.x_title_baseline =
      layout.plot.bottom() + kTickLength + kTickGap + label_height + x_title_height - 2.0;
  layout.x_title = axis_title(content.x, layout.x.exponent);
  layout.y_title = axis_title(content.y, layout.y.exponent);
  if (layout.color_bar)
    layout.color_bar->area = {layout.plot.right() + 16.0, layout.plot.top, 14.0,
                              layout.plot.height};
  return layout;
}

}  // namespace repose::plot

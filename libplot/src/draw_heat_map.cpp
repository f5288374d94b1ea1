#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "draw.hpp"
#include "style.hpp"
#include "text.hpp"

namespace repose::plot {
namespace {

/// Nothing where there is no value.
std::optional<Color> cell_color(double value, const HeatMap& map, const AxisPlan& plan) {
  if (!std::isfinite(value) || (plan.scale == Scale::log && value <= 0.0)) return std::nullopt;
  return map_color(map.colors, PixelMap(plan, 0.0, 1.0)(value));
}

/// Three significant digits, as far as a cell has room for them.
std::string cell_text(double value) {
  std::string text = fmt::format("{:.3g}", value);
  if (text == "-0") text = "0";
  return pretty_number(text);
}

}  // namespace

void draw_heat_map(const HeatMap& map, const Layout& layout, SvgWriter& svg) {
  const AxisPlan& colors = layout.color_bar->plan;
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  svg.begin("g", R"(class="heatmap" shape-rendering="crispEdges")");
  for (Eigen::Index i = 0; i < map.values.rows(); ++i)
    for (Eigen::Index j = 0; j < map.values.cols(); ++j) {
      const auto row = static_cast<std::size_t>(i);
      const auto column = static_cast<std::size_t>(j);
      const double left = x(map.x_edges[column]);
      const double right = x(map.x_edges[column + 1]);
      const double top = std::min(y(map.y_edges[row]), y(map.y_edges[row + 1]));
      const double bottom = std::max(y(map.y_edges[row]), y(map.y_edges[row + 1]));
      const double value = map.values(i, j);
      const auto color = cell_color(value, map, colors);
      svg.rectangle({left, top, right - left, bottom - top},
                    fmt::format(R"(fill="{}")", color ? color->text() : kNoValue));
    }
  svg.end();
  if (map.text == CellText::shown)
    for (Eigen::Index i = 0; i < map.values.rows(); ++i)
      for (Eigen::Index j = 0; j < map.values.cols(); ++j) {
        const double value = map.values(i, j);
        const std::string text = cell_text(value);
        const double room = layout.plot.width / static_cast<double>(map.values.cols());
        const auto color = cell_color(value, map, colors);
        if (!color || text_width(text, kCellTextSize) > 0.95 * room) continue;
        svg.text({x(static_cast<double>(j) + 0.5),
                  y(static_cast<double>(i) + 0.5) + 0.35 * kCellTextSize},
                 text,
                 {.size = kCellTextSize,
                  .anchor = Anchor::middle,
                  .color = color->is_light() ? "#000000" : "#ffffff"});
      }
}

void draw_color_bar(const HeatMap& map, const Layout& layout, SvgWriter& svg) {
  constexpr int kShades = 64;
  const Layout::ColorBar& bar = *layout.color_bar;
  const Rectangle& area = bar.area;
  svg.begin("g", R"(class="colorbar" shape-rendering="crispEdges")");
  for (int i = 0; i < kShades; ++i)
    svg.rectangle({area.left, area.bottom() - area.height * (i + 1) / kShades, area.width,
                   area.height / kShades + 0.5},
                  fmt::format(R"(fill="{}")", map_color(map.colors, (i + 0.5) / kShades).text()));
  svg.end();
  svg.rectangle(area, fmt::format(R"(fill="none" stroke="{}" stroke-width="0.8")", kInk));
  const PixelMap position(bar.plan, area.bottom(), area.top);
  double widest = 0.0;
  for (const Tick& tick : bar.plan.ticks) {
    const double y = position(tick.value);
    svg.line({area.right(), y}, {area.right() + kTickLength, y},
             fmt::format(R"(stroke="{}")", kInk));
    svg.text({area.right() + kTickLength + kTickGap, y + 0.35 * kTickSize},
             pretty_number(tick.text), {.size = kTickSize});
    widest = std::max(widest, text_width(pretty_number(tick.text), kTickSize));
  }
  const std::string title = axis_title(map.color, bar.plan.exponent);
  if (!map.color.label.empty())
    svg.text({area.right() + kTickLength + kTickGap + 1.06 * widest + 6.0 + 0.8 * kLabelSize,
              area.top + 0.5 * area.height},
             title, {.size = kLabelSize, .anchor = Anchor::middle, .rotation_deg = -90.0});
}

}  // namespace repose::plot

// The order of things: ground, grid, bands, data, axes, words.
#include "draw.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "style.hpp"
#include "text.hpp"

namespace repose::plot {
namespace {

std::string stroke(const char* color, double width) {
  return fmt::format(R"(stroke="{}" stroke-width="{}")", color, px(width));
}

/// Everything until end() is cut off at the plot's frame. An inner <svg> needs no id, so that
/// several figures can share an HTML page.
void begin_clipped(const Rectangle& plot, SvgWriter& svg) {
  const std::string box =
      fmt::format("{} {} {} {}", px(plot.left), px(plot.top), px(plot.width), px(plot.height));
  svg.begin("svg", fmt::format(R"(x="{}" y="{}" width="{}" height="{}" viewBox="{}" )"
                               R"(preserveAspectRatio="none")",
                               px(plot.left), px(plot.top), px(plot.width), px(plot.height), box));
}

void draw_bands(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  const auto placed = [](double value, const AxisPlan& plan) {
    return plan.scale == Scale::log && value <= 0.0 ? plan.lower
                                                    : std::clamp(value, plan.lower, plan.upper);
  };
  for (const Band& band : content.bands) {
    const bool is_horizontal = band.direction == Direction::horizontal;
    const AxisPlan& plan = is_horizontal ? layout.y : layout.x;
    const PixelMap& map = is_horizontal ? y : x;
    const double a = map(placed(band.lower, plan));
    const double b = map(placed(band.upper, plan));
    Rectangle area = layout.plot;
    if (is_horizontal)
      area = {area.left, std::min(a, b), area.width, std::abs(a - b)};
    else
      area = {std::min(a, b), area.top, std::abs(a - b), area.height};
    svg.rectangle(area, fmt::format(R"(class="band" fill="{}" fill-opacity="0.5")", band.color));
  }
}

void draw_grid(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const Rectangle& plot = layout.plot;
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  svg.begin("g", fmt::format(R"(class="grid" {})", stroke(kGrid, 0.8)));
  if (content.x_categories.empty())
    for (const Tick& tick : layout.x.ticks)
      svg.line({x(tick.value), plot.top}, {x(tick.value), plot.bottom()});
  if (content.y_categories.empty())
    for (const Tick& tick : layout.y.ticks)
      svg.line({plot.left, y(tick.value)}, {plot.right(), y(tick.value)});
  svg.end();
}

void draw_rules(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const Rectangle& plot = layout.plot;
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  for (const Rule& rule : content.rules) {
    const bool is_horizontal = rule.direction == Direction::horizontal;
    if (!(is_horizontal ? y : x).shows(rule.value)) continue;
    const double at = (is_horizontal ? y : x)(rule.value);
    const std::string attributes =
        fmt::format(R"(class="rule" {} stroke-dasharray="6 4")", stroke(kReferenceInk, 1.2));
    if (is_horizontal)
      svg.line({plot.left, at}, {plot.right(), at}, attributes);
    else
      svg.line({at, plot.top}, {at, plot.bottom()}, attributes);
  }
  if (!content.has_diagonal) return;
  const double lower = std::min(layout.x.lower, layout.y.lower);
  const double upper = std::max(layout.x.upper, layout.y.upper);
  svg.line({x(lower), y(lower)}, {x(upper), y(upper)},
           fmt::format(R"(class="diagonal" {})", stroke(kReferenceInk, 1.0)));
}

void draw_x_axis(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const Rectangle& plot = layout.plot;
  const PixelMap x = layout.x_map();
  const bool has_marks = content.x_categories.empty();
  svg.begin("g", R"(class="x axis")");
  svg.line({plot.left, plot.bottom()}, {plot.right(), plot.bottom()}, stroke(kInk, 1.0));
  for (const double value : layout.x.minor_ticks)
    svg.line({x(value), plot.bottom()}, {x(value), plot.bottom() + 0.55 * kTickLength},
             stroke(kInk, 0.8));
  const double top = plot.bottom() + kTickLength + kTickGap;
  for (const Tick& tick : layout.x.ticks) {
    const double at = x(tick.value);
    if (has_marks)
      svg.line({at, plot.bottom()}, {at, plot.bottom() + kTickLength}, stroke(kInk, 1.0));
    const std::string text = has_marks ? pretty_number(tick.text) : tick.text;
    if (layout.x_labels_slanted)
      svg.text({at + 4.0, top + 0.55 * kTickSize}, text,
               {.size = kTickSize, .anchor = Anchor::end, .rotation_deg = kSlant_deg});
    else
      svg.text({at, top + 0.8 * kTickSize}, text, {.size = kTickSize, .anchor = Anchor::middle},
               pretty_number(tick.superscript));
  }
  if (!content.x.label.empty())
    svg.text({plot.left + 0.5 * plot.width, layout.x_title_baseline}, layout.x_title,
             {.size = kLabelSize, .anchor = Anchor::middle});
  svg.end();
}

void draw_y_axis(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const Rectangle& plot = layout.plot;
  const PixelMap y = layout.y_map();
  const bool has_marks = content.y_categories.empty();
  svg.begin("g", R"(class="y axis")");
  svg.line({plot.left, plot.top}, {plot.left, plot.bottom()}, stroke(kInk, 1.0));
  for (const double value : layout.y.minor_ticks)
    svg.line({plot.left - 0.55 * kTickLength, y(value)}, {plot.left, y(value)}, stroke(kInk, 0.8));
  for (const Tick& tick : layout.y.ticks) {
    const double at = y(tick.value);
    if (has_marks) svg.line({plot.left - kTickLength, at}, {plot.left, at}, stroke(kInk, 1.0));
    svg.text({plot.left - kTickLength - kTickGap, at + 0.35 * kTickSize},
             has_marks ? pretty_number(tick.text) : tick.text,
             {.size = kTickSize, .anchor = Anchor::end}, pretty_number(tick.superscript));
  }
  if (!content.y.label.empty())
    svg.text({layout.y_title_baseline, plot.top + 0.5 * plot.height}, layout.y_title,
             {.size = kLabelSize, .anchor = Anchor::middle, .rotation_deg = -90.0});
  svg.end();
}

void draw_glyph(const LegendGlyph& glyph, Point at, double swatch, SvgWriter& svg) {
  const double middle = at.y - 0.35 * kLegendSize;
  const Point left{at.x, middle};
  const Point right{at.x + swatch, middle};
  const Rectangle box{at.x, middle - 5.5, swatch, 11.0};
  switch (glyph.glyph) {
    case Glyph::marker:
      svg.begin("g", fmt::format(R"(fill="{}")", glyph.color));
      draw_marker({at.x + 0.5 * swatch, middle}, glyph.series, 3.8, svg);
      return svg.end();
    case Glyph::line:
      return svg.line(
          left, right,
          fmt::format(R"({} {})", stroke(glyph.color.c_str(), 1.8), dashes(glyph.style)));
    case Glyph::ribbon:
      return svg.rectangle(box, fmt::format(R"(fill="{}" fill-opacity="0.2")", glyph.color));
    case Glyph::bar:
      return svg.rectangle(box, fmt::format(R"(fill="{}")", glyph.color));
    case Glyph::box:
      return svg.rectangle(box, fmt::format(R"(fill="{}" fill-opacity="0.25" {})", glyph.color,
                                            stroke(glyph.color.c_str(), 1.3)));
    case Glyph::band:
      return svg.rectangle(box, fmt::format(R"(fill="{}" fill-opacity="0.5")", glyph.color));
    case Glyph::rule:
      return svg.line(
          left, right,
          fmt::format(R"({} stroke-dasharray="6 4")", stroke(glyph.color.c_str(), 1.2)));
    case Glyph::diagonal:
      return svg.line(left, right, stroke(glyph.color.c_str(), 1.0));
  }
}

void draw_legend(const Layout& layout, SvgWriter& svg) {
  svg.begin("g", R"(class="legend")");
  for (const LegendPlace& place : layout.legend) {
    for (const LegendGlyph& glyph : place.entry->glyphs)
      draw_glyph(glyph, place.at, place.swatch, svg);
    svg.text({place.at.x + place.swatch + 6.0, place.at.y}, place.label, {.size = kLegendSize});
  }
  svg.end();
}

void draw_notes(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  Point at{layout.plot.left + 10.0, layout.plot.top + 8.0};
  for (const std::string& note : content.notes) {
    svg.rectangle({at.x - 4.0, at.y - 1.0, 1.06 * text_width(note, kTickSize) + 8.0, 16.0},
                  R"(fill="#ffffff" fill-opacity="0.8")");
    svg.text({at.x, at.y + 11.0}, note, {.size = kTickSize});
    at.y += 16.0;
  }
}

void draw_data(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  begin_clipped(layout.plot, svg);
  draw_bands(content, layout, svg);
  if (content.heat_map) draw_heat_map(*content.heat_map, layout, svg);
  draw_ribbons(content, layout, svg);
  svg.end();
  draw_bars(content, layout, svg);
  draw_baseline(content, layout, svg);
  draw_boxes(content, layout, svg);
  begin_clipped(layout.plot, svg);
  draw_rules(content, layout, svg);
  draw_curves(content, layout, svg);
  svg.end();
  if (content.heat_map) draw_color_bar(*content.heat_map, layout, svg);
  draw_points(content, layout, svg);  // only those inside; their markers may overlap the frame
}

}  // namespace

std::string draw_figure(const FigureContent& content) {
  const Layout layout = lay_out(content);
  const auto [width, height] = content.size;
  SvgWriter svg;
  svg.begin("svg", fmt::format(R"(xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" )"
                               R"(viewBox="0 0 {0} {1}" role="img" fill="{2}" )"
                               R"(font-family="Helvetica, Arial, 'Liberation Sans', sans-serif")",
                               width, height, kInk));
  svg.element("title", content.title.empty() ? "Figure" : content.title);
  svg.rectangle({0.0, 0.0, static_cast<double>(width), static_cast<double>(height)},
                R"(class="ground" fill="#ffffff")");
  if (!content.heat_map) draw_grid(content, layout, svg);
  draw_data(content, layout, svg);
  draw_x_axis(content, layout, svg);
  draw_y_axis(content, layout, svg);
  draw_notes(content, layout, svg);
  draw_legend(layout, svg);
  if (!content.title.empty())
    svg.text({kMargin, layout.title_baseline},
             shortened(content.title, kTitleSize, width - 2.0 * kMargin),
             {.size = kTitleSize, .weight = "bold"});
  svg.end();
  return std::move(svg).finish();
}

}  // namespace repose::plot

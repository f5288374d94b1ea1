// Series: points, curves, ribbons, bars and boxes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "draw.hpp"
#include "style.hpp"

namespace repose::plot {
namespace {

/// Whether a value has a place on the scale, inside the limits or not.
bool has_place(double value, Scale scale) {
  return std::isfinite(value) && (scale == Scale::linear || value > 0.0);
}

std::string path_point(const char* command, Point p) {
  return fmt::format("{}{} {}", command, px(p.x), px(p.y));
}

/// Indices of consecutive points that have a place on both axes.
std::vector<std::vector<std::size_t>> unbroken_runs(std::size_t n, const auto& is_drawn) {
  std::vector<std::vector<std::size_t>> runs(1);
  for (std::size_t i = 0; i < n; ++i) {
    if (is_drawn(i))
      runs.back().push_back(i);
    else if (!runs.back().empty())
      runs.emplace_back();
  }
  if (runs.back().empty()) runs.pop_back();
  return runs;
}

/// M x y L x y ..., without points that fall onto the one before.
std::string polyline(const std::vector<Point>& points) {
  std::string data = path_point("M", points.front());
  std::string last = path_point("L", points.front());
  if (points.size() == 1) return data + last;  // round line caps make it a dot
  for (std::size_t i = 1; i < points.size(); ++i) {
    std::string next = path_point("L", points[i]);
    if (next == last && i + 1 < points.size()) continue;
    data += next;
    last = std::move(next);
  }
  return data;
}

// ---- bars and boxes

/// The part of its slot that member `k` of a group of `n` takes, along an axis of categories.
struct Slot {
  double from, to;
  double middle() const { return 0.5 * (from + to); }
};

Slot slot_of(std::size_t category, std::size_t k, std::size_t n, double filled) {
  const double width = filled / static_cast<double>(n);
  const double from = static_cast<double>(category) + 0.5 * (1.0 - filled);
  return {from + width * static_cast<double>(k), from + width * static_cast<double>(k + 1)};
}

/// Draws along and across the axis of categories, whichever way it goes.
class CategoryPlane {
 public:
  explicit CategoryPlane(const Layout& layout)
      : x_(layout.x_map()), y_(layout.y_map()), is_horizontal_(layout.y_is_categories) {
    const AxisPlan& plan = is_horizontal_ ? layout.x : layout.y;
    lower_ = plan.lower;
    upper_ = plan.upper;
    scale_ = plan.scale;
  }

  bool has_place_for(double value) const { return has_place(value, scale_); }
  double clamped(double value) const {
    return has_place_for(value) ? std::clamp(value, lower_, upper_) : lower_;
  }
  double baseline() const { return clamped(0.0); }
  Point at(double category, double value) const {
    return is_horizontal_ ? Point{x_(value), y_(category)} : Point{x_(category), y_(value)};
  }
  Rectangle between(const Slot& slot, double a, double b) const {
    const Point p = at(slot.from, clamped(a));
    const Point q = at(slot.to, clamped(b));
    return {std::min(p.x, q.x), std::min(p.y, q.y), std::abs(p.x - q.x), std::abs(p.y - q.y)};
  }
  bool is_within(double value) const {
    return has_place_for(value) && value >= lower_ && value <= upper_;
  }

 private:
  PixelMap x_, y_;
  bool is_horizontal_;
  double lower_, upper_;
  Scale scale_;
};

void draw_whisker(const CategoryPlane& plane, double category, double half_cap, double from,
                  double to, SvgWriter& svg) {
  const double a = plane.clamped(from);
  const double b = plane.clamped(to);
  svg.line(plane.at(category, a), plane.at(category, b));
  if (plane.is_within(to))
    svg.line(plane.at(category - half_cap, b), plane.at(category + half_cap, b));
}

void draw_box(const CategoryPlane& plane, const Slot& slot, std::vector<double> sample,
              SvgWriter& svg) {
  std::erase_if(sample, [&](double value) { return !plane.has_place_for(value); });
  if (sample.empty()) return;
  std::sort(sample.begin(), sample.end());
  const double first_quartile = quantile(sample, 0.25);
  const double median = quantile(sample, 0.5);
  const double third_quartile = quantile(sample, 0.75);
  const double reach = 1.5 * (third_quartile - first_quartile);
  const double low = *std::lower_bound(sample.begin(), sample.end(), first_quartile - reach);
  const double high = *(std::upper_bound(sample.begin(), sample.end(), third_quartile + reach) - 1);
  const double cap = 0.25 * (slot.to - slot.from);
  draw_whisker(plane, slot.middle(), cap, first_quartile, low, svg);
  draw_whisker(plane, slot.middle(), cap, third_quartile, high, svg);
  svg.rectangle(plane.between(slot, first_quartile, third_quartile), R"(class="box")");
  if (plane.is_within(median))
    svg.line(plane.at(slot.from, median), plane.at(slot.to, median), R"(stroke-width="2.2")");
  for (const double value : sample)
    if ((value < low || value > high) && plane.is_within(value))
      svg.circle(plane.at(slot.middle(), value), 2.6, R"(fill="none")");
}

// ---- points

void draw_error_bars(const Points& points, const Layout& layout, SvgWriter& svg) {
  constexpr double kHalfCap = 2.5;
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  const auto limited = [](double value, const AxisPlan& plan) {
    return has_place(value, plan.scale) ? std::clamp(value, plan.lower, plan.upper) : plan.lower;
  };
  svg.begin("g", fmt::format(R"(class="errors" stroke="{}" stroke-width="1.1")",
                             series_color(points.series)));
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    if (!x.shows(points.x[i]) || !y.shows(points.y[i])) continue;
    const Point at{x(points.x[i]), y(points.y[i])};
    if (!points.error_y.empty() && std::isfinite(points.error_y[i])) {
      for (const double end : {points.y[i] - points.error_y[i], points.y[i] + points.error_y[i]}) {
        const double end_px = y(limited(end, layout.y));
        svg.line(at, {at.x, end_px});
        if (y.shows(end)) svg.line({at.x - kHalfCap, end_px}, {at.x + kHalfCap, end_px});
      }
    }
    if (!points.error_x.empty() && std::isfinite(points.error_x[i])) {
      for (const double end : {points.x[i] - points.error_x[i], points.x[i] + points.error_x[i]}) {
        const double end_px = x(limited(end, layout.x));
        svg.line(at, {end_px, at.y});
        if (x.shows(end)) svg.line({end_px, at.y - kHalfCap}, {end_px, at.y + kHalfCap});
      }
    }
  }
  svg.end();
}

/// Small where there are many.
double marker_radius(std::size_t count) {
  return count > 1000 ? 1.8 : count > 200 ? 2.6 : 3.6;
}

}  // namespace

std::string dashes(LineStyle style) {
  if (style == LineStyle::dashed) return R"(stroke-dasharray="7 4")";
  if (style == LineStyle::dotted) return R"(stroke-dasharray="1.5 4")";
  return {};
}

void draw_marker(Point center, std::size_t series, double radius, SvgWriter& svg) {
  const double r = radius;
  const auto at = [&](double dx, double dy) {
    return fmt::format("{} {}", px(center.x + r * dx), px(center.y + r * dy));
  };
  switch (series % 4) {
    case 0:
      return svg.circle(center, r);
    case 1:
      return svg.rectangle({center.x - 0.89 * r, center.y - 0.89 * r, 1.78 * r, 1.78 * r});
    case 2:
      return svg.path(fmt::format("M{}L{}L{}Z", at(0.0, -1.25), at(1.12, 0.8), at(-1.12, 0.8)));
    default:
      return svg.path(
          fmt::format("M{}L{}L{}L{}Z", at(0.0, -1.3), at(1.3, 0.0), at(0.0, 1.3), at(-1.3, 0.0)));
  }
}

void draw_ribbons(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  for (const Ribbon& ribbon : content.ribbons) {
    const auto is_drawn = [&](std::size_t i) {
      return has_place(ribbon.x[i], layout.x.scale) && has_place(ribbon.lower[i], layout.y.scale) &&
             has_place(ribbon.upper[i], layout.y.scale);
    };
    for (const auto& run : unbroken_runs(ribbon.x.size(), is_drawn)) {
      std::vector<Point> outline;
      for (const std::size_t i : run) outline.push_back({x(ribbon.x[i]), y(ribbon.upper[i])});
      for (auto i = run.rbegin(); i != run.rend(); ++i)
        outline.push_back({x(ribbon.x[*i]), y(ribbon.lower[*i])});
      svg.path(polyline(outline) + "Z",
               fmt::format(R"(class="ribbon" fill="{}" fill-opacity="0.2")",
                           series_color(ribbon.series)));
    }
  }
}

void draw_curves(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  for (const Curve& curve : content.curves) {
    const auto is_drawn = [&](std::size_t i) {
      return has_place(curve.x[i], layout.x.scale) && has_place(curve.y[i], layout.y.scale);
    };
    svg.begin("g", fmt::format(R"(class="curve" fill="none" stroke="{}" stroke-width="1.8" )"
                               R"(stroke-linejoin="round" stroke-linecap="round" {})",
                               series_color(curve.series), dashes(curve.style)));
    for (const auto& run : unbroken_runs(curve.x.size(), is_drawn)) {
      std::vector<Point> points;
      for (const std::size_t i : run) points.push_back({x(curve.x[i]), y(curve.y[i])});
      svg.path(polyline(points));
    }
    svg.end();
  }
}

void draw_bars(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const CategoryPlane plane(layout);
  const std::size_t n = content.bars.size();
  for (std::size_t k = 0; k < n; ++k) {
    const Bars& bars = content.bars[k];
    svg.begin("g", fmt::format(R"(class="bars" fill="{}" stroke="#ffffff" stroke-width="0.8")",
                               series_color(bars.series)));
    for (std::size_t i = 0; i < bars.values.size(); ++i)
      if (plane.has_place_for(bars.values[i]))
        svg.rectangle(plane.between(slot_of(i, k, n, 0.76), plane.baseline(), bars.values[i]));
    svg.end();
    if (bars.errors.empty()) continue;
    svg.begin("g", fmt::format(R"(class="errors" stroke="{}" stroke-width="1.1")", kInk));
    for (std::size_t i = 0; i < bars.values.size(); ++i) {
      if (!plane.has_place_for(bars.values[i]) || !std::isfinite(bars.errors[i])) continue;
      const Slot slot = slot_of(i, k, n, 0.76);
      const double cap = std::min(0.08, 0.2 * (slot.to - slot.from));
      draw_whisker(plane, slot.middle(), cap, bars.values[i], bars.values[i] - bars.errors[i], svg);
      draw_whisker(plane, slot.middle(), cap, bars.values[i], bars.values[i] + bars.errors[i], svg);
    }
    svg.end();
  }
}

void draw_baseline(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const CategoryPlane plane(layout);
  const AxisPlan& categories = layout.y_is_categories ? layout.y : layout.x;
  if (!content.bars.empty() && plane.is_within(0.0))
    svg.line(plane.at(categories.lower, 0.0), plane.at(categories.upper, 0.0),
             fmt::format(R"(class="baseline" stroke="{}" stroke-width="1")", kInk));
}

void draw_boxes(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const CategoryPlane plane(layout);
  const std::size_t n = content.boxes.size();
  for (std::size_t k = 0; k < n; ++k) {
    const char* const color = series_color(content.boxes[k].series);
    svg.begin("g", fmt::format(R"(class="boxes" fill="{0}" fill-opacity="0.25" stroke="{0}" )"
                               R"(stroke-width="1.3")",
                               color));
    for (std::size_t i = 0; i < content.boxes[k].samples.size(); ++i) {
      Slot slot = slot_of(i, k, n, n == 1 ? 0.5 : 0.7);
      const double gap = n == 1 ? 0.0 : 0.08 * (slot.to - slot.from);
      slot = {slot.from + gap, slot.to - gap};
      draw_box(plane, slot, content.boxes[k].samples[i], svg);
    }
    svg.end();
  }
}

void draw_points(const FigureContent& content, const Layout& layout, SvgWriter& svg) {
  const PixelMap x = layout.x_map();
  const PixelMap y = layout.y_map();
  for (const Points& points : content.points) {
    if (!points.error_x.empty() || !points.error_y.empty()) draw_error_bars(points, layout, svg);
    const double radius = marker_radius(points.x.size());
    svg.begin("g", fmt::format(R"(class="points" fill="{}" fill-opacity="0.85" stroke="#ffffff" )"
                               R"(stroke-width="0.6")",
                               series_color(points.series)));
    // Of points on the same quarter of a pixel one is enough.
    std::set<std::pair<long, long>> drawn;
    for (std::size_t i = 0; i < points.x.size(); ++i) {
      if (!x.shows(points.x[i]) || !y.shows(points.y[i])) continue;
      const Point at{x(points.x[i]), y(points.y[i])};
      if (drawn.emplace(std::lround(4.0 * at.x), std::lround(4.0 * at.y)).second)
        draw_marker(at, points.series, radius, svg);
    }
    svg.end();
  }
}

}  // namespace repose::plot

// Turns a figure's content into SVG.
#pragma once

#include <string>

#include "content.hpp"
#include "layout.hpp"
#include "svg.hpp"

namespace repose::plot {

std::string draw_figure(const FigureContent& content);

// The parts (draw_series.cpp, draw_heat_map.cpp).
void draw_ribbons(const FigureContent& content, const Layout& layout, SvgWriter& svg);
void draw_bars(const FigureContent& content, const Layout& layout, SvgWriter& svg);
/// Where bars begin.
void draw_baseline(const FigureContent& content, const Layout& layout, SvgWriter& svg);
void draw_boxes(const FigureContent& content, const Layout& layout, SvgWriter& svg);
void draw_curves(const FigureContent& content, const Layout& layout, SvgWriter& svg);
void draw_points(const FigureContent& content, const Layout& layout, SvgWriter& svg);
void draw_heat_map(const HeatMap& map, const Layout& layout, SvgWriter& svg);
void draw_color_bar(const HeatMap& map, const Layout& layout, SvgWriter& svg);

/// The marker of a series, its shape follows its colour.
void draw_marker(Point center, std::size_t series, double radius, SvgWriter& svg);
/// stroke-dasharray="..." or nothing.
std::string dashes(LineStyle style);

}  // namespace repose::plot

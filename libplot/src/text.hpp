// Text in figures: escaping, width, units and minus signs.
#pragma once

#include <string>
#include <string_view>

#include "repose/plot/figure.hpp"

namespace repose::plot {

/// Safe between tags and in attributes; characters that XML forbids become U+FFFD.
std::string escaped(std::string_view text);

/// Width in pixels as set in Helvetica or Arial [Adobe font metrics], other characters estimated;
/// within some 15 % for the fonts that replace it.
double text_width(std::string_view text, double font_size_px);

/// The text, or as much of its beginning as fits into `width_px`, with "…".
std::string shortened(std::string_view text, double font_size_px, double width_px);

/// "kg/m3" and "kg/m^3" as "kg/m³", "deg" as "°", "s-1" as "s⁻¹".
std::string pretty_unit(std::string_view text);

/// "-0.5" with a true minus sign.
std::string pretty_number(std::string_view number);

/// "Mass flow (10³ kg/s)"; the power is that of AxisPlan::exponent.
std::string axis_title(const Axis& axis, int exponent);

/// An integer in superscript characters: "⁻³".
std::string superscript(int number);

}  // namespace repose::plot

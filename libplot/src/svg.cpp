#include "svg.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "repose/base/error.hpp"
#include "text.hpp"

namespace repose::plot {

std::string px(double value) {
  constexpr double kFarOutside = 1e5;
  std::string text = fmt::format("{:.2f}", std::clamp(value, -kFarOutside, kFarOutside));
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

void SvgWriter::begin(std::string_view tag, std::string_view attributes) {
  out_ += fmt::format("<{} {}>\n", tag, attributes);
  open_.emplace_back(tag);
}

void SvgWriter::end() {
  REPOSE_ASSERT(!open_.empty(), "no element is open");
  out_ += fmt::format("</{}>\n", open_.back());
  open_.pop_back();
}

void SvgWriter::write(std::string_view tag, std::string_view geometry,
                      std::string_view attributes) {
  out_ += fmt::format("<{} {}{}{}/>\n", tag, geometry, attributes.empty() ? "" : " ", attributes);
}

void SvgWriter::line(Point from, Point to, std::string_view attributes) {
  write(
      "line",
      fmt::format(R"(x1="{}" y1="{}" x2="{}" y2="{}")", px(from.x), px(from.y), px(to.x), px(to.y)),
      attributes);
}

void SvgWriter::rectangle(const Rectangle& r, std::string_view attributes) {
  write("rect",
        fmt::format(R"(x="{}" y="{}" width="{}" height="{}")", px(r.left), px(r.top), px(r.width),
                    px(r.height)),
        attributes);
}

void SvgWriter::circle(Point center, double radius, std::string_view attributes) {
  write("circle", fmt::format(R"(cx="{}" cy="{}" r="{}")", px(center.x), px(center.y), px(radius)),
        attributes);
}

void SvgWriter::path(std::string_view data, std::string_view attributes) {
  write("path", fmt::format(R"(d="{}")", data), attributes);
}

void SvgWriter::text(Point at, std::string_view text, const TextStyle& style,
                     std::string_view superscript) {
  constexpr const char* kAnchors[] = {"start", "middle", "end"};
  out_ += fmt::format(R"(<text x="{}" y="{}" font-size="{}")", px(at.x), px(at.y), px(style.size));
  if (style.anchor != Anchor::start)
    out_ += fmt::format(R"( text-anchor="{}")", kAnchors[static_cast<int>(style.anchor)]);
  if (style.rotation_deg != 0.0)
    out_ += fmt::format(R"_( transform="rotate({} {} {})")_", px(style.rotation_deg), px(at.x),
                        px(at.y));
  if (!style.color.empty()) out_ += fmt::format(R"( fill="{}")", style.color);
  if (!style.weight.empty()) out_ += fmt::format(R"( font-weight="{}")", style.weight);
  out_ += fmt::format(">{}", escaped(text));
  if (!superscript.empty())
    out_ += fmt::format(R"(<tspan dy="{}" font-size="{}">{}</tspan>)", px(-0.38 * style.size),
                        px(0.72 * style.size), escaped(superscript));
  out_ += "</text>\n";
}

void SvgWriter::element(std::string_view tag, std::string_view text) {
  out_ += fmt::format("<{}>{}</{}>\n", tag, escaped(text), tag);
}

std::string SvgWriter::finish() && {
  REPOSE_ASSERT(open_.empty(), open_.back());
  return std::move(out_);
}

}  // namespace repose::plot

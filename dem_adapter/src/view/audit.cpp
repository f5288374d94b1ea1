// The picture that shows what was measured: the view as PNG inside an SVG, lines over it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "repose/dem_adapter/view_angle.hpp"

namespace repose::dem_adapter {
namespace {

constexpr int kWidth = 1600;

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '<')
      safe += "&lt;";
    else if (c == '&')
      safe += "&amp;";
    else
      safe += c;
  }
  return safe;
}

/// Places of the view in pixels of its picture.
struct Place {
  const View& view;
  double column(double x_m) const { return (x_m - view.left_m) / view.pixel_m; }
  double row(double z_m) const {
    return view.picture.height - (z_m - view.bottom_m) / view.pixel_m;
  }
};

/// The picture in blocks of n x n pixels, each their mean, n such that it is at most kWidth wide:
/// who looks at it needs no more, and a camera's 24 million pixels would make a file of 30
/// megabytes.
Picture for_eyes(const Picture& picture) {
  const int n = (picture.width + kWidth - 1) / kWidth;
  if (n == 1) return picture;
  Picture small((picture.width + n - 1) / n, (picture.height + n - 1) / n);
  for (int row = 0; row < small.height; ++row)
    for (int column = 0; column < small.width; ++column) {
      std::array<int, 3> sum{};
      int count = 0;
      for (int y = n * row; y < std::min(n * (row + 1), picture.height); ++y)
        for (int x = n * column; x < std::min(n * (column + 1), picture.width); ++x, ++count)
          for (std::size_t c = 0; c < 3; ++c) sum[c] += picture.at(x, y)[c];
      for (std::size_t c = 0; c < 3; ++c)
        small.at(column, row)[c] = static_cast<std::uint8_t>(sum[c] / count);
    }
  return small;
}

/// The edge as polylines, broken where columns are empty.
std::string edge_path(const View& view, const Place& place) {
  std::string path;
  bool is_drawing = false;
  for (std::size_t c = 0; c < view.profile.top_m.size(); ++c) {
    const double top = view.profile.top_m[c];
    if (std::isnan(top)) {
      is_drawing = false;
      continue;
    }
    path += fmt::format("{}{:.2f} {:.2f} ", is_drawing ? "L" : "M",
                        place.column(view.profile.x_m(c)), place.row(top));
    is_drawing = true;
  }
  return path;
}

}  // namespace

std::string audit_svg(const View& view, const ViewAngle& angle, const std::string& title) {
  const Place place{view};
  const double width = view.picture.width, height = view.picture.height;
  const double pen = std::max(width / 500.0, 0.5);
  const double text = std::max(width / 45.0, 8.0), caption = 2.0 * text;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 {:.2f} {} {:.2f}\" width=\"{}\" "
      "font-family=\"sans-serif\" font-size=\"{:.2f}\">\n<title>{}</title>\n"
      "<rect y=\"{:.2f}\" width=\"{}\" height=\"{:.2f}\" fill=\"white\"/>\n",
      -caption, width, height + caption, std::min(view.picture.width, 1200), text, escaped(title),
      -caption, width, height + caption);
  const Picture shown = for_eyes(view.picture);
  // The last block may be cut off: the small picture is as wide as its whole blocks.
  const int block = (view.picture.width + kWidth - 1) / kWidth;
  svg += fmt::format(
      "<image width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" "
      "href=\"data:image/png;base64,{}\"/>\n"
      "<path class=\"edge\" d=\"{}\" fill=\"none\" stroke=\"#d00000\" stroke-width=\"{:.3f}\"/>\n",
      shown.width * block, shown.height * block, base64(png_of(shown)), edge_path(view, place),
      pen);
  svg += fmt::format(
      "<path class=\"floor\" d=\"M0 {0:.2f} H{1}\" stroke=\"#808080\" stroke-width=\"{2:.3f}\" "
      "stroke-dasharray=\"{3:.1f}\"/>\n",
      place.row(angle.floor_m), width, pen, 4.0 * pen);
  for (const FittedLine* line : {&angle.angles.left, &angle.angles.right})
    svg += fmt::format(
        "<path class=\"line\" d=\"M{:.2f} {:.2f} L{:.2f} {:.2f}\" stroke=\"#0040ff\" "
        "stroke-width=\"{:.3f}\"/>\n",
        place.column(line->from_m), place.row(line->intercept_m + line->slope * line->from_m),
        place.column(line->to_m), place.row(line->intercept_m + line->slope * line->to_m),
        2.0 * pen);
  const bool is_one_line = angle.measurement.kpis.count("surface_angle_deg") > 0;
  svg += fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\">{}: {}</text>\n", 0.5 * text, -0.6 * text,
                     escaped(title),
                     is_one_line ? fmt::format("{:.2f}°", angle.angles.left_deg)
                                 : fmt::format("left {:.2f}°, right {:.2f}°", angle.angles.left_deg,
                                               angle.angles.right_deg));
  return svg + "</svg>\n";
}

}  // namespace repose::dem_adapter

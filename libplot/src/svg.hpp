// Writes SVG elements, all of them closed, numbers and text safe.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace repose::plot {

struct Point {
  double x;
  double y;
};

struct Rectangle {
  double left;
  double top;
  double width;
  double height;
  double right() const { return left + width; }
  double bottom() const { return top + height; }
};

/// A pixel coordinate with at most two decimals: "12.5". Far outside it is clamped.
std::string px(double value);

enum class Anchor { start, middle, end };

struct TextStyle {
  double size;
  Anchor anchor = Anchor::start;
  double rotation_deg = 0.0;  ///< clockwise about the anchor
  std::string_view color = {};
  std::string_view weight = {};
};

class SvgWriter {
 public:
  /// Attributes already written as name="value"; everything until end() lies inside.
  void begin(std::string_view tag, std::string_view attributes);
  void end();

  void line(Point from, Point to, std::string_view attributes = {});
  void rectangle(const Rectangle& r, std::string_view attributes = {});
  void circle(Point center, double radius, std::string_view attributes = {});
  void path(std::string_view data, std::string_view attributes = {});
  /// `superscript` is set small and high behind the text.
  void text(Point at, std::string_view text, const TextStyle& style,
            std::string_view superscript = {});
  /// An element that holds only text.
  void element(std::string_view tag, std::string_view text);

  /// The document; every begin() must have had its end().
  std::string finish() &&;

 private:
  void write(std::string_view tag, std::string_view geometry, std::string_view attributes);
  std::string out_;
  std::vector<std::string> open_;
};

}  // namespace repose::plot

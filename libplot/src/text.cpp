#include "text.hpp"

#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cstddef>

namespace repose::plot {
namespace {

/// Helvetica, characters 32 to 126, in thousandths of the font size.
constexpr std::array<int, 95> kWidths = {
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333,  278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667,  611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278,  556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,  500, 334, 260, 334, 584};

constexpr std::array<const char*, 10> kSuperscripts = {"⁰", "¹", "²", "³", "⁴",
                                                       "⁵", "⁶", "⁷", "⁸", "⁹"};

struct CodePoint {
  char32_t value;
  std::size_t bytes;  ///< of the text
};

constexpr char32_t kReplacement = 0xFFFD;

/// The first code point of a text that is not empty; kReplacement for a byte that begins none.
CodePoint first_code_point(std::string_view text) {
  const auto byte = [&](std::size_t i) -> char32_t { return static_cast<unsigned char>(text[i]); };
  const char32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1};
  const std::size_t bytes = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < bytes) return {kReplacement, 1};
  char32_t value = lead & (0xFFu >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return {kReplacement, 1};
    value = (value << 6) | (byte(i) & 0x3F);
  }
  return {value, bytes};
}

/// https://www.w3.org/TR/xml/#NT-Char
bool is_allowed_in_xml(char32_t c) {
  return c == 0x9 || c == 0xA || c == 0xD || (c >= 0x20 && c <= 0xD7FF) ||
         (c >= 0xE000 && c <= 0xFFFD) || (c >= 0x10000 && c <= 0x10FFFF);
}

double relative_width(char32_t c) {
  if (c >= 32 && c <= 126) return kWidths[c - 32] / 1000.0;
  if (c == 0x2212) return 0.584;                // minus
  if (c >= 0x1100 && c < 0x1200) return 1.0;    // Hangul
  if (c >= 0x2E80 && c < 0xFE50) return 1.0;    // Chinese, Japanese, Korean
  if (c >= 0x2070 && c < 0x20A0) return 0.333;  // superscripts
  return 0.6;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    const CodePoint point = first_code_point(text);
    if (point.value == '&')
      result += "&amp;";
    else if (point.value == '<')
      result += "&lt;";
    else if (point.value == '>')
      result += "&gt;";
    else if (point.value == '"')
      result += "&quot;";
    else if ((point.value == kReplacement && point.bytes == 1) || !is_allowed_in_xml(point.value))
      result += "\xEF\xBF\xBD";
    else
      result += text.substr(0, point.bytes);
    text.remove_prefix(point.bytes);
  }
  return result;
}

double text_width(std::string_view text, double font_size_px) {
  double width = 0.0;
  while (!text.empty()) {
    const CodePoint point = first_code_point(text);
    width += relative_width(point.value);
    text.remove_prefix(point.bytes);
  }
  return width * font_size_px;
}

std::string shortened(std::string_view text, double font_size_px, double width_px) {
  if (text_width(text, font_size_px) <= width_px) return std::string(text);
  std::string result;
  while (!text.empty()) {
    const std::string_view next = text.substr(0, first_code_point(text).bytes);
    if (text_width(result + std::string(next) + "…", font_size_px) > width_px) break;
    result += next;
    text.remove_prefix(next.size());
  }
  return result + "…";
}

std::string superscript(int number) {
  std::string result = number < 0 ? "⁻" : "";
  for (const char digit : std::to_string(number < 0 ? -number : number))
    result += kSuperscripts[static_cast<std::size_t>(digit - '0')];
  return result;
}

std::string pretty_unit(std::string_view text) {
  if (text == "deg") return "°";
  std::string unit(text);
  std::erase(unit, '^');
  std::string result;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const auto is_digit = [&](std::size_t k) {
      return k < unit.size() && std::isdigit(static_cast<unsigned char>(unit[k])) != 0;
    };
    const bool after_letter = i > 0 && std::isalpha(static_cast<unsigned char>(unit[i - 1])) != 0;
    const bool is_negative = unit[i] == '-' && is_digit(i + 1);
    if (!after_letter || !(is_digit(i) || is_negative)) {
      result += unit[i];
      continue;
    }
    if (is_negative) ++i;
    result += superscript((is_negative ? -1 : 1) * (unit[i] - '0'));
  }
  return result;
}

std::string pretty_number(std::string_view number) {
  return number.starts_with('-') ? "−" + std::string(number.substr(1)) : std::string(number);
}

std::string axis_title(const Axis& axis, int exponent) {
  const std::string unit = axis.unit == "1" ? "" : pretty_unit(axis.unit);
  if (exponent == 0) return unit.empty() ? axis.label : fmt::format("{} ({})", axis.label, unit);
  return fmt::format("{} (10{}{}{})", axis.label, superscript(exponent), unit.empty() ? "" : " ",
                     unit);
}

}  // namespace repose::plot

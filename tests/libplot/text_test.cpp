// Text in figures: escaping, widths, units.
#include "text.hpp"

#include <gtest/gtest.h>

namespace repose::plot {
namespace {

TEST(PlotText, IsEscapedAndStaysUnicode) {
  EXPECT_EQ(escaped("a<b & \"c\" > d"), "a&lt;b &amp; &quot;c&quot; &gt; d");
  EXPECT_EQ(escaped("안식각 α 𝛼"), "안식각 α 𝛼");
  EXPECT_EQ(escaped(std::string("\x01\x00", 2)), "\xEF\xBF\xBD\xEF\xBF\xBD");
  EXPECT_EQ(escaped("\xff"), "\xEF\xBF\xBD");
  EXPECT_EQ(escaped("a\xe2\x82"), "a\xEF\xBF\xBD\xEF\xBF\xBD");
}

// Adobe font metrics of Helvetica: i 222, W 944 thousandths.
TEST(PlotText, WidthIsThatOfHelvetica) {
  EXPECT_NEAR(text_width("iW", 10.0), 11.66, 1e-12);
  EXPECT_EQ(text_width("", 10.0), 0.0);
  EXPECT_NEAR(text_width("각", 10.0), 10.0, 1e-12);
}

TEST(PlotText, IsShortenedToItsRoom) {
  EXPECT_EQ(shortened("short", 10.0, 100.0), "short");
  const std::string cut = shortened("a rather long name of a parameter", 10.0, 80.0);
  EXPECT_TRUE(cut.starts_with("a rather") && cut.ends_with("…")) << cut;
  EXPECT_LE(text_width(cut, 10.0), 80.0);
  EXPECT_EQ(shortened("word", 10.0, 1.0), "…");
}

TEST(PlotText, UnitsReadAsInPrint) {
  EXPECT_EQ(pretty_unit("kg/m3"), "kg/m³");
  EXPECT_EQ(pretty_unit("kg/m^3"), "kg/m³");
  EXPECT_EQ(pretty_unit("m s-1"), "m s⁻¹");
  EXPECT_EQ(pretty_unit("deg"), "°");
  EXPECT_EQ(pretty_unit("kg/s"), "kg/s");
  EXPECT_EQ(axis_title({.label = "Flow", .unit = "kg/s"}, 0), "Flow (kg/s)");
  EXPECT_EQ(axis_title({.label = "Flow", .unit = "kg/s"}, -3), "Flow (10⁻³ kg/s)");
  EXPECT_EQ(axis_title({.label = "Friction"}, 0), "Friction");
  EXPECT_EQ(axis_title({.label = "Count"}, 12), "Count (10¹²)");
}

}  // namespace
}  // namespace repose::plot

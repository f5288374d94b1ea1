// Figures: every value stands at the pixel that the axes say, and the text is well-formed.
#include "repose/plot/figure.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "repose/base/error.hpp"
#include "xml.hpp"

namespace repose::plot {
namespace {

using Doubles = std::vector<double>;
using Names = std::vector<std::string>;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Coordinates are printed with two decimals; two of them and a tick's may be off by half a unit.
constexpr double kPixelRounding = 0.02;

/// Reads values off a figure as a person would: by its ticks.
class Ruler {
 public:
  Ruler(const Element& figure, const std::string& axis, Scale scale) : scale_(scale) {
    const bool is_x = axis == "x axis";
    std::vector<std::pair<double, double>> ticks;  // pixel, value
    for (const Element& text : figure.of_class(axis).all("text")) {
      if (text.attributes.contains("transform")) continue;  // the title of y
      std::string label = text.text;
      if (label.starts_with("−")) label = "-" + label.substr(std::string("−").size());
      try {
        std::size_t used = 0;
        const double value = std::stod(label, &used);
        if (used != label.size()) continue;
        // The baseline of a label of y lies 0.35 font sizes below its tick.
        const double shift = is_x ? 0.0 : 0.35 * text.number("font-size");
        ticks.emplace_back(text.number(is_x ? "x" : "y") - shift, coordinate(value));
      } catch (const std::invalid_argument&) {  // the title of x
      }
    }
    if (ticks.size() < 2) throw std::runtime_error("fewer than two ticks");
    const auto [p0, v0] = ticks.front();
    const auto [p1, v1] = ticks.back();
    pixels_per_unit_ = (p1 - p0) / (v1 - v0);
    origin_ = p0 - pixels_per_unit_ * v0;
  }
  double pixel(double value) const { return origin_ + pixels_per_unit_ * coordinate(value); }

 private:
  double coordinate(double value) const { return scale_ == Scale::log ? std::log10(value) : value; }
  Scale scale_;
  double origin_ = 0.0;
  double pixels_per_unit_ = 0.0;
};

void expect_points_on(const Element& figure, const Doubles& x, const Doubles& y, Scale scale) {
  const Ruler rx(figure, "x axis", scale);
  const Ruler ry(figure, "y axis", scale);
  const auto circles = figure.of_class("points").all("circle");
  ASSERT_EQ(circles.size(), x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(circles[i].number("cx"), rx.pixel(x[i]), kPixelRounding);
    EXPECT_NEAR(circles[i].number("cy"), ry.pixel(y[i]), kPixelRounding);
  }
}

TEST(Scatter, PointsStandWhereTheTicksSay) {
  const Doubles x = {0.12, 3.4, 7.9, 5.0};
  const Doubles y = {-21.5, 40.25, 3.0, 12.0};
  expect_points_on(read_xml(Figure("t", {.label = "x"}, {.label = "y"}).scatter(x, y).svg()), x, y,
                   Scale::linear);
}

TEST(Scatter, PointsStandWhereTheTicksSayOnLogAxes) {
  const Doubles x = {0.012, 0.34, 7.9, 5.0};
  const Doubles y = {200.0, 1.5, 0.3, 12.0};
  const Axis log{.scale = Scale::log};
  expect_points_on(read_xml(Figure("t", log, log).scatter(x, y).svg()), x, y, Scale::log);
}

TEST(Scatter, SkipsWhatCannotBeShown) {
  const Doubles x = {1, 2, kNaN, 4, 5};
  const Doubles y = {1, kNaN, 3, kInfinity, 5};
  const auto figure = read_xml(Figure("t", {}, {}).scatter(x, y).svg());
  EXPECT_EQ(figure.of_class("points").all("circle").size(), 2u);
  const auto log = read_xml(Figure("t", {.scale = Scale::log}, {})
                                .scatter(Doubles{-1, 0, 1, 2}, Doubles{1, 1, 1, 1})
                                .svg());
  EXPECT_EQ(log.of_class("points").all("circle").size(), 2u);
  const auto limited = read_xml(Figure("t", {.lower = 0.0, .upper = 3.0}, {})
                                    .scatter(Doubles{-1, 1, 2, 4}, Doubles{1, 2, 3, 4})
                                    .svg());
  EXPECT_EQ(limited.of_class("points").all("circle").size(), 2u);
}

TEST(Scatter, DrawsCoincidentPointsOnce) {
  const Doubles same(5000, 1.0);
  const auto figure = read_xml(Figure("t", {}, {}).scatter(same, same).svg());
  EXPECT_EQ(figure.of_class("points").all("circle").size(), 1u);
}

TEST(Scatter, ErrorBarsReachToTheirEnds) {
  const auto figure = read_xml(Figure("t", {}, {})
                                   .scatter(Doubles{1, 2}, Doubles{10, 20}, "",
                                            {.x = Doubles{0.5, kNaN}, .y = Doubles{4, 2}})
                                   .svg());
  const Ruler rx(figure, "x axis", Scale::linear);
  const Ruler ry(figure, "y axis", Scale::linear);
  const auto lines = figure.of_class("errors").all("line");
  ASSERT_EQ(lines.size(), 4u * 3u);  // two ends with a cap each, three error bars
  EXPECT_NEAR(lines[0].number("y2"), ry.pixel(6.0), kPixelRounding);
  EXPECT_NEAR(lines[2].number("y2"), ry.pixel(14.0), kPixelRounding);
  EXPECT_NEAR(lines[4].number("x2"), rx.pixel(0.5), kPixelRounding);
}

TEST(Lines, HaveGapsWhereValuesAreMissing) {
  const auto figure =
      read_xml(Figure("t", {}, {}).lines(Doubles{0, 1, 2, 3, 4}, Doubles{0, 1, kNaN, 3, 4}).svg());
  EXPECT_EQ(figure.of_class("curve").all("path").size(), 2u);
}

TEST(Lines, PassThroughTheirPoints) {
  const auto figure = read_xml(Figure("t", {}, {}).lines(Doubles{0, 2.5}, Doubles{1, -3}).svg());
  const Ruler rx(figure, "x axis", Scale::linear);
  const Ruler ry(figure, "y axis", Scale::linear);
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  const std::string d = figure.of_class("curve").all("path").at(0).attributes.at("d");
  ASSERT_EQ(std::sscanf(d.c_str(), "M%lf %lfL%lf %lf", &x0, &y0, &x1, &y1), 4) << d;
  EXPECT_NEAR(x0, rx.pixel(0.0), kPixelRounding);
  EXPECT_NEAR(y0, ry.pixel(1.0), kPixelRounding);
  EXPECT_NEAR(x1, rx.pixel(2.5), kPixelRounding);
  EXPECT_NEAR(y1, ry.pixel(-3.0), kPixelRounding);
}

TEST(BarChart, BarsReachFromZeroToTheirValueAndStandSideBySide) {
  const Names names = {"a", "b", "c"};
  const auto figure = read_xml(Figure("t", {}, {})
                                   .bars(names, Doubles{3, -1, kNaN}, "one")
                                   .bars(names, Doubles{2, 2, 2}, "two", Doubles{0.5, 0.5, 0.5})
                                   .svg());
  const Ruler y(figure, "y axis", Scale::linear);
  std::vector<Element> groups;
  for (const Element& g : figure.all("g"))
    if (g.has_class("bars")) groups.push_back(g);
  ASSERT_EQ(groups.size(), 2u);
  const auto one = groups[0].all("rect");
  const auto two = groups[1].all("rect");
  ASSERT_EQ(one.size(), 2u);
  ASSERT_EQ(two.size(), 3u);
  EXPECT_NEAR(one[0].number("y"), y.pixel(3.0), kPixelRounding);
  EXPECT_NEAR(one[0].number("height"), y.pixel(0.0) - y.pixel(3.0), kPixelRounding);
  EXPECT_NEAR(one[1].number("y"), y.pixel(0.0), kPixelRounding);
  EXPECT_NEAR(one[1].number("height"), y.pixel(-1.0) - y.pixel(0.0), kPixelRounding);
  EXPECT_NEAR(one[0].number("x") + one[0].number("width"), two[0].number("x"), kPixelRounding);
  EXPECT_NEAR(figure.of_class("errors").all("line").at(0).number("y2"), y.pixel(1.5),
              kPixelRounding);
}

TEST(BarChart, HorizontalBarsBeginOnTop) {
  const auto figure = read_xml(Figure("t", {.label = "value"}, {})
                                   .horizontal_bars({"first", "second"}, Doubles{4, 2})
                                   .svg());
  const Ruler x(figure, "x axis", Scale::linear);
  const auto bars = figure.of_class("bars").all("rect");
  EXPECT_LT(bars.at(0).number("y"), bars.at(1).number("y"));
  EXPECT_NEAR(bars[0].number("width"), x.pixel(4.0) - x.pixel(0.0), kPixelRounding);
}

TEST(BarChart, NamesThatDoNotFitAreSlanted) {
  const auto slanted = [](const Names& names) {
    const auto figure = read_xml(Figure("t", {}, {}).bars(names, Doubles(names.size(), 1.0)).svg());
    return figure.of_class("x axis").all("text").at(0).attributes.contains("transform");
  };
  EXPECT_FALSE(slanted({"a", "b"}));
  EXPECT_TRUE(slanted(Names(8, "a name of some length")));
}

// Quartiles of 1..8 and 20 by linear interpolation are 3, 5 and 7; whiskers may reach to 13.
TEST(BoxPlot, ShowsQuartilesWhiskersAndOutliers) {
  const auto figure =
      read_xml(Figure("t", {}, {}).box({"a", "none"}, {{8, 2, 3, 1, 5, 4, 20, 6, 7}, {}}).svg());
  const Ruler y(figure, "y axis", Scale::linear);
  const Element boxes = figure.of_class("boxes");
  const auto box = boxes.all("rect");
  ASSERT_EQ(box.size(), 1u);
  EXPECT_NEAR(box[0].number("y"), y.pixel(7.0), kPixelRounding);
  EXPECT_NEAR(box[0].number("y") + box[0].number("height"), y.pixel(3.0), kPixelRounding);
  const auto lines = boxes.all("line");
  ASSERT_EQ(lines.size(), 5u);  // two whiskers with caps, the median
  EXPECT_NEAR(lines[0].number("y2"), y.pixel(1.0), kPixelRounding);
  EXPECT_NEAR(lines[2].number("y2"), y.pixel(8.0), kPixelRounding);
  EXPECT_NEAR(lines[4].number("y1"), y.pixel(5.0), kPixelRounding);
  const auto outliers = boxes.all("circle");
  ASSERT_EQ(outliers.size(), 1u);
  EXPECT_NEAR(outliers[0].number("cy"), y.pixel(20.0), kPixelRounding);
}

TEST(HeatMap, CellsLieBetweenTheirEdgesWithTheColoursOfViridis) {
  Matrix values(2, 2);
  values << 0.0, 1.0, 0.5, kNaN;
  const auto figure = read_xml(
      Figure("t", {}, {})
          .heat_map(Doubles{0, 1, 4}, Doubles{10, 20, 40}, values, {.label = "z", .unit = "Pa"})
          .svg());
  const Ruler x(figure, "x axis", Scale::linear);
  const Ruler y(figure, "y axis", Scale::linear);
  const auto cells = figure.of_class("heatmap").all("rect");
  ASSERT_EQ(cells.size(), 4u);
  EXPECT_EQ(cells[0].attributes.at("fill"), "#440154");  // viridis at 0
  EXPECT_EQ(cells[1].attributes.at("fill"), "#fde725");  // and at 1
  EXPECT_EQ(cells[2].attributes.at("fill"), "#21918c");  // and halfway
  EXPECT_NEAR(cells[1].number("x"), x.pixel(1.0), kPixelRounding);
  EXPECT_NEAR(cells[1].number("width"), x.pixel(4.0) - x.pixel(1.0), kPixelRounding);
  EXPECT_NEAR(cells[2].number("y"), y.pixel(40.0), kPixelRounding);
  EXPECT_NE(figure.text.find("z (Pa)"), std::string::npos);
}

TEST(HeatMap, OfCategoriesShowsItsValuesFirstRowOnTop) {
  Matrix values(2, 2);
  values << 1.0, -0.25, -0.25, 1.0;
  const auto figure =
      read_xml(Figure("t", {}, {})
                   .heat_map({"a", "b"}, {"a", "b"}, values, {}, ColorScale::diverging)
                   .svg());
  const auto cells = figure.of_class("heatmap").all("rect");
  EXPECT_LT(cells.at(0).number("y"), cells.at(2).number("y"));
  EXPECT_EQ(cells[0].attributes.at("fill"), "#d55e00");
  EXPECT_NE(figure.text.find("−0.25"), std::string::npos);
}

TEST(Reference, LinesAndBandsStandAtTheirValuesAndWidenTheAxis) {
  const auto figure = read_xml(Figure("t", {}, {})
                                   .scatter(Doubles{1, 2}, Doubles{1, 2})
                                   .band(28, 30, "target")
                                   .horizontal_line(15.0)
                                   .svg());
  const Ruler y(figure, "y axis", Scale::linear);
  const Element band = figure.of_class("band");
  EXPECT_NEAR(band.number("y"), y.pixel(30.0), kPixelRounding);
  EXPECT_NEAR(band.number("height"), y.pixel(28.0) - y.pixel(30.0), kPixelRounding);
  EXPECT_NEAR(figure.of_class("rule").number("y1"), y.pixel(15.0), kPixelRounding);
}

TEST(Reference, DiagonalGivesBothAxesTheSameLimits) {
  const auto figure =
      read_xml(Figure("t", {}, {}).scatter(Doubles{1, 2}, Doubles{-5, 9}).diagonal("1:1").svg());
  const auto labels = [&](const std::string& axis) {
    return std::pair(figure.of_class(axis).all("text").front().text,
                     figure.of_class(axis).all("text").back().text);
  };
  EXPECT_EQ(labels("x axis"), labels("y axis"));
}

TEST(Legend, NamesEachSeriesOnceInTheColourOfTheSeries) {
  const Doubles v = {1, 2};
  const auto figure = read_xml(Figure("t", {}, {})
                                   .ribbon(v, v, Doubles{2, 3}, "GP")
                                   .lines(v, v, "GP")
                                   .scatter(v, v, "runs")
                                   .scatter(v, v)
                                   .svg());
  const auto labels = figure.of_class("legend").all("text");
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0].text, "GP");
  EXPECT_EQ(labels[1].text, "runs");
  EXPECT_EQ(figure.of_class("ribbon").attributes.at("fill"),
            figure.of_class("curve").attributes.at("stroke"));
  EXPECT_NE(figure.of_class("points").attributes.at("fill"),
            figure.of_class("curve").attributes.at("stroke"));
}

TEST(Figure, EscapesAllText) {
  const std::string evil = "</text><script>\"&'\x01";
  const Figure figure = std::move(Figure(evil, {.label = evil, .unit = evil}, {.label = evil})
                                      .bars({evil}, Doubles{1}, evil)
                                      .band(0, 1, evil)
                                      .note(evil));
  const std::string svg = figure.svg();
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_EQ(read_xml(svg).all("title").at(0).text, "</text><script>\"&'\xEF\xBF\xBD");
}

TEST(Figure, IsTheSameTextEveryTimeAndHoldsNoIds) {
  const auto make = [] {
    return Figure("t", {}, {}).lines(Doubles{0, 1}, Doubles{0, 1}, "l").band(0, 1).svg();
  };
  EXPECT_EQ(make(), make());
  EXPECT_EQ(make().find(" id="), std::string::npos);  // ids of two figures in a page would clash
}

TEST(Figure, IsWellFormedForDegenerateData) {
  const Doubles one = {28.0};
  const Doubles none;
  const Doubles extreme = {-std::numeric_limits<double>::max(), 5e-324, kNaN,
                           std::numeric_limits<double>::max()};
  const Matrix equal = Matrix::Constant(2, 2, 7.0);
  const Matrix missing = Matrix::Constant(1, 1, kNaN);
  const std::vector<std::function<void(Figure&)>> contents = {
      [](Figure&) {},
      [&](Figure& f) { f.scatter(none, none, "nothing"); },
      [&](Figure& f) { f.scatter(one, one); },
      [&](Figure& f) { f.lines(one, one); },
      [&](Figure& f) { f.lines(extreme, extreme).scatter(extreme, extreme); },
      [&](Figure& f) { f.ribbon(one, one, one); },
      [&](Figure& f) { f.bars({"a"}, Doubles{0.0}); },
      [&](Figure& f) { f.bars({"a"}, Doubles{kNaN}, "", Doubles{kNaN}); },
      [&](Figure& f) {
        f.box({"a", "b"}, {{}, {1.0}});
      },
      [&](Figure& f) {
        f.heat_map(Doubles{0, 1, 2}, Doubles{0, 1, 2}, equal, {});
      },
      [&](Figure& f) { f.heat_map({"a"}, {"b"}, missing, {}); },
      [&](Figure& f) { f.band(1.0, 1.0).diagonal(); },
  };
  for (std::size_t i = 0; i < contents.size(); ++i)
    for (const Size size : {Size{}, Size{160, 120}}) {
      Figure figure("t", {.label = "x"}, {.label = "y"}, size);
      contents[i](figure);
      const std::string svg = figure.svg();
      EXPECT_NO_THROW(read_xml(svg)) << "content " << i;
      EXPECT_EQ(svg.find("nan"), std::string::npos) << "content " << i;
      EXPECT_EQ(svg.find("inf"), std::string::npos) << "content " << i;
    }
}

TEST(Figure, RefusesWhatDoesNotFitTogether) {
  Figure figure("t", {}, {});
  const Doubles one = {1};
  const Doubles two = {1, 2};
  EXPECT_THROW(figure.scatter(one, two), InputError);
  EXPECT_THROW(figure.scatter(two, two, "", {.y = one}), InputError);
  EXPECT_THROW(figure.ribbon(two, two, one), InputError);
  EXPECT_THROW(figure.bars({"a"}, two), InputError);
  EXPECT_THROW(figure.bars({}, Doubles{}), InputError);
  EXPECT_THROW(figure.heat_map(two, two, Matrix::Zero(2, 1), {}), InputError);
  EXPECT_THROW(figure.heat_map(Doubles{2, 1}, two, Matrix::Zero(1, 1), {}), InputError);
  EXPECT_THROW(
      figure.heat_map(two, two, Matrix::Zero(1, 1), {.scale = Scale::log}, ColorScale::diverging),
      InputError);
  EXPECT_THROW(figure.band(2, 1), InputError);
  EXPECT_THROW(figure.horizontal_line(kNaN), InputError);
  EXPECT_THROW(Figure("t", {.scale = Scale::log}, {}).diagonal(), InputError);
  EXPECT_THROW(Figure("t", {}, {}, {100, 100}), InputError);
  figure.scatter(two, two);
  EXPECT_THROW(figure.bars({"a"}, one), InputError);
  Figure bars("t", {}, {});
  bars.bars({"a"}, one);
  EXPECT_THROW(bars.bars({"b"}, one), InputError);
  EXPECT_THROW(bars.lines(two, two), InputError);
  EXPECT_THROW(bars.horizontal_bars({"a"}, one), InputError);
}

}  // namespace
}  // namespace repose::plot

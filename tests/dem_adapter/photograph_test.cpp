// Photographs of drawn heaps whose angles are known: whole method, from pixels to degrees.
#include <gtest/gtest.h>

#include <cmath>

#include "drawn_picture.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/dem_adapter/view.hpp"
#include "repose/dem_adapter/view_angle.hpp"

namespace repose::dem_adapter {
namespace {

using test::Cone;
using test::drawn;

constexpr Rgb kSky{40, 90, 160}, kSand{200, 170, 120}, kPellet{110, 60, 50}, kSinter{190, 190, 190};

Picture photograph(const Cone& cone, int width, int height, Rgb sky = kSky, Rgb sand = kSand) {
  return drawn(
      width, height, sky, [&](double, double) { return sand; },
      [&](double x, double y) { return cone.has(x, y); });
}

double angle_deg(const Picture& picture, const Segmentation& segmentation = {},
                 const EdgeOptions& options = {}) {
  return measure_angle(view_of_photograph(picture, segmentation), options)
      .measurement.kpis.at("angle_of_repose_deg");
}

std::string refusal(const Picture& picture, const Segmentation& segmentation = {},
                    const EdgeOptions& options = {}) {
  try {
    angle_deg(picture, segmentation, options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Photograph, OfADrawnConeGivesItsAngleToATenthOfADegree) {
  // The edge is known to a tenth of a pixel, periodically along the slope; over n >= 80 columns a
  // line through such errors turns by less than 0.1 sqrt(12) / 80 = 0.004, or 0.25 degrees, if they
  // all conspired; being periodic they stay well below the tenth that is promised.
  for (const int width : {200, 600, 1500})
    for (const double angle : {8.0, 22.5, 29.5, 38.0, 45.0, 60.0}) {
      const double height = std::min(0.45 * width * std::tan(angle * M_PI / 180.0), 2.0 * width);
      const int rows = static_cast<int>(1.25 * height) + 20;
      const Cone cone{0.503 * width, rows - 5 - height, rows - 5.0, angle, angle};
      const auto picture = photograph(cone, width, rows);
      EXPECT_NEAR(angle_deg(picture), angle, 0.1) << width;
      EXPECT_NEAR(angle_deg(picture, {}, {.fit = LineFit::least_squares}), angle, 0.1) << width;
    }
}

TEST(Photograph, TellsTheSidesOfALopsidedConeApart) {
  const auto picture = photograph({290.0, 60.0, 250.0, 35.0, 42.0}, 600, 270);
  const auto found = measure_angle(view_of_photograph(picture, {}), {.axis_m = 290.0});
  EXPECT_NEAR(found.angles.left_deg, 35.0, 0.1);
  EXPECT_NEAR(found.angles.right_deg, 42.0, 0.1);
  EXPECT_NEAR(found.measurement.kpis.at("angle_of_repose_deg"), 38.5, 0.1);
}

TEST(Photograph, OfATiltedCameraIsPutRightByTwoPointsOfTheFloor) {
  const Cone cone{290.0, 60.0, 250.0, 35.0, 42.0};
  for (const double tilt : {-4.0, 2.5}) {
    const double c = std::cos(tilt * M_PI / 180.0), s = std::sin(tilt * M_PI / 180.0);
    // The camera sees the place (x, y) of the cone at this place of the picture, about its middle.
    const auto seen = [&](double x, double y) {
      return PixelPoint{300.0 + c * (x - 300.0) - s * (y - 150.0),
                        150.0 + s * (x - 300.0) + c * (y - 150.0)};
    };
    const auto tilted = drawn(
        600, 300, kSky, [](double, double) { return kSand; },
        [&](double x, double y) {
          return cone.has(300.0 + c * (x - 300.0) + s * (y - 150.0),
                          150.0 - s * (x - 300.0) + c * (y - 150.0));
        });
    const double found = tilt_deg(seen(60.0, 250.0), seen(540.0, 250.0));
    EXPECT_NEAR(found, tilt, 1e-9);
    const auto level =
        measure_angle(view_of_photograph(leveled(tilted, found), {}), {.axis_m = 290.0});
    EXPECT_NEAR(level.angles.left_deg, 35.0, 0.1) << tilt;
    EXPECT_NEAR(level.angles.right_deg, 42.0, 0.1) << tilt;
    const auto crooked = measure_angle(view_of_photograph(tilted, {}), {.axis_m = 290.0});
    EXPECT_NEAR(crooked.angles.left_deg, 35.0 - tilt, 0.5) << tilt;  // its foot is elsewhere
  }
}

TEST(Photograph, KeepsTheAngleUnderNoiseSpecksAndGrainsInTheAir) {
  for (const double angle : {25.0, 33.0}) {
    auto picture = photograph({310.0, 80.0, 290.0, angle, angle}, 620, 300);
    RandomStream random(2);
    for (int grain = 0; grain < 25; ++grain) {  // some hang free, some touch the edge
      const double x = random.uniform(20.0, 600.0), y = random.uniform(20.0, 250.0);
      for (int dy = -4; dy <= 4; ++dy)
        for (int dx = -4; dx <= 4; ++dx)
          if (dx * dx + dy * dy <= 16 && y < 284.0)
            picture.at(static_cast<int>(x) + dx, static_cast<int>(y) + dy) = kSand;
    }
    test::add_noise(picture, 20.0, 1500, 11);
    EXPECT_NEAR(angle_deg(picture), angle, 0.1);
  }
}

TEST(Photograph, GivesLengthsInItsScaleOrInPixels) {
  const auto picture = photograph({300.0, 100.0, 290.0, 35.0, 35.0}, 600, 300);
  const auto pixels = measure_angle(view_of_photograph(picture, {}), {}).measurement;
  const auto metres =
      measure_angle(view_of_photograph(picture, {}, 0.0005, 100, 50), {}).measurement;
  EXPECT_NEAR(pixels.kpis.at("angle_of_repose_deg"), metres.kpis.at("angle_of_repose_deg"), 1e-9);
  EXPECT_NEAR(pixels.details.at("heap_height_px"), 190.0, 1.5);  // the median rounds the tip off
  EXPECT_NEAR(metres.details.at("heap_height_m"), 0.095, 0.0008);
  // The foot is cut at 2 % of the height.
  EXPECT_NEAR(pixels.details.at("heap_half_base_px"), 0.98 * 190.0 / std::tan(35.0 * M_PI / 180),
              2.0);
}

TEST(Photograph, MeasuresTheSlopesBesideAnOutlet) {
  const double slope = std::tan(40.0 * M_PI / 180.0);
  const auto picture = drawn(
      500, 220, kSky, [](double, double) { return kSand; },
      [&](double x, double y) {
        const double rise = x < 200.0   ? (200.0 - x) * slope
                            : x > 300.0 ? (x - 300.0) * slope
                                        : -1.0;
        return 220.0 - y < rise;
      });
  const auto found =
      measure_angle(view_of_photograph(picture, {}),
                    {.shape = EdgeShape::slopes, .outlet_m = std::pair(200.0, 300.0)});
  EXPECT_NEAR(found.measurement.kpis.at("shear_angle_deg"), 40.0, 0.1);
  EXPECT_NE(refusal(picture, {}, {.shape = EdgeShape::slopes}).find("outlet"), std::string::npos);
}

TEST(Photograph, TakesTheBackgroundAsColourOrAsAPictureOfTheEmptyRig) {
  // A background as bright as the heap on one side: only the picture of the empty rig helps.
  const Cone cone{300.0, 100.0, 290.0, 32.0, 32.0};
  Picture empty(600, 300);
  for (int row = 0; row < 300; ++row)
    for (int column = 0; column < 600; ++column) {
      const auto level = static_cast<std::uint8_t>(20 + column / 4);
      empty.at(column, row) = {level, level, level};
    }
  Picture full = photograph(cone, 600, 300);
  for (std::size_t i = 0; i < full.pixels.size(); ++i)
    if (full.pixels[i] == kSky) full.pixels[i] = empty.pixels[i];
  EXPECT_NEAR(angle_deg(full, {.background = empty}), 32.0, 0.2);  // its rim is not smooth
  const auto plain = photograph(cone, 600, 300);
  EXPECT_NEAR(angle_deg(plain, {.background = kSky}), 32.0, 0.1);
  EXPECT_NEAR(angle_deg(plain, {.background = kSky, .threshold = 30.0}), 32.0, 0.1);
  EXPECT_NE(refusal(plain, {.background = Picture(20, 20)}).find("600 x 300"), std::string::npos);
}

TEST(Photograph, TellsComponentsApartInLab) {
  const Cone cone{300.0, 60.0, 290.0, 38.0, 38.0};
  auto picture = drawn(
      600, 300, kSky, [](double x, double) { return x < 300.0 ? kPellet : kSinter; },
      [&](double x, double y) { return cone.has(x, y); });
  test::add_noise(picture, 8.0, 0, 5);
  const Segmentation by_color{.components = {{"pellet", kPellet}, {"sinter", kSinter}}};
  const View view = view_of_photograph(picture, by_color);
  EXPECT_EQ(view.components, (std::vector<std::string>{"pellet", "sinter"}));
  int wrong = 0, seen = 0;
  for (int row = 0; row < 300; ++row)
    for (int column = 0; column < 600; ++column) {
      const bool near_a_border = std::abs(column - 300) < 2 || !cone.has(column - 3.0, row) ||
                                 !cone.has(column + 4.0, row) || !cone.has(column, row - 3.0);
      if (near_a_border) continue;
      ++seen;
      wrong += view.label[picture.index(column, row)] != (column < 300 ? 0 : 1) ? 1 : 0;
    }
  EXPECT_GT(seen, 40000);
  EXPECT_EQ(wrong, 0);
  EXPECT_NEAR(angle_deg(picture, by_color), 38.0, 0.1);
}

TEST(Photograph, SaysWhatIsWrong) {
  EXPECT_NE(refusal(Picture(200, 100, kSky)).find("nothing in the picture exceeds"),
            std::string::npos);
  auto dull =
      photograph({100.0, 20.0, 95.0, 40.0, 40.0}, 200, 100, {100, 100, 100}, {103, 103, 103});
  EXPECT_NE(refusal(dull).find("no heap stands out"), std::string::npos) << refusal(dull);
  const auto good = photograph({100.0, 20.0, 95.0, 40.0, 40.0}, 200, 100);
  EXPECT_NE(refusal(good, {}, {.axis_m = 900.0}).find("axis = 900 px lies outside"),
            std::string::npos);
  EXPECT_NE(refusal(good, {}, {.toe_m = 90.0}).find("toe = 90 px"), std::string::npos);
  EXPECT_NE(refusal(good, {}, {.axis_m = 12.0}).find("0 usable columns"), std::string::npos)
      << refusal(good, {}, {.axis_m = 12.0});
  EXPECT_NE(refusal(good, {}, {.from = 0.5, .to = 0.4}).find("increasing"), std::string::npos);
  const auto cut = photograph({100.0, -20.0, 95.0, 45.0, 45.0}, 200, 100);
  const View view = view_of_photograph(cut, {.background = kSky});
  ASSERT_EQ(view.warnings.size(), 1U);
  EXPECT_NE(view.warnings[0].find("columns reach the picture's upper edge"), std::string::npos);
}

TEST(Photograph, RefusesWhatItsShapeDoesNotHaveAndPlacesThatMakeNoSense) {
  const auto good = photograph({100.0, 20.0, 95.0, 40.0, 40.0}, 200, 100);
  const auto floor = [&](double z) { return refusal(good, {}, {.floor_m = z}); };
  EXPECT_NE(floor(-5000.0).find("z = -5000 px lies outside the view, which reaches from -100 to 0"),
            std::string::npos)
      << floor(-5000.0);
  EXPECT_NE(floor(1.0).find("lies outside"), std::string::npos);
  EXPECT_EQ(floor(-95.0), "accepted");
  EXPECT_EQ(floor(-150.0), "accepted");  // cropped above the floor
  const std::pair<double, double> outlet{80.0, 120.0};
  EXPECT_NE(refusal(good, {}, {.outlet_m = outlet}).find("outlet has no meaning for a heap"),
            std::string::npos);
  const auto slopes = [&](EdgeOptions options) {
    options.shape = EdgeShape::slopes;
    if (!options.outlet_m) options.outlet_m = outlet;
    return refusal(good, {}, options);
  };
  EXPECT_NE(slopes({.axis_m = 100.0}).find("axis has no meaning for slopes"), std::string::npos);
  EXPECT_NE(slopes({.toe_m = 2.0}).find("toe has no meaning"), std::string::npos);
  EXPECT_NE(slopes({.from = 0.1}).find("part of the height"), std::string::npos);
  EXPECT_NE(slopes({.to = 0.9}).find("part of the height"), std::string::npos);
  EXPECT_NE(slopes({.outlet_m = std::pair(120.0, 80.0)}).find("must lie left of its right end"),
            std::string::npos);
}

TEST(Otsu, SplitsTwoValuesInTheMiddleAndMatchesTheTwin) {
  const std::vector<float> two{0.0F, 0.0F, 0.0F, 100.0F, 100.0F};
  EXPECT_NEAR(otsu_threshold(two), 50.0, 0.4);  // a bin
  EXPECT_EQ(otsu_threshold(std::vector<float>{0.0F, 0.0F}), 0.0);
  // The slow twin: the variance between the classes for every threshold, from its definition.
  RandomStream random(12);
  std::vector<float> values{256.0F};
  for (int i = 0; i < 3000; ++i)
    values.push_back(static_cast<float>(std::clamp(
        i % 3 == 0 ? 180.0 + 20.0 * random.normal() : 60.0 + 25.0 * random.normal(), 0.0, 255.0)));
  double best = -1.0, threshold = 0.0;
  for (int t = 1; t < 256; ++t) {
    double n[2] = {0, 0}, sum[2] = {0, 0};
    for (const float v : values) {
      const int side = v < static_cast<float>(t) ? 0 : 1;
      n[side] += 1.0;
      sum[side] += std::floor(static_cast<double>(std::min(v, 255.0F)));
    }
    if (n[0] == 0.0 || n[1] == 0.0) continue;
    const double between = n[0] * n[1] * std::pow(sum[0] / n[0] - sum[1] / n[1], 2);
    if (between > best) {
      best = between;
      threshold = t;
    }
  }
  EXPECT_NEAR(otsu_threshold(values), threshold, 1e-9);
}

TEST(Audit, ShowsThePictureTheEdgeAndBothLines) {
  const auto picture = photograph({100.0, 20.0, 95.0, 40.0, 40.0}, 200, 100);
  const View view = view_of_photograph(picture, {});
  const auto svg = audit_svg(view, measure_angle(view, {}), "a <heap>.png");
  const auto count = [&](const std::string& what) {
    std::size_t n = 0;
    for (auto at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("class=\"line\""), 2U);
  EXPECT_EQ(count("class=\"edge\""), 1U);
  EXPECT_EQ(count("data:image/png;base64,iVBORw0KGgo"), 1U);  // the signature of PNG
  EXPECT_EQ(count("a &lt;heap>.png"), 2U);
  EXPECT_NE(svg.find("left 40.0"), std::string::npos);
}

TEST(Audit, OfALargePhotographIsASmallFile) {
  auto picture = photograph({2400.0, 60.0, 700.0, 15.0, 15.0}, 4800, 720);
  test::add_noise(picture, 10.0, 0, 1);  // noise does not compress
  const View view = view_of_photograph(picture, {});
  const auto svg = audit_svg(view, measure_angle(view, {}), "large");
  EXPECT_GT(png_of(picture).size(), 6'000'000U);
  EXPECT_LT(svg.size(),
            2'000'000U);  // 1600 x 240 pixels of at most 3 bytes, 4/3 in base 64, and text
  EXPECT_NE(svg.find("<image width=\"4800\" height=\"720\""), std::string::npos);
}

}  // namespace
}  // namespace repose::dem_adapter

// Lines and angles of edges whose answer is known.
#include "repose/dem_adapter/edge_angle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "repose/base/random.hpp"

namespace repose::dem_adapter {
namespace {

double tangent(double angle_deg) {
  return std::tan(angle_deg * std::numbers::pi / 180.0);
}

/// A heap around x = 0.3 on z = 0.1 with the angles given, 0.4 m wide on each side, in columns of 1
/// mm from 0 to 0.8 m; the floor is seen where there is no heap.
Profile heap_profile(double left_deg, double right_deg, double height = 0.05) {
  Profile profile{.first_x_m = 0.0005, .column_m = 0.001, .top_m = {}};
  for (std::size_t c = 0; c < 800; ++c) {
    const double d = profile.x_m(c) - 0.3;
    profile.top_m.push_back(
        0.1 + std::max(height - std::abs(d) * tangent(d < 0 ? left_deg : right_deg), 0.0));
  }
  return profile;
}

TEST(FittedLine, FindsTheAngleOfAStraightEdgeExactly) {
  Profile profile{.first_x_m = 0.0005, .column_m = 0.001, .top_m = {}};
  const double slope = std::tan(31.0 * std::numbers::pi / 180.0);
  for (int c = 0; c < 100; ++c)
    profile.top_m.push_back(0.2 - slope * profile.x_m(static_cast<std::size_t>(c)));
  profile.top_m[10] = std::nan("");  // an empty column is skipped
  const auto line = fit_line(profile, 0.0, 0.1);
  EXPECT_NEAR(line.angle_deg(), 31.0, 1e-11);
  EXPECT_LT(line.slope, 0.0);
  EXPECT_NEAR(line.intercept_m, 0.2, 1e-14);
  EXPECT_EQ(line.points, 99);
}

TEST(FittedLine, OfTooFewColumnsIsUndefined) {
  const Profile profile{.first_x_m = 0.0, .column_m = 1.0, .top_m = {1.0, std::nan("")}};
  EXPECT_TRUE(std::isnan(fit_line(profile, -1.0, 5.0).slope));
}

TEST(FittedLine, OfATriangleOfEqualSpheresIsSixtyDegrees) {
  // Rows of a hexagonal heap: the edge bulges between centres, but periodically along the slope, so
  // the fitted angle differs from 60 degrees only by its ends: less than one sphere over forty.
  constexpr int kRows = 40;
  constexpr double r = 0.005;
  std::vector<Disc> discs;
  for (int row = 0; row < kRows; ++row)
    for (int i = 0; i < kRows - row; ++i)
      discs.push_back({r * (2.0 * i + row), r * (1.0 + std::sqrt(3.0) * row), r});
  const double peak = r * (kRows - 1);
  const auto profile = silhouette(discs, -r, 2.0 * peak + r, 0.0005);
  EXPECT_NEAR(fit_line(profile, -r, peak).angle_deg(), 60.0, 1.0);
  EXPECT_NEAR(fit_line(profile, peak, 2.0 * peak + r).angle_deg(), 60.0, 1.0);
}

TEST(FittedLine, RobustIsLeastSquaresWhereNothingIsOutlying) {
  RandomStream random(4);
  Profile profile{.first_x_m = 0.0, .column_m = 0.001, .top_m = {}};
  for (std::size_t c = 0; c < 300; ++c)
    profile.top_m.push_back(0.4 * profile.x_m(c) + random.uniform(-0.002, 0.002));
  const auto plain = fit_line(profile, 0.0, 1.0),
             robust = fit_line(profile, 0.0, 1.0, LineFit::robust);
  EXPECT_EQ(robust.outliers, 0);
  EXPECT_EQ(robust.slope, plain.slope);
  EXPECT_EQ(robust.intercept_m, plain.intercept_m);
}

TEST(FittedLine, RobustLeavesOutAQuarterOfOutliersOnOneSideOnly) {
  // The worst case for a line: all outliers at one end and above it.
  Profile profile{.first_x_m = 0.0, .column_m = 0.001, .top_m = {}};
  RandomStream random(6);
  for (std::size_t c = 0; c < 400; ++c)
    profile.top_m.push_back(0.5 * profile.x_m(c) + 1e-4 * random.normal() +
                            (c >= 310 ? random.uniform(0.01, 0.05) : 0.0));
  const auto line = fit_line(profile, 0.0, 1.0, LineFit::robust);
  EXPECT_GE(line.outliers, 90);
  EXPECT_LE(line.outliers, 92);  // and of 310 normal errors 0.02 beyond four deviations
  // Standard error of the slope: 1e-4 / (0.31 / sqrt(12) * sqrt(310)) = 6.3e-5; five of them.
  EXPECT_NEAR(line.slope, 0.5, 3.2e-4);
  EXPECT_GT(std::abs(fit_line(profile, 0.0, 1.0).slope - 0.5), 0.02);
}

TEST(HeapAngles, AreThoseOfAHeapOfStraightSides) {
  for (const double left : {5.0, 28.0, 45.0})
    for (const double right : {5.0, 33.0, 60.0}) {
      const auto heap =
          heap_angles(heap_profile(left, right), {.axis_m = 0.3, .floor_m = 0.1, .toe_m = 0.005});
      EXPECT_NEAR(heap.left_deg, left, 1e-9);
      EXPECT_NEAR(heap.right_deg, right, 1e-9);
      EXPECT_NEAR(heap.mean_deg(), 0.5 * (left + right), 1e-9);
      EXPECT_NEAR(heap.height_m, 0.05, 0.0005 * tangent(std::max(left, right)));
      EXPECT_NEAR(heap.right_end_m, std::min(0.045 / tangent(right), 0.5), 0.001);
    }
}

TEST(HeapAngles, UseThePartOfTheHeightThatIsAskedFor) {
  auto profile = heap_profile(30.0, 30.0);
  for (double& top : profile.top_m) top = std::min(top, 0.14);  // a flat summit
  const HeapOptions whole{.axis_m = 0.3, .floor_m = 0.1, .toe_m = 0.005};
  HeapOptions flank = whole;
  flank.to = 0.99;
  EXPECT_LT(heap_angles(profile, whole).mean_deg(), 29.0);
  EXPECT_NEAR(heap_angles(profile, flank).mean_deg(), 30.0, 1e-9);
}

TEST(HeapAngles, EndAtGapsToesAndWalls) {
  auto profile = heap_profile(30.0, 30.0);
  profile.top_m[350] = std::nan("");  // 50 mm right of the axis
  const auto heap =
      heap_angles(profile, {.axis_m = 0.3, .floor_m = 0.1, .toe_m = 0.02, .reach_m = 0.06});
  EXPECT_NEAR(heap.right_end_m, 0.0505, 1e-9);
  EXPECT_NEAR(heap.left_end_m, 0.03 / tangent(30.0), 0.001);
  const auto wall = heap_angles(profile, {.axis_m = 0.3, .floor_m = 0.1, .reach_m = 0.04});
  EXPECT_EQ(wall.left_end_m, 0.04);
}

TEST(HeapAngles, OfASlopeThatFallsToTheAxisAreNegative) {
  Profile profile = heap_profile(20.0, 20.0);
  for (double& top : profile.top_m) top = 0.2 - top;
  const auto heap = heap_angles(profile, {.axis_m = 0.3, .floor_m = 0.0, .reach_m = 0.05});
  EXPECT_NEAR(heap.mean_deg(), -20.0, 1e-9);
}

TEST(HeapAxis, IsTheMiddleOfTheBase) {
  // From 0.3 - 0.05 / tan 45 to 0.3 + 0.05 / tan 20; columns are known to 1 mm.
  const double expected = 0.3 + 0.5 * 0.05 * (1.0 / tangent(20.0) - 1.0 / tangent(45.0));
  EXPECT_NEAR(heap_axis_m(heap_profile(45.0, 20.0), 0.1, 1e-6), expected, 0.001);
  EXPECT_TRUE(std::isnan(heap_axis_m({.column_m = 1.0, .top_m = {std::nan("")}}, 0.0, 0.0)));
}

TEST(SlopeAngles, AreThoseOfBothSidesOfAnOutlet) {
  Profile profile{.first_x_m = 0.0005, .column_m = 0.001, .top_m = {}};
  for (std::size_t c = 0; c < 400; ++c) {
    const double x = profile.x_m(c);
    profile.top_m.push_back(x < 0.15   ? (0.15 - x) * tangent(40.0)
                            : x > 0.25 ? (x - 0.25) * tangent(35.0)
                                       : std::nan(""));
  }
  const auto slopes = slope_angles(profile, 0.0, 0.15, 0.25, 0.4);
  EXPECT_NEAR(slopes.left_deg, 40.0, 1e-9);
  EXPECT_NEAR(slopes.right_deg, 35.0, 1e-9);
}

}  // namespace
}  // namespace repose::dem_adapter

// Silhouettes and fitted lines on shapes whose answer is known.
#include "repose/dem_adapter/silhouette.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "repose/base/random.hpp"

namespace repose::dem_adapter {
namespace {

TEST(Silhouette, OfOneDiscIsItsUpperHalfCircle) {
  const std::vector<Disc> discs{{0.1, 0.5, 0.05}};
  const auto profile = silhouette(discs, 0.0, 0.2, 0.001);
  ASSERT_EQ(profile.top_m.size(), 200U);
  for (std::size_t c = 0; c < profile.top_m.size(); ++c) {
    const double offset = profile.x_m(c) - 0.1;
    if (std::abs(offset) > 0.05)
      EXPECT_TRUE(std::isnan(profile.top_m[c])) << c;
    else
      EXPECT_NEAR(profile.top_m[c], 0.5 + std::sqrt(0.0025 - offset * offset), 1e-12) << c;
  }
}

TEST(Silhouette, OfManyDiscsIsTheirHighestPointAndIgnoresTheirOrder) {
  RandomStream random(5);
  std::vector<Disc> discs;
  for (int i = 0; i < 200; ++i)
    discs.push_back({random.uniform(-0.1, 1.1), random.uniform(), random.uniform(0.005, 0.03)});
  const auto fast = silhouette(discs, 0.0, 1.0, 0.002);
  auto reversed = discs;
  std::reverse(reversed.begin(), reversed.end());
  const auto again = silhouette(reversed, 0.0, 1.0, 0.002);
  for (std::size_t c = 0; c < fast.top_m.size(); ++c) {
    double slow = -1.0;  // every disc asked at every column
    for (const auto& d : discs) {
      const double rise = d.radius_m * d.radius_m - std::pow(fast.x_m(c) - d.x_m, 2);
      if (rise >= 0.0) slow = std::max(slow, d.z_m + std::sqrt(rise));
    }
    if (slow < 0.0) {
      EXPECT_TRUE(std::isnan(fast.top_m[c]));
    } else {
      EXPECT_EQ(fast.top_m[c], slow);
      EXPECT_EQ(again.top_m[c], slow);
    }
  }
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

}  // namespace
}  // namespace repose::dem_adapter

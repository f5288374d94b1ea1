// Silhouettes of shapes whose answer is known.
#include "repose/dem_adapter/silhouette.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace repose::dem_adapter

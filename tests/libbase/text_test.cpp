// Names and numbers in messages.
#include "repose/base/text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

namespace repose {
namespace {

TEST(Shortest, ReadsBackTheSameDouble) {
  for (const double value : {0.1, 1.0 / 3.0, 1e-300, -2.5e17, 5e-324, std::nextafter(1.0, 2.0),
                             std::numeric_limits<double>::max()})
    EXPECT_EQ(std::strtod(shortest(value).c_str(), nullptr), value);
  EXPECT_EQ(shortest(0.1), "0.1");
}

TEST(ClosestName, FindsASlipAndIgnoresAStranger) {
  const std::vector<std::string> names{"mu_s_pp", "mu_r_pp", "restitution"};
  EXPECT_EQ(closest_name("mu_s_ppp", names), "mu_s_pp");
  EXPECT_EQ(closest_name("resitution", names), "restitution");
  EXPECT_EQ(closest_name("density", names), "");
}

TEST(ContentHash, IsFnv1a) {
  // Offset basis and the published value for "a" (64-bit FNV-1a).
  EXPECT_EQ(content_hash(""), 0xcbf29ce484222325U);
  EXPECT_EQ(content_hash("a"), 0xaf63dc4c8601ec8cU);
}

TEST(DurationText, SpeaksInTheUnitAPersonWould) {
  EXPECT_EQ(duration_text(12.4), "12 s");
  EXPECT_EQ(duration_text(200), "3 min 20 s");
  EXPECT_EQ(duration_text(3720), "1 h 02 min");
  EXPECT_EQ(duration_text(std::nan("")), "?");
}

TEST(Listed, JoinsNamesAsASentenceWould) {
  EXPECT_EQ(listed({}), "");
  EXPECT_EQ(listed({"a"}), "a");
  EXPECT_EQ(listed({"a", "b", "c"}), "a, b and c");
}

}  // namespace
}  // namespace repose

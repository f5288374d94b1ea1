#include <gtest/gtest.h>

#include <cmath>

#include "repose/base/error.hpp"
#include "sample_case.hpp"

namespace repose::scene {
namespace {

TEST(CaseFile, ReadsBackEqualBitForBit) {
  const Case written = sample_case();
  const Case read = parse_case(case_text(written), "sample");
  EXPECT_TRUE(read == written);
  EXPECT_EQ(case_text(read), case_text(written));
  EXPECT_TRUE(std::signbit(read.gravity_m_s2.y()));  // -0.0 keeps its sign
}

TEST(CaseFile, OfTheQuickDrawdownRigIsValid) {
  const Case rig = read_case(REPOSE_TEST_DATA "/quick_drawdown.toml");
  EXPECT_EQ(rig.walls.size(), 8u);
  EXPECT_EQ(rig.fill->layers.size(), 4u);
  EXPECT_DOUBLE_EQ(rig.materials[0].youngs_modulus_pa, 5e6);  // E = 2 G (1 + nu)
  EXPECT_EQ(rig.regions[0].lower.x(), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(parse_case(case_text(rig), "rig") == rig);
}

constexpr const char* kSmall = R"(
[domain]
lower_m = [-1, -1, -1]
upper_m = [1, 1, 1]
[[material]]
name = "grain"
density_kg_m3 = 2500
youngs_modulus_pa = 1e7
poissons_ratio = 0.25
[[pair]]
materials = ["grain", "grain"]
restitution = 0.5
mu_s = 0.5
mu_r = 0.1
[[particle]]
material = "grain"
radius_m = 0.01
position_m = [0, 0, 0]
[[stage]]
name = "fall"
duration_s = 0.1
)";

TEST(CaseFile, ABoxBecomesItsFacesWithoutTheOpenOnes) {
  const Case c = parse_case(std::string(kSmall) + R"(
[[box]]
name = "bin"
material = "grain"
lower_m = [0, 0, 0]
upper_m = [1, 2, 3]
open = ["+z"]
)",
                            "small");
  ASSERT_EQ(c.walls.size(), 5u);
  EXPECT_EQ(c.walls[1].name, "bin.+x");
  EXPECT_EQ(std::get<Rectangle>(c.walls[1].shape).origin, Vec3(1, 0, 0));
  double area = 0.0;
  for (const Wall& wall : c.walls) {
    const auto& face = std::get<Rectangle>(wall.shape);
    area += face.edge_u.norm() * face.edge_v.norm();
  }
  EXPECT_DOUBLE_EQ(area, 2 * (1 * 2 + 2 * 3 + 3 * 1) - 1 * 2);
  EXPECT_EQ(walls_named(c, "bin").size(), 5u);
  EXPECT_EQ(walls_named(c, "bin.-z").size(), 1u);
  EXPECT_TRUE(walls_named(c, "bi").empty());
}

/// The message that reading `text` gives, "" if it is read without error.
std::string message_of(const std::string& text) {
  try {
    parse_case(text, "small");
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(CaseFile, RefusesKeysThatNobodyKnowsWithTheirLine) {
  const std::string message = message_of(std::string(kSmall) + "duraton_s = 1.0\n");
  EXPECT_NE(message.find("small:"), std::string::npos) << message;
  EXPECT_NE(message.find("duraton_s"), std::string::npos) << message;
}

TEST(CaseFile, RefusesBothModuli) {
  std::string text = kSmall;
  text.insert(text.find("youngs_modulus_pa"), "shear_modulus_pa = 1e6\n");
  EXPECT_NE(message_of(text).find("give one of them"), std::string::npos);
}

TEST(CaseFile, RefusesAVectorOfTwoNumbers) {
  std::string text = kSmall;
  text.replace(text.find("[0, 0, 0]"), 9, "[0, 0]");
  EXPECT_NE(message_of(text).find("give three"), std::string::npos);
}

}  // namespace
}  // namespace repose::scene

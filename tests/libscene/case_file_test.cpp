#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
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

TEST(CaseFile, NamesTheLineOfAFaceThatDoesNotExist) {
  const std::string message = message_of(std::string(kSmall) + R"([[box]]
name = "bin"
material = "grain"
lower_m = [0, 0, 0]
upper_m = [1, 1, 1]
open = ["top"]
)");
  EXPECT_NE(message.find("small:27: box[1].open"), std::string::npos) << message;
  EXPECT_NE(message.find("\"top\" is not a face"), std::string::npos) << message;
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

/// kSmall with a fill whose single layer has `keys`.
std::string with_layer(const std::string& keys) {
  return std::string(kSmall) +
         "[fill]\nlower_m = [-1, -1, -1]\nupper_m = [1, 1, 1]\n[[fill.layer]]\nmass_kg = 0.1\n" +
         keys;
}

TEST(CaseFile, SievesBecomeClassesWithoutTheEmptyOnes) {
  const Case c = parse_case(with_layer(R"(material = "grain"
sizes = {sieves_m = [0.01, 0.02, 0.03, 0.05], mass_percent = [12.5, 0, 87.5]}
)"),
                            "small");
  const Grains& kind = c.fill->layers[0].mixture.at(0);
  const std::vector<SizeClass> expected{{0.01, 0.02, 0.125}, {0.03, 0.05, 0.875}};
  EXPECT_EQ(std::get<std::vector<SizeClass>>(kind.sizes), expected);
}

TEST(CaseFile, SaysToWhatSievesSum) {
  const std::string message = message_of(with_layer(R"(material = "grain"
sizes = {sieves_m = [0.01, 0.02, 0.03], mass_percent = [20, 79]}
)"));
  EXPECT_NE(message.find("mass_percent"), std::string::npos) << message;
  EXPECT_NE(message.find("sums to 99; it must sum to 100"), std::string::npos) << message;
}

TEST(CaseFile, RefusesSievesThatDoNotAscendOrMatch) {
  const std::string start = "material = \"grain\"\nsizes = {sieves_m = ";
  EXPECT_NE(message_of(with_layer(start + "[0.02, 0.01], mass_percent = [100]}\n"))
                .find("openings must ascend"),
            std::string::npos);
  EXPECT_NE(
      message_of(with_layer(start + "[0.01], mass_percent = [100]}\n")).find("one opening more"),
      std::string::npos);
}

TEST(CaseFile, RefusesAKindBesideAMixture) {
  const std::string message = message_of(with_layer(R"(material = "grain"
mixture = [{material = "grain", mass_fraction = 1, sizes = [{diameter_m = 0.01}]}]
)"));
  EXPECT_NE(message.find("stands beside mixture"), std::string::npos) << message;
}

TEST(CaseFile, TurnsRevolutionsAMinuteIntoRadians) {
  const std::string wall = R"([[wall]]
name = "drum"
material = "grain"
shape = "cylinder"
start_m = [0, -0.5, 0]
end_m = [0, 0.5, 0]
radius_m = 0.5
[[motion]]
walls = ["drum"]
type = "rotate"
centre_m = [0, 0, 0]
axis = [0, 1, 0]
rate_rpm = 30
)";
  const Case c = parse_case(std::string(kSmall) + wall, "small");
  EXPECT_DOUBLE_EQ(std::get<Rotation>(c.motions.at(0).path).rate_rad_s, 3.14159265358979323846);
  EXPECT_NE(message_of(std::string(kSmall) + wall + "rate_rad_s = 1\n").find("give one of them"),
            std::string::npos);
}

/// A folder with a case file and a mesh beside it, which go away with the test.
struct CaseFolder {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("repose_case_file_" + std::to_string(::getpid()));
  CaseFolder() {
    make_directory(path / "parts");
    write_file_atomically(path / "parts" / "blade.stl", "solid blade\nendsolid blade\n");
  }
  ~CaseFolder() { std::filesystem::remove_all(path); }
  Case read(const std::string& more) const {
    write_file_atomically(path / "case.toml", std::string(kSmall) + R"([[wall]]
name = "blade"
material = "grain"
shape = "mesh"
file = "parts/../parts/blade.stl"
)" + more);
    return read_case(path / "case.toml");
  }
};

TEST(CaseFile, TakesRelativeFilesFromItsFolderAndNotesTheirContent) {
  const CaseFolder folder;
  const Case c = folder.read("");
  const auto& mesh = std::get<Mesh>(c.walls.at(0).shape);
  EXPECT_EQ(mesh.file, folder.path / "parts" / "blade.stl");
  EXPECT_EQ(mesh.content_hash, content_hash("solid blade\nendsolid blade\n"));
  EXPECT_TRUE(parse_case(case_text(c), "again") == c);
}

TEST(CaseFile, KeepsAContentHashThatItGives) {
  const CaseFolder folder;
  const Case c = folder.read("content_hash = \"00000000000000ff\"\n");
  EXPECT_EQ(std::get<Mesh>(c.walls.at(0).shape).content_hash, 255u);
  EXPECT_THROW(folder.read("content_hash = \"xyz\"\n"), InputError);
  EXPECT_THROW(folder.read("content_hash = \"\"\n"), InputError);
}

TEST(CaseFile, NamesTheLineOfAFileThatCannotBeRead) {
  const CaseFolder folder;
  std::filesystem::remove(folder.path / "parts" / "blade.stl");
  try {
    folder.read("");
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("case.toml:26: wall[1].file"), std::string::npos) << message;
    EXPECT_NE(message.find("blade.stl"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace repose::scene

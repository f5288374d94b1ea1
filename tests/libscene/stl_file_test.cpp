#include "repose/scene/stl_file.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "mesh_files.hpp"
#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::scene {
namespace {

std::vector<Triangle> unit_box() {
  return box_triangles({0, 0, 0}, {1, 1, 1});
}

/// What parse_stl() says of bad bytes.
std::string refusal(const std::string& bytes) {
  try {
    parse_stl(bytes, "bin.stl");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(StlFile, AsciiReadsBackEveryBitWithAnyEndOfLine) {
  std::vector<Triangle> triangles = unit_box();
  triangles[3][1] = {1.0 / 3.0, -1e-7, 2e5};
  EXPECT_EQ(parse_stl(ascii_stl(triangles), "a"), triangles);
  EXPECT_EQ(parse_stl(ascii_stl(triangles, "\r\n"), "a"), triangles);
  EXPECT_EQ(parse_stl("\xEF\xBB\xBF" + ascii_stl(triangles, "\r\n"), "a"), triangles);
}

TEST(StlFile, BinaryIsReadWhateverItsHeaderSays) {
  const std::vector<Triangle> triangles = unit_box();  // exact in single precision
  EXPECT_EQ(parse_stl(binary_stl(triangles), "a"), triangles);
  EXPECT_EQ(parse_stl(binary_stl(triangles, "solid but binary"), "a"), triangles);
  EXPECT_TRUE(parse_stl(binary_stl({}), "a").empty());
}

TEST(StlFile, SolidsOfOneAsciiFileFollowEachOtherInAnyCase) {
  std::string text = ascii_stl(unit_box());
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  EXPECT_EQ(parse_stl(text + ascii_stl(unit_box()), "a").size(), 24u);
}

TEST(StlFile, NumbersMayHaveAPlusAndNormalsMayBeNan) {
  const std::string text =
      "solid\nfacet normal nan nan nan\nouter loop\nvertex +1 0 0\nvertex 1e-400 1 0\n"
      "vertex 0 0 1.5E+0\nendloop\nendfacet\nendsolid\n";
  const std::vector<Triangle> expected = {{Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1.5)}};
  EXPECT_EQ(parse_stl(text, "a"), expected);
}

TEST(StlFile, DamageIsNamedWithItsLine) {
  const std::string good = ascii_stl(unit_box());
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return refusal(text);
  };
  EXPECT_TRUE(says(with("vertex 0 0 0", "vertex 0 nan 0"), "bin.stl:4:"))
      << with("vertex 0 0 0", "vertex 0 nan 0");
  EXPECT_TRUE(says(with("vertex 0 0 0", "vertex 0 nan 0"), "\"nan\""));
  EXPECT_TRUE(says(with("vertex 0 0 0", "vertex 0 1e31 0"), "at most 1e30"));
  EXPECT_TRUE(says(with("vertex 0 0 0", "vertex 0 1e999 0"), "at most 1e30"));
  EXPECT_TRUE(says(with("vertex 0 0 0", "vertex 0 zero 0"), "expected a number"));
  EXPECT_TRUE(says(with("vertex 0 0 0", "vertex 0 0"), "expected a number"));
  EXPECT_TRUE(says(with("endloop", "vertex 1 1 1\nendloop"), "only triangles"));
  EXPECT_TRUE(says(with("facet", "fazet"), "found \"fazet\""));
  EXPECT_TRUE(says(refusal(good.substr(0, good.size() / 2)), "cut off"));
  EXPECT_TRUE(says(refusal(good.substr(0, good.rfind("endsolid"))), "cut off"));
}

TEST(StlFile, WrongCountsAreNamedWithTheBytesTheyWouldTake) {
  const std::string good = binary_stl(unit_box());
  EXPECT_TRUE(says(refusal(good.substr(0, 400)), "12 triangles takes 684 bytes"))
      << refusal(good.substr(0, 400));
  EXPECT_TRUE(says(refusal(good + "x"), "has 685"));
  EXPECT_TRUE(says(refusal(binary_stl(unit_box(), "solid x").substr(0, 500)), "has 500"));
  EXPECT_TRUE(says(refusal("PK\x03\x04"), "4 bytes are no STL file"));
  EXPECT_TRUE(says(refusal(""), "0 bytes"));
}

TEST(StlFile, CoordinatesThatAreNoNumberAreRefusedWithTheirTriangle) {
  std::vector<Triangle> triangles = unit_box();
  triangles[6][2].y() = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(says(refusal(binary_stl(triangles)), "triangle 7 of 12"));
  triangles[6][2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(says(refusal(binary_stl(triangles)), "triangle 7 of 12"));
}

TEST(StlFile, MutatedFilesAreReadOrRefusedButNeverCrash) {
  RandomStream random(20);
  const std::string sources[] = {ascii_stl(unit_box()), binary_stl(unit_box()),
                                 binary_stl(unit_box(), "solid")};
  int accepted = 0;
  int refused = 0;
  for (int t = 0; t < 3000; ++t) {
    std::string bytes = sources[t % 3];
    const std::uint64_t edits = 1 + random.below(2);
    for (std::uint64_t e = 0; e < edits && !bytes.empty(); ++e) {
      const std::size_t at = random.below(bytes.size());
      switch (random.below(4)) {
        case 0:
          bytes[at] = static_cast<char>(random.below(256));
          break;
        case 1:
          bytes.resize(at);
          break;
        case 2:
          bytes.insert(at, bytes.substr(random.below(bytes.size()), random.below(60)));
          break;
        default:
          bytes.erase(at, random.below(60));
      }
    }
    try {
      const std::vector<Triangle> triangles = parse_stl(bytes, "bin.stl");
      for (const Triangle& triangle : triangles)
        for (const Vec3& x : triangle) ASSERT_LE(x.cwiseAbs().maxCoeff(), 1e30);
      const TriangleMesh mesh = weld(triangles);
      const MeshReport report = inspect(mesh);
      ASSERT_EQ(report.triangles, static_cast<std::int64_t>(triangles.size()));
      EXPECT_FALSE(mesh_report_text(report).empty());
      ++accepted;
    } catch (const InputError& error) {
      ASSERT_TRUE(says(error.what(), "bin.stl"));
      ++refused;
    }
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace repose::scene

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <regex>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/scene/vtp.hpp"
#include "sample_case.hpp"

namespace repose::scene {
namespace {

/// A .vtp file taken apart by the rules of the format: arrays at their offsets, each after its
/// length in bytes.
struct ParsedVtp {
  std::size_t points = 0, vertices = 0, polygons = 0;
  double time_s = 0.0;
  std::map<std::string, std::vector<double>> arrays;
  std::map<std::string, int> components;

  explicit ParsedVtp(const std::string& file) {
    const std::string mark = "<AppendedData encoding=\"raw\">\n_";
    const std::size_t data = file.find(mark) + mark.size();
    const std::string head = file.substr(0, data);
    const std::regex number("(\\w+)=\"([^\"]*)\"");
    points = count(head, "NumberOfPoints");
    vertices = count(head, "NumberOfVerts");
    polygons = count(head, "NumberOfPolys");
    time_s = std::stod(head.substr(head.find("format=\"ascii\">") + 15));
    std::size_t expected_offset = 0;
    const std::regex array(
        "<DataArray type=\"(\\w+)\" Name=\"(\\w+)\" NumberOfComponents=\"(\\d+)\" "
        "format=\"appended\" offset=\"(\\d+)\"/>");
    for (auto m = std::sregex_iterator(head.begin(), head.end(), array);
         m != std::sregex_iterator(); ++m) {
      const std::size_t offset = std::stoul((*m)[4]);
      EXPECT_EQ(offset, expected_offset) << (*m)[2];
      std::uint64_t size = 0;
      std::memcpy(&size, file.data() + data + offset, 8);
      arrays[(*m)[2]] = values((*m)[1], file.data() + data + offset + 8, size);
      components[(*m)[2]] = std::stoi((*m)[3]);
      expected_offset = offset + 8 + size;
    }
    EXPECT_EQ(file.substr(data + expected_offset), "\n</AppendedData>\n</VTKFile>\n");
  }

 private:
  static std::size_t count(const std::string& head, const std::string& key) {
    std::smatch match;
    EXPECT_TRUE(std::regex_search(head, match, std::regex(key + "=\"(\\d+)\""))) << key;
    return std::stoul(match[1]);
  }
  template <class T>
  static std::vector<double> as(const char* data, std::uint64_t size) {
    std::vector<T> values(size / sizeof(T));
    std::memcpy(values.data(), data, size);
    return {values.begin(), values.end()};
  }
  static std::vector<double> values(const std::string& type, const char* data, std::uint64_t size) {
    if (type == "Float32") return as<float>(data, size);
    if (type == "Int32") return as<std::int32_t>(data, size);
    EXPECT_EQ(type, "Int64");
    return as<std::int64_t>(data, size);
  }
};

Snapshot three_spheres(double time_s) {
  Snapshot s;
  s.time_s = time_s;
  s.stage = "fill";
  s.materials = {"pellet", "steel"};
  s.id = {3, 5, 6};
  s.body = {3, 4, 4};
  s.material = {0, 1, 1};
  s.radius_m = {0.5, 0.25, 1.0 / 3.0};
  s.mass_kg = {1.0, 2.0, 3.0};
  s.position = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  s.velocity = {{-1, -2, -3}, {0, 0, 0}, {0.5, 0, 0}};
  s.angular_velocity = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  return s;
}

TEST(Vtp, OfASnapshotHasAPointASphereWithItsData) {
  const ParsedVtp file(vtp_text(three_spheres(0.1)));
  EXPECT_EQ(file.points, 3u);
  EXPECT_EQ(file.vertices, 3u);
  EXPECT_EQ(file.polygons, 0u);
  EXPECT_EQ(file.time_s, 0.1);
  EXPECT_EQ(file.arrays.at("Points"), (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(file.components.at("Points"), 3);
  EXPECT_EQ(file.arrays.at("radius"), (std::vector<double>{0.5, 0.25, 1.0f / 3.0f}));
  EXPECT_EQ(file.arrays.at("mass"), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(file.arrays.at("material"), (std::vector<double>{0, 1, 1}));
  EXPECT_EQ(file.arrays.at("velocity"), (std::vector<double>{-1, -2, -3, 0, 0, 0, 0.5, 0, 0}));
  EXPECT_EQ(file.arrays.at("angular_velocity"), (std::vector<double>{0, 0, 1, 0, 1, 0, 1, 0, 0}));
  EXPECT_EQ(file.arrays.at("body"), (std::vector<double>{3, 4, 4}));
  EXPECT_EQ(file.arrays.at("id"), (std::vector<double>{3, 5, 6}));
  EXPECT_EQ(file.arrays.at("connectivity"), (std::vector<double>{0, 1, 2}));
  EXPECT_EQ(file.arrays.at("offsets"), (std::vector<double>{1, 2, 3}));
}

TEST(Vtp, OfNoParticlesIsWhole) {
  const ParsedVtp file(vtp_text(Snapshot{}));
  EXPECT_EQ(file.points, 0u);
  EXPECT_TRUE(file.arrays.at("Points").empty());
}

double area(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 1) - mesh.corner(t, 0);
    const Vec3 b = mesh.corner(t, 2) - mesh.corner(t, 0);
    sum += 0.5 * std::hypot(a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(),
                            a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

/// The area of a wall of this shape in a domain of -1 to 1.
double area_of(const Shape& shape) {
  Case c;
  c.lower_m = {-1, -1, -1};
  c.upper_m = {1, 1, 1};
  return area(wall_triangles(c, {"w", "m", shape}));
}

// An inscribed polygon of n corners has n/(2 pi) sin(2 pi/n) of the circle's area and, as its
// perimeter, n/pi sin(pi/n) of its circumference.
constexpr double kPi = std::numbers::pi;
const double kPolygonArea = 64.0 / (2.0 * kPi) * std::sin(2.0 * kPi / 64.0);
const double kPolygonLength = 64.0 / kPi * std::sin(kPi / 64.0);

TEST(WallTriangles, HaveTheAreaOfTheirShape) {
  EXPECT_NEAR(area_of(Rectangle{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}}), 6.0, 1e-14);
  EXPECT_NEAR(area_of(Disc{{0, 0, 0}, {1, 1, 0}, 0.5}), kPi * 0.25 * kPolygonArea, 1e-14);
  EXPECT_NEAR(area_of(Disc{{0, 0, 0}, {1, 2, 3}, 0.5, 0.2}), kPi * 0.21 * kPolygonArea, 1e-14);
  const double cylinder = 2.0 * kPi * 0.5 * 3.0 * kPolygonLength;
  EXPECT_NEAR(area_of(Cone{{0, 0, 0}, {0, 3, 0}, 0.5, 0.5}), cylinder, 1e-13);
  // A cone's facets are as high as the slant height at their middle.
  const double apothem = 0.5 * std::cos(kPi / 64.0);
  const double cone = kPi * 0.5 * kPolygonLength * std::hypot(3.0, apothem);
  EXPECT_NEAR(area_of(Cone{{0, 0, 0}, {0, 3, 0}, 0.0, 0.5}), cone, 1e-13);
  EXPECT_NEAR(area_of(Cone{{0, 0, 0}, {0, 3, 0}, 0.5, 0.0}), cone, 1e-13);
}

TEST(WallTriangles, OfAPlaneReachToTheDomain) {
  EXPECT_NEAR(area_of(Plane{{5, 5, 0.5}, {0, 0, 2}}), 4.0, 1e-14);
  EXPECT_NEAR(area_of(Plane{{0, 0, 0}, {1, 0, 1}}), 4.0 * std::sqrt(2.0), 1e-14);
  // The regular hexagon of a cube: side sqrt(2).
  EXPECT_NEAR(area_of(Plane{{0, 0, 0}, {1, 1, 1}}), 3.0 * std::sqrt(3.0), 1e-13);
  EXPECT_EQ(area_of(Plane{{0, 0, 2}, {0, 0, 1}}), 0.0);
}

/// A folder that goes away with the test.
struct Scratch {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("repose_vtp_" + std::to_string(::getpid()));
  Scratch() { std::filesystem::remove_all(path); }
  ~Scratch() { std::filesystem::remove_all(path); }
};

Case two_walls() {
  Case c;
  c.lower_m = {-1, -1, -1};
  c.upper_m = {1, 1, 1};
  c.materials = {{"pellet", 1, 1}, {"steel", 1, 1}};
  c.walls = {{"floor", "steel", Rectangle{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
             {"gate", "pellet", Rectangle{{0, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  return c;
}

TEST(VtpWriter, WritesWallsOnlyWhenTheyMoveOrOpen) {
  const Scratch scratch;
  VtpWriter writer(scratch.path, two_walls());
  std::vector<WallPose> poses(2);
  writer.write(three_spheres(0.0), poses);
  writer.write(three_spheres(0.1), poses);
  poses[1].rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  poses[1].translation = {0, 0, 10};
  writer.write(three_spheres(0.2), poses);
  poses[0].is_open = true;
  writer.write(three_spheres(0.3), poses);
  EXPECT_FALSE(std::filesystem::exists(scratch.path / "walls_000002.vtp"));

  const ParsedVtp drawn(read_file(scratch.path / "walls_000001.vtp"));
  EXPECT_EQ(drawn.points, 8u);
  EXPECT_EQ(drawn.polygons, 4u);
  EXPECT_EQ(drawn.arrays.at("wall"), (std::vector<double>{0, 0, 1, 1}));
  EXPECT_EQ(drawn.arrays.at("material"), (std::vector<double>{1, 1, 0, 0}));
  EXPECT_EQ(drawn.arrays.at("offsets"), (std::vector<double>{3, 6, 9, 12}));
  EXPECT_EQ(drawn.arrays.at("connectivity").size(), 12u);
  for (double point : drawn.arrays.at("connectivity")) EXPECT_LT(point, 8.0);

  const ParsedVtp open(read_file(scratch.path / "walls_000004.vtp"));
  EXPECT_EQ(open.time_s, 0.3);
  EXPECT_EQ(open.arrays.at("wall"), (std::vector<double>{1, 1}));
  // Corner (0, 1, 0) of the gate turned by a quarter about z and lifted.
  const std::vector<double>& points = open.arrays.at("Points");
  EXPECT_EQ(std::vector<double>(points.begin() + 3, points.begin() + 6),
            (std::vector<double>{-1, 0, 10}));

  const std::string index = read_file(scratch.path / "walls.pvd");
  for (const char* entry : {"timestep=\"0\" part=\"0\" file=\"walls_000001.vtp\"",
                            "timestep=\"0.1\" part=\"0\" file=\"walls_000001.vtp\"",
                            "timestep=\"0.2\" part=\"0\" file=\"walls_000003.vtp\"",
                            "timestep=\"0.3\" part=\"0\" file=\"walls_000004.vtp\""})
    EXPECT_NE(index.find(entry), std::string::npos) << entry << "\n" << index;
  EXPECT_NE(read_file(scratch.path / "particles.pvd").find("particles_000004.vtp"),
            std::string::npos);
}

TEST(VtpWriter, ThatFailsToRemoveAFileLeavesNoWallsWithoutParticlesNorAGap) {
  const Scratch scratch;
  const auto has = [&](const char* name) { return std::filesystem::exists(scratch.path / name); };
  std::vector<WallPose> poses(2);
  VtpWriter first(scratch.path, two_walls());
  for (int k = 0; k < 4; ++k) {
    poses[1].translation.z() = 0.1 * k;
    first.write(three_spheres(k), poses);
  }
  // A folder with something in it cannot be removed as a file.
  const std::filesystem::path stubborn = scratch.path / "particles_000003.vtp";
  std::filesystem::remove(stubborn);
  std::filesystem::create_directories(stubborn / "something");
  poses[1].translation.z() = 0.0;
  EXPECT_THROW(VtpWriter(scratch.path, two_walls()).go_on_after({0.0}, poses), StorageError);
  EXPECT_FALSE(has("particles_000004.vtp") || has("walls_000004.vtp"));
  EXPECT_FALSE(has("walls_000003.vtp"));
  EXPECT_TRUE(has("particles_000003.vtp"));
  EXPECT_TRUE(has("particles_000002.vtp") && has("walls_000002.vtp"));
  std::filesystem::remove_all(stubborn / "something");
  VtpWriter(scratch.path, two_walls()).go_on_after({0.0}, poses);
  for (const char* name : {"particles_000002.vtp", "walls_000002.vtp", "particles_000003.vtp"})
    EXPECT_FALSE(has(name)) << name;
  EXPECT_TRUE(has("particles_000001.vtp") && has("walls_000001.vtp"));
}

}  // namespace
}  // namespace repose::scene

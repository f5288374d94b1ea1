#include "repose/scene/triangle_mesh.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "mesh_files.hpp"
#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {
namespace {

bool says(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class MeshFile : public ::testing::Test {
 protected:
  MeshFile() { std::filesystem::create_directories(folder_); }
  ~MeshFile() override { std::filesystem::remove_all(folder_); }

  /// A wall of these triangles.
  Mesh wall(const std::vector<Triangle>& triangles) const {
    const std::filesystem::path file = folder_ / "bin.stl";
    write_file_atomically(file, ascii_stl(triangles));
    return {.file = file};
  }
  static std::string refusal(const Mesh& wall) {
    try {
      load_mesh(wall);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) /
      (std::string("mesh_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

/// A sphere of triangles between 2 n parallels and 2 n meridians.
std::vector<Triangle> globe(double radius, int n) {
  const auto at = [&](int i, int j) {
    const double polar = std::numbers::pi * i / (2 * n);
    const double azimuth = std::numbers::pi * (j % (2 * n)) / n;
    if (i == 0 || i == 2 * n) return Vec3(0, 0, i == 0 ? radius : -radius);
    return Vec3(radius * std::sin(polar) * std::cos(azimuth),
                radius * std::sin(polar) * std::sin(azimuth), radius * std::cos(polar));
  };
  std::vector<Triangle> triangles;
  for (int i = 0; i < 2 * n; ++i)
    for (int j = 0; j < 2 * n; ++j) {
      if (i > 0) triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i < 2 * n - 1) triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  return triangles;
}

TEST_F(MeshFile, AClosedBoxHasItsCornersAreaAndVolume) {
  const LoadedMesh box = load_mesh(wall(box_triangles({1, 2, 3}, {2, 4, 6}, 2)));
  EXPECT_EQ(box.report.triangles, 48);
  EXPECT_EQ(box.report.corners, 26);
  EXPECT_EQ(box.report.components, 1);
  EXPECT_EQ(box.report.inconsistent_edges.count, 0);
  EXPECT_NEAR(box.report.area_m2, 22.0, 1e-12);
  ASSERT_TRUE(box.report.volume_m3);
  EXPECT_NEAR(*box.report.volume_m3, 6.0, 1e-12);
  EXPECT_EQ(box.report.lower, Vec3(1, 2, 3));
  EXPECT_EQ(box.report.upper, Vec3(2, 4, 6));
  EXPECT_EQ(mesh_report_text(box.report),
            "48 triangles, 26 corners (0 moved by welding), 1 part, area 22 m2, volume 6 m3");
}

TEST_F(MeshFile, IsScaledThenMoved) {
  Mesh millimetres = wall(box_triangles({0, 0, 0}, {1000, 2000, 3000}));
  millimetres.scale = 0.001;
  millimetres.translation = {10, 0, 0};
  const LoadedMesh box = load_mesh(millimetres);
  EXPECT_NEAR(*box.report.volume_m3, 6.0, 1e-12);
  EXPECT_EQ(box.report.lower, Vec3(10, 0, 0));
}

TEST_F(MeshFile, AGlobeApproachesTheSphereWithTheSquareOfTheFacets) {
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const int n = k == 0 ? 10 : 20;
    const LoadedMesh mesh = load_mesh(wall(globe(0.5, n)));
    EXPECT_EQ(mesh.report.corners, 2 + (2 * n - 1) * 2 * n);  // Euler: V - E + F = 2
    EXPECT_EQ(mesh.report.corners, 2 + mesh.report.triangles / 2);
    errors[k] = std::numbers::pi / 6.0 - *mesh.report.volume_m3;
    EXPECT_GT(errors[k], 0.0);
  }
  EXPECT_NEAR(errors[0] / errors[1], 4.0, 0.1);
}

TEST_F(MeshFile, CornersWithinAMillionthOfTheBoxFallTogether) {
  std::vector<Triangle> triangles = box_triangles({0, 0, 0}, {1, 1, 1}, 3);
  RandomStream random(5);
  for (Triangle& triangle : triangles)
    for (Vec3& x : triangle)
      for (int k = 0; k < 3; ++k) x[k] += random.uniform(-2e-7, 2e-7);  // apart by 7e-7 < 1.7e-6
  const LoadedMesh mesh = load_mesh(wall(triangles));
  EXPECT_EQ(mesh.report.corners, 56);
  EXPECT_GT(mesh.report.moved_corners, 200);
  EXPECT_NEAR(*mesh.report.volume_m3, 1.0, 2e-6);
  // Corners further apart stay apart.
  for (Triangle& triangle : triangles) triangle[0].x() += 1e-5;
  EXPECT_TRUE(says(refusal(wall(triangles)), "edges of one triangle only"));
}

TEST_F(MeshFile, ARimIsRefusedUnlessItIsMeant) {
  std::vector<Triangle> tray = box_triangles({0, 0, 0}, {1, 1, 1});
  tray.resize(10);  // without the top
  Mesh open = wall(tray);
  EXPECT_TRUE(says(refusal(open), "bin.stl\": 4 edges of one triangle only")) << refusal(open);
  EXPECT_TRUE(says(refusal(open), "1) m; close it or")) << refusal(open);
  open.open = true;
  const LoadedMesh mesh = load_mesh(open);
  EXPECT_EQ(mesh.report.rim_edges.count, 4);
  EXPECT_EQ(mesh.report.t_junctions.count, 0);
  EXPECT_FALSE(mesh.report.volume_m3);
  EXPECT_TRUE(says(mesh_report_text(mesh.report), "not closed, 4 rim edges"));
}

TEST_F(MeshFile, ATJunctionIsNamed) {
  // A unit square of two triangles beside three whose common corner cuts the shared side.
  const std::vector<Triangle> triangles = {
      {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0)},
      {Vec3(0, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)},
      {Vec3(1, 0, 0), Vec3(2, 0, 0), Vec3(1, 0.5, 0)},
      {Vec3(1, 0.5, 0), Vec3(2, 0, 0), Vec3(2, 1, 0)},
      {Vec3(1, 0.5, 0), Vec3(2, 1, 0), Vec3(1, 1, 0)},
  };
  const Mesh two_parts = wall(triangles);
  EXPECT_TRUE(
      says(refusal(two_parts), "1 corners that lie within an edge, the first at (1, 0.5, 0) m"))
      << refusal(two_parts);
  const MeshReport report = inspect(weld(triangles));
  EXPECT_EQ(report.t_junctions.count, 1);
  EXPECT_EQ(report.components, 2);
  EXPECT_EQ(report.rim_edges.count, 9);  // 3 + 5 outside and at the seam 1 against 2, less ...
}

TEST_F(MeshFile, TJunctionsAreFoundAmongManyRims) {
  // Against a search of all corners for all edges, for loose triangles on a lattice.
  RandomStream random(8);
  std::vector<Triangle> triangles;
  for (int t = 0; t < 300; ++t) {
    Triangle triangle;
    for (Vec3& x : triangle)
      for (int k = 0; k < 3; ++k) x[k] = static_cast<double>(random.below(5));
    triangles.push_back(triangle);
  }
  TriangleMesh mesh = weld(triangles);
  std::erase_if(mesh.triangles, [&](const auto& t) {
    const Vec3 a =
        mesh.corners[static_cast<std::size_t>(t[1])] - mesh.corners[static_cast<std::size_t>(t[0])];
    const Vec3 b =
        mesh.corners[static_cast<std::size_t>(t[2])] - mesh.corners[static_cast<std::size_t>(t[0])];
    return a.squaredNorm() * b.squaredNorm() - a.dot(b) * a.dot(b) < 1e-9;
  });
  const std::vector<HalfEdge> edges = half_edges(mesh);
  std::vector<HalfEdge> rim;
  for (const HalfEdge& e : edges) {
    int same = 0;
    for (const HalfEdge& f : edges) same += e.first == f.first && e.second == f.second ? 1 : 0;
    if (same == 1) rim.push_back(e);
  }
  std::vector<bool> within(mesh.corners.size(), false);
  for (const HalfEdge& e : rim)
    for (const HalfEdge& f : rim)
      for (const std::int32_t c : {f.first, f.second}) {
        const Vec3 a = mesh.corners[static_cast<std::size_t>(e.first)];
        const Vec3 d = mesh.corners[static_cast<std::size_t>(e.second)] - a;
        const Vec3 x = mesh.corners[static_cast<std::size_t>(c)] - a;
        const double s = x.dot(d) / d.squaredNorm();
        if (s > 1e-9 && s < 1 - 1e-9 && (x - s * d).norm() < 1e-9)
          within[static_cast<std::size_t>(c)] = true;
      }
  const auto expected = std::count(within.begin(), within.end(), true);
  EXPECT_GT(expected, 20);
  EXPECT_EQ(inspect(mesh).t_junctions.count, expected);
}

TEST_F(MeshFile, EdgesOfThreeTrianglesAreRefused) {
  std::vector<Triangle> triangles = box_triangles({0, 0, 0}, {1, 1, 1});
  triangles.push_back({triangles[0][0], triangles[0][1], Vec3(-1, -1, -1)});
  Mesh fin = wall(triangles);
  fin.open = true;
  EXPECT_TRUE(says(refusal(fin), "1 edges of more than two triangles, the first at (0,"))
      << refusal(fin);
}

TEST_F(MeshFile, TrianglesWithoutAreaAreRefusedOrLeftOut) {
  std::vector<Triangle> triangles = box_triangles({0, 0, 0}, {1, 1, 1});
  triangles.push_back({triangles[0][0], triangles[0][1], triangles[0][1]});
  triangles.push_back({Vec3(0, 0, 0), Vec3(0.5, 1e-7, 0), Vec3(1, 0, 0)});
  Mesh bad = wall(triangles);
  EXPECT_TRUE(says(refusal(bad), "2 triangles without area, the first at (")) << refusal(bad);
  EXPECT_TRUE(says(refusal(bad), "drop_degenerate = true"));
  bad.drop_degenerate = true;
  const LoadedMesh mesh = load_mesh(bad);
  EXPECT_EQ(mesh.report.zero_area.count, 2);
  EXPECT_EQ(mesh.mesh.triangles.size(), 12u);
  EXPECT_NEAR(*mesh.report.volume_m3, 1.0, 1e-12);
}

TEST_F(MeshFile, RepeatedTrianglesAreRefusedOrLeftOut) {
  std::vector<Triangle> triangles = box_triangles({0, 0, 0}, {1, 1, 1});
  triangles.push_back({triangles[4][2], triangles[4][1], triangles[4][0]});  // turned round
  Mesh bad = wall(triangles);
  EXPECT_TRUE(says(refusal(bad), "1 triangles that repeat an earlier one"));
  bad.drop_degenerate = true;
  EXPECT_EQ(load_mesh(bad).report.duplicates.count, 1);
  EXPECT_EQ(load_mesh(bad).mesh.triangles.size(), 12u);
}

TEST_F(MeshFile, OppositeOrientationsAreReported) {
  std::vector<Triangle> triangles = box_triangles({0, 0, 0}, {1, 1, 1});
  std::swap(triangles[7][0], triangles[7][1]);
  const LoadedMesh mesh = load_mesh(wall(triangles));
  EXPECT_EQ(mesh.report.inconsistent_edges.count, 3);
  EXPECT_FALSE(mesh.report.volume_m3);
}

TEST_F(MeshFile, AFileThatChangedOrHoldsNothingIsRefused) {
  Mesh box = wall(box_triangles({0, 0, 0}, {1, 1, 1}));
  box.content_hash = content_hash(read_file(box.file));
  EXPECT_NO_THROW(load_mesh(box));
  box.content_hash ^= 1;
  EXPECT_TRUE(says(refusal(box), "content_hash"));
  EXPECT_TRUE(says(refusal(wall({})), "has no triangle"));
  box.file = "/nowhere/bin.stl";
  EXPECT_THROW(load_mesh(box), StorageError);
  EXPECT_TRUE(says(refusal({.file = box.file, .scale = -1.0}), "scale = -1"));
}

}  // namespace
}  // namespace repose::scene

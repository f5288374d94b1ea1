#include "contact/wall_touches.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "mesh_walls.hpp"
#include "output/records.hpp"
#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

/// The contacts of one sphere with some walls, by normal.
class Contacts {
 public:
  explicit Contacts(const std::vector<scene::Wall>& walls) : walls_(with(walls)) {}

  std::vector<WallPush> operator()(const Vec3& x, double radius) {
    std::vector<NearFacet> near;
    walls_.add_near(x, radius, 0.0, near);
    std::vector<WallPush> pushes = touches_.find(walls_, x, radius, near, 0.0);
    std::sort(pushes.begin(), pushes.end(), [](const WallPush& a, const WallPush& b) {
      for (int k = 0; k < 3; ++k)
        if (std::abs(a.normal[k] - b.normal[k]) > 1e-6) return a.normal[k] < b.normal[k];
      return false;
    });
    return pushes;
  }

 private:
  static scene::Case with(const std::vector<scene::Wall>& walls) {
    scene::Case c = empty_case({});
    c.walls = walls;
    return c;
  }
  Walls walls_;
  WallTouches touches_;
};

/// Overlap and normal of all contacts are the same but for rounding.
void expect_same(const std::vector<WallPush>& a, const std::vector<WallPush>& b, const Vec3& x) {
  ASSERT_EQ(a.size(), b.size()) << "at " << x.transpose();
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_NEAR(a[k].overlap, b[k].overlap, 1e-14) << "at " << x.transpose();
    EXPECT_LT((a[k].normal - b[k].normal).norm(), 1e-12) << "at " << x.transpose();
  }
}

TEST(WallTouches, OfATriangulatedBoxAreThoseOfItsRectangles) {
  const Vec3 upper(0.1, 0.08, 0.06);
  Contacts rectangles(scene::box_walls("box", "wall", Vec3::Zero(), upper, {}));
  Contacts coarse({mesh_wall("mesh", scene::box_triangles(Vec3::Zero(), upper))});
  Contacts fine({mesh_wall("mesh", scene::box_triangles(Vec3::Zero(), upper, 7))});
  RandomStream random(1);
  int faces = 0, corners = 0;
  for (int t = 0; t < 4000; ++t) {
    // Half of the centres lie near an edge or corner, inside and outside.
    const double radius = 0.01;
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      const double free = random.uniform(-0.01, upper[k] + 0.01);
      const double near = random.below(2) * upper[k] + random.uniform(-0.01, 0.01);
      x[k] = random.below(2) == 0 ? free : near;
    }
    const auto expected = rectangles(x, radius);
    bool deep = false;
    for (const WallPush& push : expected) deep = deep || push.overlap > 0.5 * radius;
    if (deep) continue;  // an error at once, and a centre in the wall has no direction
    faces += expected.size() == 1 ? 1 : 0;
    corners += expected.size() == 3 ? 1 : 0;
    expect_same(coarse(x, radius), expected, x);
    expect_same(fine(x, radius), expected, x);
  }
  EXPECT_GT(faces, 200);
  EXPECT_GT(corners, 20);
}

TEST(WallTouches, OfACoplanarTriangulationAreOneHoweverItIsCut) {
  Contacts rectangle_only({rectangle("r", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0})});
  const auto floor = [](int n, double disorder) {
    return floor_triangles(-0.1, 0.1, -0.1, 0.1, n, n, disorder);
  };
  RandomStream random(2);
  for (const auto& triangles : {floor(2, 0.0), floor(10, 0.0), floor(20, 0.45), floor(60, 0.3)}) {
    Contacts mesh({mesh_wall("mesh", triangles)});
    for (int t = 0; t < 500; ++t) {
      Vec3 x(random.uniform(-0.08, 0.08), random.uniform(-0.08, 0.08), 0.0);
      if (t % 3 == 1) x = triangles[random.below(triangles.size())][0];  // over a corner
      if (t % 3 == 2) {                                                  // over an edge
        const scene::Triangle& triangle = triangles[random.below(triangles.size())];
        x = triangle[1] + random.uniform() * (triangle[2] - triangle[1]);
      }
      if (x.cwiseAbs().maxCoeff() > 0.09) continue;
      x.z() = (t % 2 == 0 ? 1.0 : -1.0) * random.uniform(0.009, 0.00999);
      expect_same(mesh(x, 0.01), rectangle_only(x, 0.01), x);
    }
  }
}

TEST(WallTouches, OfAConvexBodyAreOneAtItsClosestPoint) {
  // However deep, a sphere outside a convex body has one closest point, on a face, an edge or a
  // corner; found here by a search over all facets. The prism has edges of 30 degrees.
  std::vector<scene::Triangle> prism = frustum_triangles(0.0, 0.01, 0.004, 0.003, 12, 3);
  for (const double z : {0.0, 0.01})
    for (int a = 0; a < 12; ++a) {
      const double r = z == 0.0 ? 0.004 : 0.003;
      const auto at = [&](int k) {
        return Vec3(r * std::cos(k * std::numbers::pi / 6), r * std::sin(k * std::numbers::pi / 6),
                    z);
      };
      prism.push_back({Vec3(0, 0, z), at(a), at((a + 1) % 12)});
    }
  Contacts contacts({mesh_wall("prism", prism)});
  RandomStream random(4);
  int touched = 0;
  for (int t = 0; t < 4000; ++t) {
    const double radius = random.uniform(0.001, 0.02);
    const Vec3 x(random.uniform(-0.02, 0.02), random.uniform(-0.02, 0.02),
                 random.uniform(-0.02, 0.03));
    const double r = std::hypot(x.x(), x.y());
    if (r < 0.0041 && x.z() > -1e-4 && x.z() < 0.0101) continue;  // inside
    double closest = 1.0;
    for (const scene::Triangle& tri : prism)
      closest =
          std::min(closest, closest_point(triangle_facet(tri[0], tri[1], tri[2]), x).distance);
    const auto pushes = contacts(x, radius);
    if (closest >= radius) {
      EXPECT_TRUE(pushes.empty());
      continue;
    }
    ++touched;
    ASSERT_EQ(pushes.size(), 1u) << "at " << x.transpose() << " radius " << radius;
    EXPECT_NEAR(pushes[0].overlap, radius - closest, 1e-14);
  }
  EXPECT_GT(touched, 500);
}

TEST(WallTouches, OfAConcaveEdgeAreBothFaces) {
  // A groove of 60 degrees along y; the sphere lies in it symmetrically or to one side.
  const Vec3 left(-std::sin(std::numbers::pi / 3), 0, 0.5);
  const Vec3 right(-left.x(), 0, 0.5);
  const Vec3 y(0, 1, 0);
  const Vec3 o(0, -0.5, 0);
  Contacts groove({mesh_wall("groove", {{o, o + right, o + right + y},
                                        {o, o + right + y, o + y},
                                        {o, o + left, o + y},
                                        {o + left, o + left + y, o + y}})});
  const double r = 0.01;
  for (const double shift : {0.0, 1e-6, -5e-5}) {
    // Of faces at 30 degrees to the floor: distance (z cos - |x| sin) 30.
    const Vec3 x(shift, 0.123, 0.9999 * r / std::cos(std::numbers::pi / 6));
    const auto pushes = groove(x, r);
    ASSERT_EQ(pushes.size(), shift == -5e-5 ? 1u : 2u);
    for (const WallPush& push : pushes)
      EXPECT_NEAR(std::abs(push.normal.z()), std::cos(std::numbers::pi / 6), 1e-12);
  }
}

TEST(WallTouches, OfAThinPlateAreThoseOfTheSideThatIsSeen) {
  // The overlap is larger than the thickness; the far side is behind the near one.
  Contacts plate(
      {mesh_wall("plate", scene::box_triangles({-0.05, -0.05, -1e-4}, {0.05, 0.05, 0}, 4))});
  for (const Vec3& x : {Vec3(0.011, 0.007, 0.0095), Vec3(0.05, 0.01, 0.0095)}) {
    const auto pushes = plate(x, 0.01);
    ASSERT_EQ(pushes.size(), 1u);
    EXPECT_NEAR(pushes[0].overlap, 5e-4, 1e-15);
  }
  // A floor under an infinite plane does nothing either.
  Contacts floors({floor_plane(), rectangle("under", {-1, -1, -1e-4}, {2, 0, 0}, {0, 2, 0})});
  EXPECT_EQ(floors({0.0, 0.0, 0.0095}, 0.01).size(), 1u);
}

TEST(WallTouches, OfSeparatePiecesThatMeetToSinglePrecisionAreOne) {
  const double gap = 3e-8;
  Contacts plates({rectangle("a", {-1, -1, 0}, {1, 0, 0}, {0, 2, 0}),
                   mesh_wall("b", floor_triangles(gap, 1.0, -1.0, 1.0, 3, 3))});
  for (double s = -1e-3; s < 1e-3; s += 1.7e-5) {
    const auto pushes = plates({s, 0.2, 0.00099}, 0.001);
    ASSERT_EQ(pushes.size(), 1u) << s;
    EXPECT_NEAR(pushes[0].overlap, 1e-5, 1e-12);
  }
}

/// Largest deviation of overlap and normal of spheres against a frustum of `around` strips from
/// those against the surface itself; each touches once.
struct Deviation {
  double overlap = 0.0, normal = 0.0;
};
Deviation deviation(int around, double inside_radius, bool is_inside) {
  Contacts exact({cone_wall("cone", {0, 0, 0}, {0, 0, 0.2}, 0.05, 0.1)});
  Contacts mesh({mesh_wall("mesh", frustum_triangles(0, 0.2, 0.05, 0.1, around, 6))});
  Deviation worst;
  RandomStream random(6);
  for (int t = 0; t < 400; ++t) {
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    const double z = random.uniform(0.05, 0.15);
    const double off = (is_inside ? -0.98 : 0.98) * inside_radius / std::cos(std::atan(0.25));
    const double rho = 0.05 + 0.25 * z + off;
    const Vec3 x(rho * std::cos(angle), rho * std::sin(angle), z);
    const auto a = exact(x, inside_radius);
    const auto b = mesh(x, inside_radius);
    EXPECT_EQ(a.size(), 1u);
    EXPECT_EQ(b.size(), 1u) << "at " << x.transpose();
    if (a.size() != 1 || b.size() != 1) return worst;
    worst.overlap = std::max(worst.overlap, std::abs(a[0].overlap - b[0].overlap));
    worst.normal = std::max(worst.normal, (a[0].normal - b[0].normal).norm());
  }
  return worst;
}

TEST(WallTouches, OfACurvedSurfaceConvergeWithTheSquareOfTheFacets) {
  for (const bool is_inside : {true, false}) {
    const Deviation coarse = deviation(90, 0.01, is_inside);
    const Deviation fine = deviation(180, 0.01, is_inside);
    // The sagitta of the widest strip is R (1 - cos(pi/n)); normals differ by half of an edge's
    // angle and by what the diagonals of the strips tilt.
    const double sagitta = 0.09 * (1 - std::cos(std::numbers::pi / 90));
    EXPECT_LT(coarse.overlap, 1.1 * sagitta);
    EXPECT_NEAR(coarse.overlap / fine.overlap, 4.0, 0.4);
    EXPECT_LT(coarse.normal, 1.2 * std::numbers::pi / 90);
    EXPECT_NEAR(coarse.normal / fine.normal, 2.0, 0.3);
  }
}

/// The largest change of the Hertz force, over its size, between positions 1e-5 radii apart on a
/// circle in a cylinder or around it, 1e-2 radii deep.
double largest_jump(int around, bool is_inside) {
  const double r = 0.01;
  Contacts mesh({mesh_wall("mesh", frustum_triangles(0, 0.1, 0.1, 0.1, around, 3))});
  const double rho = is_inside ? 0.1 - 0.99 * r : 0.1 + 0.99 * r;
  double largest = 0.0;
  Vec3 before = Vec3::Zero();
  for (int k = 0; k < 40000; ++k) {
    const double angle = 0.3 + k * 1e-5 * r / rho;
    const auto pushes =
        mesh({rho * std::cos(angle), rho * std::sin(angle), 0.04 + 1e-5 * r * k}, r);
    EXPECT_EQ(pushes.size(), 1u);
    if (pushes.size() != 1) return 1.0;
    const Vec3 force = std::pow(pushes[0].overlap / (1e-2 * r), 1.5) * pushes[0].normal;
    if (k > 0) largest = std::max(largest, (force - before).norm());
    before = force;
  }
  return largest;
}

TEST(WallTouches, OfASmoothSurfacePassTheForceOnWithoutAJump) {
  // A step is 1e-5 radii, over which the overlap changes by 1e-5 tan(2 degrees) radii at most, a
  // part of 7e-5 of itself, and the normal by a few 1e-5 radii over a strip's width.
  for (const bool is_inside : {true, false}) {
    EXPECT_LT(largest_jump(90, is_inside), 1e-3);
    EXPECT_LT(largest_jump(180, is_inside), 1e-3);
    EXPECT_LT(largest_jump(720, is_inside), 1e-3);
  }
}

TEST(WallTouches, OfBothSidesOfATubeAreTwo) {
  Contacts tube({mesh_wall("tube", frustum_triangles(0, 0.1, 0.01, 0.01, 90, 4))});
  const auto pushes = tube({0, 0, 0.04}, 0.01);  // corners reach 0.01, strips 0.01 cos(2 deg)
  EXPECT_GE(pushes.size(), 1u);                  // it fills the tube: one patch all around
  Contacts slot({mesh_wall("slot", scene::box_triangles({0, 0, 0}, {0.0199, 0.1, 0.1}, 3))});
  const auto two = slot({0.00995, 0.05, 0.05}, 0.01);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_NEAR(two[0].normal.dot(two[1].normal), -1.0, 1e-12);
}

TEST(Walls, CoaxialSectionsShareAPatchWhereTheyGoOnSmoothlyOnly) {
  const auto share = [](const scene::Wall& a, const scene::Wall& b) {
    scene::Case c = empty_case({});
    c.walls = {a, b};
    const Walls walls(c);
    return walls.facet(0).patch == walls.facet(1).patch;
  };
  const scene::Wall pipe = cone_wall("pipe", {0, 0, 0}, {0, 0, 1}, 0.1, 0.1);
  EXPECT_TRUE(share(pipe, cone_wall("on", {0, 0, 1}, {0, 0, 3}, 0.1, 0.1)));
  EXPECT_TRUE(share(pipe, cone_wall("on, drawn back", {0, 0, 3}, {0, 0, 1}, 0.1, 0.1)));
  EXPECT_TRUE(share(pipe, cone_wall("before", {0, 0, -2}, {0, 0, 0}, 0.1, 0.1)));
  EXPECT_FALSE(share(pipe, cone_wall("beyond a gap", {0, 0, 1.01}, {0, 0, 3}, 0.1, 0.1)));
  EXPECT_FALSE(share(pipe, cone_wall("wider", {0, 0, 1}, {0, 0, 3}, 0.11, 0.11)));
  EXPECT_FALSE(share(pipe, cone_wall("kink", {0, 0, 1}, {0, 0, 3}, 0.1, 0.11)));
  EXPECT_FALSE(share(pipe, cone_wall("beside", {0.01, 0, 1}, {0.01, 0, 3}, 0.1, 0.1)));
  EXPECT_FALSE(share(pipe, cone_wall("askew", {0, 0, 1}, {0.01, 0, 3}, 0.1, 0.1)));
  const scene::Wall funnel = cone_wall("funnel", {0, 0, 0}, {0, 0, 1}, 0.1, 0.3);
  EXPECT_TRUE(share(funnel, cone_wall("on", {0, 0, 1}, {0, 0, 1.5}, 0.3, 0.4)));
  EXPECT_FALSE(share(funnel, cone_wall("back in", {0, 0, 1}, {0, 0, 0.5}, 0.3, 0.4)));
  EXPECT_FALSE(share(funnel, cone_wall("mirrored", {0, 0, 1}, {0, 0, 2}, 0.3, 0.1)));
}

/// What loading a mesh between the periodic sides y = 0 and y = 0.06 answers, "" if it is taken.
std::string refusal(const std::vector<scene::Triangle>& triangles) {
  scene::Case c = empty_case({});
  c.lower_m.y() = 0.0;
  c.upper_m.y() = 0.06;
  c.periodic.y = true;
  c.walls = {mesh_wall("mesh", triangles)};
  try {
    const Walls walls(c);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(Walls, AMeshLiesWithinThePeriodOrGoesOnAsItsImagesDo) {
  const auto floor = [](double y0, double y1) {
    return floor_triangles(-0.1, 0.1, y0, y1, 7, 5, 0.4);
  };
  EXPECT_EQ(refusal(floor(0.01, 0.05)), "");
  EXPECT_EQ(refusal(floor(0.0, 0.06)), "");
  EXPECT_EQ(refusal(floor(-0.01, 0.08)), "");
  EXPECT_EQ(refusal(scene::box_triangles({0, -0.01, 0}, {0.1, 0.09, 0.03}, 4)), "");
  for (const auto& wrong : {floor(0.01, 0.07), floor(-0.01, 0.05), floor(0.07, 0.09)})
    EXPECT_NE(refusal(wrong).find("it must span the period from 0 to 0.06 m of direction y"),
              std::string::npos)
        << refusal(wrong);
  // These reach over the period, but do not look the same at its two sides.
  std::vector<scene::Triangle> ramp = floor(-0.01, 0.08);
  for (scene::Triangle& triangle : ramp)
    for (Vec3& corner : triangle) corner.z() = 0.1 * corner.y();
  const std::vector<scene::Triangle> single{{Vec3(0, 0, 0), Vec3(0.1, 0, 0), Vec3(0, 0.1, 0)}};
  for (const auto& wrong : {ramp, single})
    EXPECT_NE(refusal(wrong).find("wall \"mesh\": its cuts at the two ends of the period differ"),
              std::string::npos)
        << refusal(wrong);
}

TEST(Walls, TellTheLogOfTheirMeshesWithoutReadingTheFilesAgain) {
  scene::Case c = empty_case({});
  const scene::Wall mesh = mesh_wall("slab", scene::box_triangles({0, 0, 0}, {1, 2, 3}));
  c.walls = {floor_plane(), mesh};
  c.particles = {grain(0.01, {-1, 0, 1})};
  Simulation sim(c);
  std::filesystem::remove(std::get<scene::Mesh>(mesh.shape).file);
  const std::string last = head_of_log(c, sim).back();
  EXPECT_EQ(last.find("mesh \"slab\": 12 triangles, 8 corners"), 0u) << last;
  EXPECT_FALSE(sim.mesh_reports()[0]);
  EXPECT_NEAR(sim.mesh_reports()[1]->volume_m3.value(), 6.0, 1e-14);
}

TEST(Walls, ATiltingPlaneIsRefused) {
  scene::Case c = empty_case({});
  c.walls = {floor_plane()};
  c.motions = {{.walls = {"floor"}, .path = scene::Rotation{.axis = {0, 0, -2}, .rate_rad_s = 1}}};
  EXPECT_NO_THROW(Walls{c});
  c.motions = {{.walls = {"floor"}, .path = scene::Rotation{.axis = {0, 1, 0}, .rate_rad_s = 1}}};
  EXPECT_THROW(Walls{c}, InputError);
}

}  // namespace
}  // namespace repose::dem

#include <gtest/gtest.h>

#include <map>

#include "repose/base/error.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

/// Two layers of two materials in a slice with solid side walls, periodic in y.
scene::Case layered_case() {
  scene::Case c = empty_case({.density = 2500.0});
  c.materials.push_back({"heavy", 5000.0, 1e8, 0.25});
  c.pairs.push_back({"heavy", "heavy", 0.5, 0.3, 0.0});
  c.pairs.push_back({"heavy", "grain", 0.5, 0.3, 0.0});
  c.pairs.push_back({"heavy", "wall", 0.5, 0.3, 0.0});
  c.lower_m = {-0.2, 0.0, -0.1};
  c.upper_m = {0.2, 0.05, 0.6};
  c.periodic.y = true;
  c.walls = scene::box_walls("bin", "wall", {-0.1, 0, 0}, {0.1, 0.05, 0.6}, {"+z", "-y", "+y"});
  c.fill = scene::Fill{{-0.1, 0, 0},
                       {0.1, 0.05, 0.6},
                       0.33,
                       {layer_of("grain", 0.6, {{0.008, 0.008, 0.3}, {0.010, 0.014, 0.7}}),
                        layer_of("heavy", 0.9, {{0.012, 0.012, 1.0}})}};
  return c;
}

TEST(Fill, MeetsTheMassOfEachLayerToHalfOfItsSmallestSphere) {
  Simulation sim(layered_case());
  std::map<int, double> mass;
  for (const Sphere& s : sim.spheres()) mass[s.material] += s.mass_kg;
  EXPECT_NEAR(mass[0], 0.6, 0.5 * sphere_mass(0.004, 2500.0));
  EXPECT_NEAR(mass[2], 0.9, 0.5 * sphere_mass(0.006, 5000.0));
}

TEST(Fill, SpreadsMassUniformlyOverTheDiametersOfAClass) {
  scene::Case c = layered_case();
  c.fill->layers = {layer_of("grain", 1.5, {{0.006, 0.012, 1.0}})};
  double below = 0.0;
  double total = 0.0;
  std::size_t n = 0;
  for (const Sphere& s : Simulation(c).spheres()) {
    EXPECT_GE(2.0 * s.radius_m, 0.006);
    EXPECT_LE(2.0 * s.radius_m, 0.012);
    total += s.mass_kg;
    if (2.0 * s.radius_m < 0.009) below += s.mass_kg;
    ++n;
  }
  // Half of the mass is below the middle. The mass of n spheres scatters by about 1/sqrt(n) of
  // itself; five of these are met with a false alarm in a million seeds.
  EXPECT_NEAR(below / total, 0.5, 5.0 / std::sqrt(static_cast<double>(n)));
}

TEST(Fill, LeavesNoOverlapWithSpheresAndWalls) {
  scene::Case c = layered_case();
  c.particles = {grain(0.012, {0.05, 0.02, 0.05})};  // must be avoided too
  const auto spheres = Simulation(c).spheres();
  ASSERT_GT(spheres.size(), 500u);
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Sphere& a = spheres[i];
    EXPECT_GE(a.position.z(), a.radius_m);
    EXPECT_LE(std::abs(a.position.x()) + a.radius_m, 0.1);
    EXPECT_LE(a.position.z() + a.radius_m, 0.6);
    for (std::size_t j = 0; j < i; ++j) {
      Vec3 d = a.position - spheres[j].position;
      d.y() -= 0.05 * std::round(d.y() / 0.05);
      EXPECT_GE(d.norm(), a.radius_m + spheres[j].radius_m);
    }
  }
}

TEST(Fill, HasNoneOfAKindWithoutAShare) {
  scene::Case c = layered_case();
  c.fill->layers.resize(1);
  auto& mixture = c.fill->layers[0].mixture;
  mixture.push_back(mixture[0]);
  mixture[0].mass_fraction = 0.0;
  mixture[0].material = "heavy";
  double mass = 0.0;
  for (const Sphere& s : Simulation(c).spheres()) {
    EXPECT_EQ(s.material, 0);
    mass += s.mass_kg;
  }
  EXPECT_NEAR(mass, 0.6, 0.5 * sphere_mass(0.004, 2500.0));
}

TEST(Fill, KeepsLayersInTheirOrder) {
  double top_of_first = -1.0;
  double bottom_of_second = 1.0;
  for (const Sphere& s : Simulation(layered_case()).spheres()) {
    if (s.material == 0) top_of_first = std::max(top_of_first, s.position.z());
    if (s.material == 2) bottom_of_second = std::min(bottom_of_second, s.position.z());
  }
  EXPECT_LT(top_of_first, bottom_of_second);
}

TEST(Fill, DependsOnTheSeedAndOnNothingElse) {
  scene::Case c = layered_case();
  const auto first = Simulation(c).spheres();
  const auto again = Simulation(c).spheres();
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].position, again[i].position);
  c.seed = 2;
  EXPECT_NE(Simulation(c).spheres()[0].position, first[0].position);
}

TEST(Fill, ThatDoesNotFitSaysHowFarItCame) {
  scene::Case c = layered_case();
  c.fill->layers = {layer_of("grain", 0.5, {{0.045, 0.045, 1.0}})};
  c.upper_m.y() = 0.09;  // two diameters
  c.walls = scene::box_walls("bin", "wall", {-0.1, 0, 0}, {0.1, 0.09, 0.6}, {"+z", "-y", "+y"});
  for (double x : {-0.06, -0.02, 0.02, 0.06})  // shafts narrower than a sphere
    c.walls.push_back(rectangle("at " + std::to_string(x), {x, 0, 0}, {0, 0.09, 0}, {0, 0, 0.6}));
  c.fill->upper = {0.1, 0.09, 0.6};
  try {
    Simulation{c};
    FAIL();
  } catch (const SimulationError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("placed"), std::string::npos) << text;
    EXPECT_NE(text.find("solid_fraction"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace repose::dem

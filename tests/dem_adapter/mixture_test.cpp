// Grains, grids and slices.
#include "repose/dem_adapter/mixture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
const scene::Region kEverywhere{
    .name = "all", .lower = {-kFar, -kFar, -kFar}, .upper = {kFar, kFar, kFar}};

scene::Case two_materials() {
  scene::Case c;
  c.materials = {
      {"light", 1000.0, 1e7, 0.3}, {"wall", 7800.0, 1e9, 0.3}, {"heavy", 4000.0, 1e7, 0.3}};
  c.lower_m = {0.0, 0.0, 0.0};
  c.upper_m = {1.0, 1.0, 1.0};
  return c;
}

void add(scene::Snapshot& s, std::int64_t body, std::int64_t material, double mass, scene::Vec3 x) {
  s.id.push_back(static_cast<std::int64_t>(s.id.size()));
  s.body.push_back(body);
  s.material.push_back(material);
  s.radius_m.push_back(0.01);
  s.mass_kg.push_back(mass);
  s.position.push_back(x);
  s.velocity.push_back(scene::Vec3::Zero());
  s.angular_velocity.push_back(scene::Vec3::Zero());
}

scene::Snapshot snapshot() {
  scene::Snapshot s;
  s.materials = {"light", "wall", "heavy"};
  add(s, 0, 0, 2.0, {0.5, 0.5, 0.5});
  add(s, 1, 2, 1.0, {0.2, 0.98, 0.5});  // a clump of two spheres
  add(s, 1, 2, 3.0, {0.2, 0.02, 0.5});
  return s;
}

TEST(MixtureOf, CountsAClumpOnceAtItsCentreAcrossAPeriodicSide) {
  auto c = two_materials();
  const auto open = mixture_of(snapshot(), c, kEverywhere);
  ASSERT_EQ(open.size(), 2U);
  EXPECT_EQ(open.components, (std::vector<std::string>{"light", "heavy"}));  // no wall
  EXPECT_NEAR(open.position[1].y(), (0.98 + 3 * 0.02) / 4, 1e-15);
  EXPECT_EQ(open.mass_kg[1], 4.0);
  EXPECT_NEAR(open.volume_m3[1], 1e-3, 1e-18);
  EXPECT_NEAR(open.volume_m3[0], 2e-3, 1e-18);
  c.periodic.y = true;
  // 0.98 is -0.02 there; the centre lies at (-0.02 + 3 x 0.02) / 4.
  EXPECT_NEAR(mixture_of(snapshot(), c, kEverywhere).position[1].y(), 0.01, 1e-15);
}

TEST(MixtureOf, TakesWhatLiesInTheRegion) {
  auto low = kEverywhere;
  low.upper.y() = 0.4;
  const auto m = mixture_of(snapshot(), two_materials(), low);
  EXPECT_EQ(m.components, (std::vector<std::string>{"heavy"}));
  low.upper.y() = -1.0;
  EXPECT_THROW(mixture_of(snapshot(), two_materials(), low), InputError);
}

TEST(ReferenceDiameter, IsTheMeanOfTheMediansByMass) {
  Mixture m{.components = {"a", "b"}};
  const auto grain = [&](int component, double diameter) {
    m.component.push_back(component);
    m.position.push_back(scene::Vec3::Zero());
    m.volume_m3.push_back(M_PI / 6.0 * std::pow(diameter, 3));
    m.mass_kg.push_back(2000.0 * m.volume_m3.back());
  };
  // Of a: eight grains of 10 mm weigh as much as one of 20 mm, nine weigh more.
  for (int i = 0; i < 9; ++i) grain(0, 0.010);
  grain(0, 0.020);
  grain(1, 0.030);
  EXPECT_NEAR(reference_diameter_m(m), 0.020, 1e-12);
}

Mixture cloud() {
  RandomStream random(77);
  Mixture m{.components = {"a", "b", "c"}};
  for (int i = 0; i < 3000; ++i) {
    m.component.push_back(static_cast<int>(random.below(3)));
    m.position.push_back({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
    m.mass_kg.push_back(random.uniform(0.5, 2.0));
    m.volume_m3.push_back(m.mass_kg.back() / 3000.0);
  }
  return m;
}

TEST(BinsOf, KeepEveryGrainOnce) {
  const auto m = cloud();
  double mass = 0.0;
  for (const double grain : m.mass_kg) mass += grain;
  for (const GridKind kind : {GridKind::x, GridKind::y, GridKind::vertical, GridKind::radial,
                              GridKind::circumferential, GridKind::cubic}) {
    const auto bins = bins_of(m, {.kind = kind,
                                  .size = kind == GridKind::circumferential ? 30.0 : 0.21,
                                  .origin = {0.1, -0.2, 0.3}});
    EXPECT_EQ(bins.number.sum(), 3000.0) << to_string(kind);
    EXPECT_NEAR(bins.mass_kg.sum(), mass, 1e-9);
    EXPECT_EQ(static_cast<Eigen::Index>(bins.cell.size()), bins.number.rows());
    EXPECT_GT(bins.number.rowwise().sum().minCoeff(), 0.0);
    EXPECT_EQ(grid_kind(to_string(kind)), kind);
  }
  EXPECT_THROW(grid_kind("diagonal"), InputError);
}

TEST(BinsOf, AreRingsSectorsSlicesAndCubes) {
  Mixture m{.components = {"a"}, .component = {0, 0, 0, 0}};
  m.position = {{0.25, 0.0, 0.1}, {0.0, 0.35, 0.2}, {-0.25, 0.0, 0.3}, {0.1, -0.35, -0.1}};
  m.mass_kg = m.volume_m3 = {1.0, 1.0, 1.0, 1.0};
  const auto cells = [&](GridKind kind, double size) {
    std::vector<int> first;
    for (const auto& cell : bins_of(m, {.kind = kind, .size = size}).cell) first.push_back(cell[0]);
    return first;
  };
  EXPECT_EQ(cells(GridKind::radial, 0.1), (std::vector<int>{2, 3}));
  EXPECT_EQ(cells(GridKind::circumferential, 90.0), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(cells(GridKind::vertical, 0.2), (std::vector<int>{-1, 0, 1}));
  EXPECT_EQ(bins_of(m, {.kind = GridKind::cubic, .size = 0.5}).cell.size(), 3U);
  EXPECT_EQ(bins_of(m, {.kind = GridKind::cubic, .size = 5.0, .origin = {-1, -1, -1}}).cell.size(),
            1U);
}

TEST(BinsOf, TurnAndMoveWithTheirGrains) {
  const auto m = cloud();
  auto turned = m;
  for (auto& x : turned.position) x = scene::Vec3{-x.y() + 5.0, x.x(), x.z() - 2.0};
  for (const GridKind kind : {GridKind::vertical, GridKind::radial}) {
    const auto there = bins_of(turned, {.kind = kind, .size = 0.3, .origin = {5.0, 0.0, -2.0}});
    const auto here = bins_of(m, {.kind = kind, .size = 0.3});
    // A grain within rounding of an edge may change its bin; among 3,000 there is none.
    EXPECT_EQ(there.number, here.number) << to_string(kind);
  }
  const auto sectors = [](const Mixture& grains, const scene::Vec3& axis) {
    return bins_of(grains, {.kind = GridKind::circumferential, .size = 45.0, .origin = axis})
        .number;
  };
  const Eigen::MatrixXd here = sectors(m, {0, 0, 0}), there = sectors(turned, {5.0, 0.0, 0.0});
  for (Eigen::Index s = 0; s < 8; ++s)
    EXPECT_EQ(there.row((s + 2) % 8), here.row(s));  // 90 degrees
}

TEST(BinsOf, RefuseSizesThatMakeNoSense) {
  for (const double size : {0.0, -1.0, 1e-9, std::nan(""), kFar})
    EXPECT_THROW(bins_of(cloud(), {.kind = GridKind::x, .size = size}), InputError) << size;
  for (const double size : {0.0, 50.0, 360.0, 1000.0})
    EXPECT_THROW(bins_of(cloud(), {.kind = GridKind::circumferential, .size = size}), InputError)
        << size;
}

TEST(PixelsInSlices, CountWhatIsSeenBetweenItsEnds) {
  View view;
  view.picture = Picture(24, 20);
  view.components = {"a", "b"};
  view.label.assign(view.picture.pixels.size(), kBackground);
  for (int row = 5; row < 15; ++row)  // a left of b, 6 + 6 columns, 10 rows
    for (int column = 4; column < 16; ++column)
      view.label[view.picture.index(column, row)] = column < 10 ? 0 : 1;
  Eigen::MatrixXd expected(4, 2);
  expected << 30, 0, 30, 0, 0, 30, 0, 30;
  EXPECT_EQ(pixels_in_slices(view, SliceDirection::horizontal, 4), expected);
  EXPECT_EQ(pixels_in_slices(view, SliceDirection::vertical, 2),
            Eigen::MatrixXd::Constant(2, 2, 30.0));
  for (int row = 5; row < 15; ++row)  // a gap is no slice
    for (int column = 7; column < 10; ++column)
      view.label[view.picture.index(column, row)] = kBackground;
  EXPECT_EQ(pixels_in_slices(view, SliceDirection::horizontal, 4).rows(), 3);
  EXPECT_THROW(pixels_in_slices(view, SliceDirection::vertical, 1), InputError);
}

}  // namespace
}  // namespace repose::dem_adapter

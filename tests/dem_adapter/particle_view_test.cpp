// Heaps of particles as a camera sees them.
#include <gtest/gtest.h>

#include <cmath>

#include "repose/base/error.hpp"
#include "repose/base/random.hpp"
#include "repose/dem_adapter/view.hpp"
#include "repose/dem_adapter/view_angle.hpp"

namespace repose::dem_adapter {
namespace {

void add(scene::Snapshot& s, double x, double y, double z, double radius, std::int64_t material,
         double speed = 0.0) {
  s.id.push_back(static_cast<std::int64_t>(s.id.size()));
  s.body.push_back(s.id.back());
  s.material.push_back(material);
  s.radius_m.push_back(radius);
  s.mass_kg.push_back(1.0);
  s.position.push_back({x, y, z});
  s.velocity.push_back({0.0, 0.0, -speed});
  s.angular_velocity.push_back(scene::Vec3::Zero());
}

/// Spheres of one size thrown at random into a cone around the z axis.
scene::Snapshot heap(double angle_deg, double base_m, double diameter_m, int spheres) {
  scene::Snapshot s;
  s.materials = {"a", "b"};
  RandomStream random(17);
  const double slope = std::tan(angle_deg * M_PI / 180.0);
  while (static_cast<int>(s.size()) < spheres) {
    const double x = random.uniform(-base_m, base_m), y = random.uniform(-base_m, base_m);
    const double z = random.uniform(0.0, base_m * slope);
    if (z < (base_m - std::hypot(x, y)) * slope) add(s, x, y, z, 0.5 * diameter_m, random.below(2));
  }
  return s;
}

TEST(ParticleHeap, GivesItsAngleToWhatItsGrainsAllow) {
  // The edge lies up to half a diameter outside the cone, unevenly; a line over the base b turns by
  // less than d / b, and half of that where the spheres are many.
  for (const double angle : {25.0, 35.0})
    for (const double diameter : {0.02, 0.01}) {
      const double base = 0.3;
      const auto s = heap(angle, base, diameter, 6000);
      const auto found = measure_angle(view_of_particles(s));
      const double tolerance = diameter / base * 180.0 / M_PI;
      EXPECT_NEAR(found.measurement.kpis.at("angle_of_repose_deg"), angle, tolerance) << diameter;
      const auto side = measure_angle(view_of_particles(s, {.direction = ViewDirection::along_x}));
      EXPECT_NEAR(side.measurement.kpis.at("angle_of_repose_deg"), angle, tolerance) << diameter;
    }
}

TEST(ParticleHeap, MeasuredOnItsOwnPhotographGivesTheSameAngle) {
  // One method for both: the picture that a camera would take of these particles is measured again.
  const auto view = view_of_particles(heap(30.0, 0.3, 0.015, 5000));
  Picture framed(view.picture.width, view.picture.height + 20);  // sky above the highest grain
  for (int row = 0; row < view.picture.height; ++row)
    for (int column = 0; column < view.picture.width; ++column)
      framed.at(column, row + 20) = view.picture.at(column, row);
  const auto photograph = view_of_photograph(framed, {.threshold = 15.0}, view.pixel_m);
  const double toe = view.largest_grain_m;
  const auto particles = measure_angle(view, {.axis_m = 0.0, .toe_m = toe});
  const auto pixels = measure_angle(photograph, {.axis_m = -view.left_m, .toe_m = toe});
  // Edges agree within a pixel; a pixel is a tenth of a diameter, the base is 20 diameters.
  EXPECT_NEAR(pixels.angles.mean_deg(), particles.angles.mean_deg(), 0.1 / 20.0 * 180.0 / M_PI);
}

TEST(ParticleView, TheNearestSphereHidesTheOthers) {
  scene::Snapshot s;
  s.materials = {"a", "b"};
  add(s, 0.0, 0.5, 0.0, 0.1, 0);
  add(s, 0.0, 0.1, 0.0, 0.05, 1);
  const auto front = view_of_particles(s);
  const auto center = front.picture.index(front.picture.width / 2, front.picture.height / 2);
  EXPECT_EQ(front.label[center], 1);
  EXPECT_EQ(front.label[front.picture.index(1, front.picture.height / 2)], 0);
  EXPECT_EQ(front.label[0], kBackground);
  scene::Snapshot turned = s;
  for (std::size_t i = 0; i < 2; ++i) turned.position[i] = {-s.position[i].y(), 0.0, 0.0};
  EXPECT_EQ(view_of_particles(turned, {.direction = ViewDirection::along_x}).label, front.label);
}

TEST(ParticleView, AreaOfAComponentIsThatOfItsDisc) {
  scene::Snapshot s;
  s.materials = {"a"};
  add(s, 0.3, 0.0, 0.2, 0.1, 0);
  const auto view = view_of_particles(s, {.pixel_m = 0.0005});
  const auto seen = static_cast<double>(std::count(view.label.begin(), view.label.end(), 0));
  // Gauss' circle problem: the error is of the order of the pixels on the rim to the power 2/3.
  EXPECT_NEAR(seen * 0.0005 * 0.0005, M_PI * 0.01, 400 * 0.0005 * 0.0005);
}

TEST(ParticleView, LeavesOutWhatFliesAndWhatLiesOutside) {
  scene::Snapshot s;
  s.materials = {"a"};
  add(s, 0.0, 0.0, 0.0, 0.1, 0);
  add(s, 0.0, 0.0, 5.0, 0.1, 0, 0.3);
  EXPECT_NEAR(view_of_particles(s).picture.height * view_of_particles(s).pixel_m, 0.2, 1e-9);
  s.velocity[1].setZero();
  EXPECT_GT(view_of_particles(s).picture.height * view_of_particles(s).pixel_m, 5.0);
  EXPECT_NEAR(view_of_particles(s, {.top_m = 1.0}).profile.top_m[5], 0.06, 0.05);
  EXPECT_THROW(view_of_particles(s, {.left_m = 1.0}), InputError);
  EXPECT_THROW(view_of_particles(scene::Snapshot{}), InputError);
}

}  // namespace
}  // namespace repose::dem_adapter

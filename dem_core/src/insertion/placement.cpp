#include "insertion/placement.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "particles/rotation.hpp"

namespace repose::dem {
namespace {

struct Ball {
  Vec3 x;
  double radius;
};

/// The spheres of a particle, brought into the period.
void balls_of(const scene::Particle& particle, const scene::ClumpForm* form, const Box& box,
              std::vector<Ball>& balls) {
  balls.clear();
  if (form == nullptr) {
    balls.push_back({particle.position, particle.radius_m});
    return;
  }
  const Eigen::Matrix3d turn = rotation_matrix(quaternion_of(particle.orientation_wxyz));
  for (const scene::ClumpShape::Sphere& sphere : form->spheres)
    balls.push_back({box.wrapped(particle.position + particle.radius_m * (turn * sphere.position)),
                     particle.radius_m * sphere.radius});
}

/// A uniform position of the centre, a radius off those sides that hold the spheres.
Vec3 draw_position(const PlacingBox& where, const Box& box, double radius, RandomStream& random) {
  Vec3 x;
  for (int k = 0; k < 3; ++k) {
    const double margin = box.periodic[k] || k == where.free_axis ? 0.0 : radius;
    x[k] = random.uniform(where.lower[k] + margin, where.upper[k] - margin);
  }
  return x;
}

bool is_inside(const PlacingBox& where, const Box& box, const Ball& ball) {
  for (int k = 0; k < 3; ++k) {
    if (box.periodic[k] || k == where.free_axis) continue;
    if (ball.x[k] - ball.radius < where.lower[k] || ball.x[k] + ball.radius > where.upper[k])
      return false;
  }
  return true;
}

}  // namespace

std::array<double, 4> random_orientation(RandomStream& random) {
  const double split = random.uniform();
  const double a = 2.0 * std::numbers::pi * random.uniform();
  const double b = 2.0 * std::numbers::pi * random.uniform();
  const double lower = std::sqrt(1.0 - split);
  const double upper = std::sqrt(split);
  return {upper * std::cos(b), lower * std::sin(a), lower * std::cos(a), upper * std::sin(b)};
}

bool find_place(const PlacingBox& where, const Box& box, const OccupiedSpace& occupied,
                const ClearOfWalls& clear_of_walls, const scene::ClumpForm* form, int tries,
                RandomStream& random, scene::Particle& particle) {
  // The centre of a clump may lie between its spheres; theirs are checked one by one.
  const double margin = form == nullptr ? particle.radius_m : 0.0;
  std::vector<Ball> balls;
  for (int t = 0; t < tries; ++t) {
    particle.position = draw_position(where, box, margin, random);
    if (form != nullptr) particle.orientation_wxyz = random_orientation(random);
    balls_of(particle, form, box, balls);
    bool fits = true;
    for (std::size_t b = 0; b < balls.size() && fits; ++b)
      fits = (form == nullptr || is_inside(where, box, balls[b])) &&
             occupied.is_free(balls[b].x, balls[b].radius) &&
             clear_of_walls(balls[b].x, balls[b].radius);
    if (fits) return true;
  }
  return false;
}

void occupy(const scene::Particle& particle, const scene::ClumpForm* form, const Box& box,
            OccupiedSpace& occupied) {
  std::vector<Ball> balls;
  balls_of(particle, form, box, balls);
  for (const Ball& ball : balls) occupied.add(ball.x, ball.radius);
}

}  // namespace repose::dem

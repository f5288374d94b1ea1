#include "motion/wall_motion.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "geometry/walls.hpp"
#include "small_cases.hpp"

namespace repose::dem {
namespace {

scene::Motion moved_by(decltype(scene::Motion::path) path, double start = 0.0,
                       double end = std::numeric_limits<double>::infinity()) {
  return {.walls = {"floor"}, .path = std::move(path), .start_s = start, .end_s = end};
}

WallMotion motion_of(const std::vector<scene::Motion>& motions) {
  scene::Case c = empty_case({});
  c.walls = {floor_plane()};
  c.motions = motions;
  return {c, 0};
}

const scene::Rotation kTurn{.centre = {0.1, 0.2, 0.3}, .axis = {1, 2, -2}, .rate_rad_s = 2.5};
const scene::Oscillation kShake{.amplitude_m = {0.01, 0, 0.02}, .frequency_hz = 3, .phase_rad = 1};
const scene::Translation kLift{.velocity_m_s = {0.1, -0.2, 0.3}};

TEST(WallMotion, VelocityIsTheDerivativeOfThePose) {
  for (const auto& motions : std::vector<std::vector<scene::Motion>>{
           {moved_by(kTurn)},
           {moved_by(kShake)},
           {moved_by(kLift), moved_by(kTurn), moved_by(kShake)},
           {moved_by(kTurn), moved_by(kLift),
            moved_by(scene::Rotation{.axis = {0, 0, 1}, .rate_rad_s = -1})}}) {
    const WallMotion motion = motion_of(motions);
    const Vec3 drawn(0.4, -0.5, 0.6);
    for (const double t : {0.0, 0.3, 7.7}) {
      const double h = 1e-5;
      const WallState now = motion.at(t);
      const Vec3 slope = (motion.at(t + h).pose.to_world(drawn) -
                          motion.at(t == 0.0 ? 0.0 : t - h).pose.to_world(drawn)) /
                         (t == 0.0 ? h : 2 * h);
      // Central differences are off by h^2/6 times the third derivative, one-sided ones by h/2
      // times the second; rates are below 20/s and points within 1 m.
      EXPECT_LT((slope - now.twist.at(now.pose.to_world(drawn))).norm(), t == 0.0 ? 1e-3 : 1e-6);
      EXPECT_LT((now.pose.turn * now.pose.turn.transpose() - Eigen::Matrix3d::Identity()).norm(),
                1e-14);
      EXPECT_LT((now.pose.to_drawn(now.pose.to_world(drawn)) - drawn).norm(), 1e-14);
    }
  }
}

TEST(WallMotion, ARotationComesRoundAndKeepsItsCentre) {
  const WallMotion motion = motion_of({moved_by(kTurn)});
  const double period = 2 * std::numbers::pi / 2.5;
  EXPECT_LT((motion.at(1000 * period).pose.to_world({1, 1, 1}) - Vec3(1, 1, 1)).norm(), 1e-11);
  EXPECT_LT((motion.at(0.7).pose.to_world(kTurn.centre) - kTurn.centre).norm(), 1e-15);
  // A quarter turn about z takes x to y.
  const WallMotion about_z =
      motion_of({moved_by(scene::Rotation{.axis = {0, 0, 3}, .rate_rad_s = 1})});
  EXPECT_LT((about_z.at(std::numbers::pi / 2).pose.to_world({1, 0, 0}) - Vec3(0, 1, 0)).norm(),
            1e-15);
}

TEST(WallMotion, StartsAndEndsWhenItShould) {
  const WallMotion motion = motion_of({moved_by(kLift, 1.0, 3.0)});
  EXPECT_EQ(motion.at(0.5).pose.to_world({0, 0, 0}), Vec3::Zero());
  EXPECT_EQ(motion.at(0.5).twist.velocity, Vec3::Zero());
  EXPECT_LT((motion.at(2.0).pose.to_world({0, 0, 0}) - kLift.velocity_m_s).norm(), 1e-16);
  EXPECT_EQ(motion.at(2.0).twist.velocity, kLift.velocity_m_s);
  EXPECT_LT((motion.at(9.0).pose.to_world({0, 0, 0}) - 2 * kLift.velocity_m_s).norm(), 1e-16);
  EXPECT_EQ(motion.at(9.0).twist.velocity, Vec3::Zero());
}

TEST(WallMotion, OfAStageWaitsForIt) {
  scene::Motion lift = moved_by(kLift, 0.5);
  lift.stage = "pull";
  WallMotion motion = motion_of({lift});
  EXPECT_EQ(motion.at(100.0).pose.to_world({0, 0, 0}), Vec3::Zero());
  motion.begin_stage("settle", 1.0);
  EXPECT_EQ(motion.at(100.0).pose.to_world({0, 0, 0}), Vec3::Zero());
  motion.begin_stage("pull", 10.0);
  EXPECT_EQ(motion.at(10.4).pose.to_world({0, 0, 0}), Vec3::Zero());
  EXPECT_LT((motion.at(11.5).pose.to_world({0, 0, 0}) - kLift.velocity_m_s).norm(), 1e-15);
}

TEST(WallMotion, ATableIsLinearBetweenItsTimesAndHeldOutside) {
  const WallMotion motion =
      motion_of({moved_by(scene::TimeTable{{1.0, 2.0, 4.0}, {{0, 0, 1}, {0, 0, 2}, {0, 0, 0}}})});
  const auto height = [&](double t) { return motion.at(t).pose.to_world({0, 0, 0}).z(); };
  const auto speed = [&](double t) { return motion.at(t).twist.velocity.z(); };
  EXPECT_DOUBLE_EQ(height(0.5), 1.0);
  EXPECT_DOUBLE_EQ(height(1.25), 1.25);
  EXPECT_DOUBLE_EQ(height(2.0), 2.0);
  EXPECT_DOUBLE_EQ(height(3.5), 0.5);
  EXPECT_DOUBLE_EQ(height(9.0), 0.0);
  EXPECT_DOUBLE_EQ(speed(0.5), 0.0);
  EXPECT_DOUBLE_EQ(speed(1.5), 1.0);
  EXPECT_DOUBLE_EQ(speed(3.5), -1.0);
  EXPECT_DOUBLE_EQ(speed(4.5), 0.0);
}

TEST(WallMotion, TorquesReferToTheCentreOfTheFirstRotation) {
  EXPECT_EQ(motion_of({moved_by(kLift)}).at(1.0).reference, Vec3::Zero());
  EXPECT_LT((motion_of({moved_by(kTurn)}).at(1.0).reference - kTurn.centre).norm(), 1e-15);
  // Lifted after it turns: the centre goes along; before: it stays.
  const Vec3 lifted = motion_of({moved_by(kTurn), moved_by(kLift)}).at(2.0).reference;
  EXPECT_LT((lifted - kTurn.centre - 2.0 * kLift.velocity_m_s).norm(), 1e-15);
  const Vec3 stays = motion_of({moved_by(kLift), moved_by(kTurn)}).at(2.0).reference;
  EXPECT_LT((stays - kTurn.centre).norm(), 1e-15);
}

/// Walls that are moved by one movement, at time t after they were listed at 0.
double displaced(const scene::Wall& wall, decltype(scene::Motion::path) path, double t) {
  scene::Case c = empty_case({});
  c.walls = {wall};
  c.motions = {{.walls = {wall.name}, .path = std::move(path)}};
  Walls walls(c);
  walls.advance(t, 0.0);
  return walls.displacement();
}

TEST(WallMotion, DisplacementBoundsEveryPointAndIsNoneForASurfaceThatMovesInItself) {
  const scene::Wall disc{"w", "wall", scene::Disc{{0, 0, 1}, {0, 0, 1}, 0.5, 0.1}};
  const scene::Wall tube{"w", "wall", scene::Cone{{0, 0, 0}, {0, 0, 1}, 0.5, 0.3}};
  const scene::Wall plate = rectangle("w", {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const scene::Rotation own_axis{.axis = {0, 0, 1}, .rate_rad_s = 1};
  const scene::Rotation across{.axis = {0, 1, 0}, .rate_rad_s = 1};
  EXPECT_LT(displaced(disc, own_axis, 1.0), 1e-15);
  EXPECT_LT(displaced(tube, own_axis, 1.0), 1e-15);
  scene::Wall plane = floor_plane();
  EXPECT_LT(displaced(plane, scene::Translation{{3, 4, 0}}, 1.0), 1e-15);
  EXPECT_NEAR(displaced(plane, scene::Translation{{3, 4, 0.5}}, 1.0), 0.5, 1e-15);
  EXPECT_NEAR(displaced(tube, scene::Translation{{3, 4, 0}}, 1.0), 5.0, 1e-14);
  // A turn by a small angle moves the corners of the plate by angle * distance from the axis.
  EXPECT_NEAR(displaced(plate, own_axis, 1e-3), 1e-3 * std::sqrt(2.0), 1e-8);
  // The tube's far rim moves by at most |axis turned| (height + radius), exactly |turn| * norm.
  const double bound = displaced(tube, across, 1e-3);
  EXPECT_GE(bound, 1e-3 * std::hypot(1.0, 0.3) - 1e-9);
  EXPECT_LE(bound, 1e-3 * 1.3 + 1e-9);
}

}  // namespace
}  // namespace repose::dem

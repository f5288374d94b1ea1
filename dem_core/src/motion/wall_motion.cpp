#include "motion/wall_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace repose::dem {
namespace {

/// One movement by itself, at a time since its start that lies between 0 and its end. `rate` is 1
/// while it goes on and 0 before and afterwards, when the wall rests.
struct Step {
  Pose pose;
  Twist twist;
};

Step shifted(const Vec3& shift, const Vec3& velocity) {
  return {{Eigen::Matrix3d::Identity(), shift, false}, {velocity, Vec3::Zero()}};
}

Step step_of(const scene::Translation& path, double t, double rate) {
  return shifted(t * path.velocity_m_s, rate * path.velocity_m_s);
}

Step step_of(const scene::Rotation& path, double t, double rate) {
  const Vec3 axis = path.axis / path.axis.norm();
  Step step;
  step.pose.turn = turn_about(axis, std::fmod(t * path.rate_rad_s, 2.0 * std::numbers::pi));
  step.pose.shift = path.centre - step.pose.turn * path.centre;
  step.pose.is_identity = false;
  step.twist.spin = rate * path.rate_rad_s * axis;
  step.twist.velocity = cross(path.centre, step.twist.spin);
  return step;
}

Step step_of(const scene::Oscillation& path, double t, double rate) {
  const double omega = 2.0 * std::numbers::pi * path.frequency_hz;
  const double phase = omega * t + path.phase_rad;
  return shifted((std::sin(phase) - std::sin(path.phase_rad)) * path.amplitude_m,
                 rate * omega * std::cos(phase) * path.amplitude_m);
}

Step step_of(const scene::TimeTable& path, double t, double rate) {
  const auto& times = path.times_s;
  const auto after =
      static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), t) - times.begin());
  if (after == 0) return shifted(path.displacements_m.front(), Vec3::Zero());
  if (after == times.size()) return shifted(path.displacements_m.back(), Vec3::Zero());
  const Vec3& from = path.displacements_m[after - 1];
  const Vec3& to = path.displacements_m[after];
  const double span = times[after] - times[after - 1];
  return shifted(from + (t - times[after - 1]) / span * (to - from), rate / span * (to - from));
}

}  // namespace

Eigen::Matrix3d turn_about(const Vec3& axis, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Eigen::Matrix3d turn = c * Eigen::Matrix3d::Identity() + (1.0 - c) * axis * axis.transpose();
  turn(0, 1) -= s * axis.z();
  turn(0, 2) += s * axis.y();
  turn(1, 0) += s * axis.z();
  turn(1, 2) -= s * axis.x();
  turn(2, 0) -= s * axis.y();
  turn(2, 1) += s * axis.x();
  return turn;
}

WallMotion::WallMotion(const scene::Case& scene, std::size_t wall) {
  for (std::size_t m = 0; m < scene.motions.size(); ++m) {
    const scene::Motion& motion = scene.motions[m];
    bool named = false;
    for (const std::string& name : motion.walls)
      for (const int w : scene::walls_named(scene, name))
        named = named || static_cast<std::size_t>(w) == wall;
    if (!named) continue;
    movements_.push_back({motion, {}});
    if (motion.stage.empty()) movements_.back().begin_s = 0.0;
    numbers_.push_back(m);
  }
}

void WallMotion::begin_stage(const std::string& name, double time_s) {
  for (Movement& movement : movements_)
    if (movement.motion.stage == name && !name.empty()) movement.begin_s = time_s;
}

WallState WallMotion::at(double time_s) const {
  WallState state;
  bool rotates = false;
  for (const Movement& movement : movements_) {
    const scene::Motion& motion = movement.motion;
    const bool turns = std::holds_alternative<scene::Rotation>(motion.path);
    if (turns && !rotates) {
      state.reference = std::get<scene::Rotation>(motion.path).centre;
      rotates = true;
    }
    if (!movement.begin_s) continue;
    const double since = time_s - *movement.begin_s;
    if (since < motion.start_s) continue;
    const double t = std::min(since, motion.end_s) - motion.start_s;
    const double rate = since < motion.end_s ? 1.0 : 0.0;
    const Step step =
        std::visit([&](const auto& path) { return step_of(path, t, rate); }, motion.path);
    // x' = Q x + p moves with its own twist and with the turned one of what came before.
    const Vec3 spin = step.pose.turn * state.twist.spin;
    state.twist.velocity =
        step.twist.velocity + step.pose.turn * state.twist.velocity - cross(spin, step.pose.shift);
    state.twist.spin = step.twist.spin + spin;
    state.pose.shift = step.pose.to_world(state.pose.shift);
    state.pose.turn = step.pose.turn * state.pose.turn;
    state.pose.is_identity = false;
    if (rotates) state.reference = step.pose.to_world(state.reference);
  }
  return state;
}

}  // namespace repose::dem

// Motion of walls.
#include <cmath>
#include <set>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "validate/checks.hpp"

namespace repose::scene {
namespace {

bool are_parallel(const Vec3& a, const Vec3& b) {
  return std::abs(a.dot(b)) >= (1.0 - 1e-12) * a.norm() * b.norm();
}

/// Checks one path; `what` begins the messages, "motion N: ".
struct PathCheck {
  const std::string& what;
  const Motion& motion;

  void operator()(const Translation& path) const {
    require_finite(what + "velocity_m_s", path.velocity_m_s);
  }
  void operator()(const Rotation& path) const {
    require_finite(what + "centre_m", path.centre);
    require_finite(what + "axis", path.axis);
    if (!(path.axis.norm() > 0.0))
      throw InputError(what + "axis is zero; give the direction that it turns about");
    if (!std::isfinite(path.rate_rad_s))
      refuse(what + "rate_rad_s", path.rate_rad_s, "must be a finite number");
  }
  void operator()(const Oscillation& path) const {
    require_finite(what + "amplitude_m", path.amplitude_m);
    require_positive(what + "frequency_hz", path.frequency_hz);
    if (!std::isfinite(path.phase_rad))
      refuse(what + "phase_rad", path.phase_rad, "must be a finite number");
  }
  void operator()(const TimeTable& path) const {
    check_points(path);
    require_no_jump(path);
  }

  void check_points(const TimeTable& path) const {
    if (path.times_s.empty())
      throw InputError(what + "has no points; add points = [{time_s, displacement_m}, ...]");
    if (path.times_s.size() != path.displacements_m.size())
      throw InputError(what + std::to_string(path.times_s.size()) + " times stand beside " +
                       std::to_string(path.displacements_m.size()) +
                       " displacements; give one for each");
    for (std::size_t k = 0; k < path.times_s.size(); ++k) {
      if (!std::isfinite(path.times_s[k]))
        refuse(what + "time_s", path.times_s[k], "must be a finite number");
      if (k > 0 && !(path.times_s[k] > path.times_s[k - 1]))
        refuse(what + "time_s", path.times_s[k],
               "follows " + shortest(path.times_s[k - 1]) + "; times must ascend");
      require_finite(what + "displacement_m", path.displacements_m[k]);
    }
  }
  /// A wall is where it was drawn until the motion starts.
  void require_no_jump(const TimeTable& path) const {
    if (motion.stage.empty() && motion.start_s == 0.0) return;
    const Vec3& first = path.displacements_m.front();
    for (int k = 0; k < 3; ++k)
      if (first[k] != 0.0)
        refuse(what + "the first displacement_m." + kAxes[k], first[k],
               "the wall would jump there when the motion starts; begin with [0, 0, 0], or let the "
               "motion start with the run (no stage, start_s = 0)");
  }
};

/// Whether a path carries a wall along a direction.
bool moves_along(const Motion& motion, int axis) {
  if (const auto* path = std::get_if<Translation>(&motion.path))
    return path->velocity_m_s[axis] != 0.0;
  if (const auto* path = std::get_if<Oscillation>(&motion.path))
    return path->amplitude_m[axis] != 0.0;
  if (const auto* path = std::get_if<TimeTable>(&motion.path)) {
    for (const Vec3& displacement : path->displacements_m)
      if (displacement[axis] != 0.0) return true;
    return false;
  }
  return !are_parallel(std::get<Rotation>(motion.path).axis, Vec3::Unit(axis));
}

void check_moved_wall(const Case& scene, const std::string& what, const Motion& motion,
                      const Wall& wall) {
  const auto* plane = std::get_if<Plane>(&wall.shape);
  const auto* rotation = std::get_if<Rotation>(&motion.path);
  if (plane != nullptr && rotation != nullptr && !are_parallel(plane->normal, rotation->axis))
    throw InputError(what + "the plane \"" + wall.name +
                     "\" can turn only about its normal; use a rectangle or a disc to tilt it");
  if (plane != nullptr) return;  // it slides in itself, as its images do
  for (int k = 0; k < 3; ++k)
    if (is_periodic(scene, k) && moves_along(motion, k))
      throw InputError(what + "moves the wall \"" + wall.name + "\" along the periodic direction " +
                       kAxes[k] + "; it may move across it only, or turn about it");
}

/// The first stage that takes the wall away, or the number of stages.
std::size_t opened_in(const Case& scene, int wall) {
  for (std::size_t s = 0; s < scene.stages.size(); ++s)
    for (const std::string& name : scene.stages[s].opens)
      for (int opened : walls_named(scene, name))
        if (opened == wall) return s;
  return scene.stages.size();
}

void check_moved_walls(const Case& scene, const std::string& what, const Motion& motion) {
  const std::size_t stage = motion.stage.empty() ? 0 : stage_index(scene, what, motion.stage);
  if (motion.walls.empty()) throw InputError(what + "names no walls; add walls = [\"NAME\"]");
  std::vector<std::string> names;
  for (const Wall& wall : scene.walls) names.push_back(wall.name);
  std::set<int> moved;
  for (const std::string& name : motion.walls) {
    const std::vector<int> walls = walls_named(scene, name);
    if (walls.empty())
      throw InputError(what + "walls = \"" + name + "\" is not a wall; the case has " +
                       (names.empty() ? std::string("none") : listed(names)));
    for (int w : walls) {
      const Wall& wall = scene.walls[static_cast<std::size_t>(w)];
      if (!moved.insert(w).second)
        throw InputError(what + "names the wall \"" + wall.name + "\" twice; name it once");
      const std::size_t opened = opened_in(scene, w);
      if (opened <= stage && opened < scene.stages.size())
        throw InputError(what + "moves the wall \"" + wall.name + "\", which stage \"" +
                         scene.stages[opened].name +
                         "\" has taken away before; move it earlier or do not open it");
      check_moved_wall(scene, what, motion, wall);
    }
  }
}

}  // namespace

void check_motions(const Case& scene) {
  for (std::size_t m = 0; m < scene.motions.size(); ++m) {
    const Motion& motion = scene.motions[m];
    const std::string what = "motion " + std::to_string(m + 1) + ": ";
    check_moved_walls(scene, what, motion);
    std::visit(PathCheck{what, motion}, motion.path);
    require_non_negative(what + "start_s", motion.start_s);
    if (!(motion.end_s > motion.start_s))
      refuse(what + "end_s", motion.end_s, "must be above start_s = " + shortest(motion.start_s));
    const double time = longest_time_after_s(scene, what, motion.stage);
    if (motion.start_s >= time)
      refuse(what + "start_s", motion.start_s,
             "never comes: the stages that follow last " + shortest(time) + " s");
  }
}

}  // namespace repose::scene

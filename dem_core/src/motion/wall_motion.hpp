// The prescribed motion of one wall.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "motion/rigid_motion.hpp"
#include "repose/scene/case.hpp"

namespace repose::dem {

/// Where a wall is at one time, and how it moves.
struct WallState {
  Pose pose;
  Twist twist;
  /// What torques refer to: the centre of the first rotation, taken along by what follows it; the
  /// origin if the wall does not rotate.
  Vec3 reference = Vec3::Zero();
};

/// All movements of one wall in the order of the case, each on the result of the one before.
/// Evaluated from the time, so that nothing accumulates.
class WallMotion {
 public:
  /// The movements of the case that name this wall.
  WallMotion(const scene::Case& scene, std::size_t wall);

  bool empty() const { return movements_.empty(); }
  /// Movements of this stage start to count from now.
  void begin_stage(const std::string& name, double time_s);
  WallState at(double time_s) const;

  /// Whether another wall is moved by the same movements.
  bool same_as(const WallMotion& other) const { return numbers_ == other.numbers_; }

 private:
  struct Movement {
    scene::Motion motion;
    std::optional<double> begin_s;  // of its stage; none until that begins
  };
  std::vector<Movement> movements_;
  std::vector<std::size_t> numbers_;  // in Case::motions
};

}  // namespace repose::dem

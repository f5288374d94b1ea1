// What of a case decides its first stages.
#include <algorithm>

#include "repose/scene/case.hpp"

namespace repose::scene {
namespace {

/// Of a movement that has not begun: its kind, and where the torque on its walls is taken about.
Motion awaited(Motion motion) {
  if (auto* const rotation = std::get_if<Rotation>(&motion.path))
    rotation->rate_rad_s = 0.0;
  else if (std::holds_alternative<Translation>(motion.path))
    motion.path = Translation{};
  else if (std::holds_alternative<Oscillation>(motion.path))
    motion.path = Oscillation{};
  else
    motion.path = TimeTable{};
  motion.stage = "later";
  motion.start_s = 0.0;
  motion.end_s = 0.0;
  return motion;
}

}  // namespace

Case beginning_of(const Case& scene, std::size_t stages) {
  Case beginning = scene;
  beginning.parameters.clear();  // of no effect but through the rest
  beginning.stages.resize(std::min(stages, scene.stages.size()));
  const auto is_later = [&](const std::string& name) {
    return !name.empty() && std::none_of(beginning.stages.begin(), beginning.stages.end(),
                                         [&](const Stage& stage) { return stage.name == name; });
  };
  for (Motion& motion : beginning.motions)
    if (is_later(motion.stage)) motion = awaited(std::move(motion));
  const bool use_pairs = beginning.stages.empty() ||
                         std::any_of(beginning.stages.begin(), beginning.stages.end(),
                                     [](const Stage& stage) { return !stage.coefficients; });
  if (!use_pairs)
    for (PairCoefficients& pair : beginning.pairs) pair.restitution = pair.mu_s = pair.mu_r = 0.0;
  return beginning;
}

}  // namespace repose::scene
